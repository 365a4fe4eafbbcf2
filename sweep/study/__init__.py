"""The study file, checked in full before anything is computed or written."""

from sweep.study.cases import Case, Resolved, load, resolve
from sweep.study.files import read_toml
from sweep.study.names import Name
from sweep.study.schema import Study

__all__ = ["Case", "Name", "Resolved", "Study", "load", "read_toml", "resolve"]
