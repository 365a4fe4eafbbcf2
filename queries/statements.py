"""Longer SQL statements, kept in `.sql` files beside the modules that run them."""

import re
from collections.abc import Mapping
from functools import cache
from importlib import resources

_NAME = re.compile(r"^-- name: (\S+)\n", re.MULTILINE)


@cache
def statements(room: str, file: str) -> Mapping[str, str]:
    """Return the statements of a file by their names, each below a line `-- name: NAME`.

    Parameters
    ----------
    room
        Package that holds the file, such as "queries.answers".
    file
        Its name without ending.
    """
    text = (resources.files(room) / f"{file}.sql").read_text("utf-8")
    _, *parts = _NAME.split(text)
    return {name: statement.strip() for name, statement in zip(parts[::2], parts[1::2], strict=True)}
