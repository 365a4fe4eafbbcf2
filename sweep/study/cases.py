"""A resolved study, and its cases.

Names are resolved to physical objects here; inline definitions take precedence over the library's. Later
steps use objects and ids only; names return in the manifest, as labels.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel

from railvib import library
from railvib.errors import InputError
from railvib.parameters.units import KMH
from railvib.parameters.validation import validated
from sweep import identity
from sweep.identity import Canonical
from sweep.study.files import read_toml
from sweep.study.schema import Study
from sweep.study.tables import plain

AXES: tuple[library.Kind, ...] = ("soil", "track", "train", "unevenness")


class Label(NamedTuple):
    """Names and speed of a case, as the study writes them."""

    soil: str
    track: str
    train: str
    unevenness: str
    speed_kmh: float


@dataclass(frozen=True)
class Case:
    """One combination of the axes: the physics, its id, and every label it has in this study.

    If two names have equal definitions, a case has several labels; its own names are those of the first.
    """

    soil: str
    track: str
    train: str
    unevenness: str
    speed_kmh: float
    case_id: str
    labels: tuple[Label, ...]


@dataclass(frozen=True)
class Resolved:
    """A study with its physical objects, by kind and name."""

    study: Study
    objects: Mapping[str, Mapping[str, BaseModel]]

    @cached_property
    def canonical(self) -> Mapping[str, Mapping[str, Canonical]]:
        """The objects in canonical form, by kind and name."""
        return {
            kind: {name: identity.canonical(thing) for name, thing in named.items()}
            for kind, named in self.objects.items()
        }

    def cases(self) -> Iterator[Case]:
        """Yield each case once, soil by soil, so that cases on one ground follow each other."""
        axes = self.study.sweep
        labels: dict[str, list[Label]] = {}
        for label in map(
            Label._make, product(axes.soil, axes.track, axes.train, axes.unevenness, axes.speed_kmh)
        ):
            things: dict[str, Canonical] = {kind: self.canonical[kind][getattr(label, kind)] for kind in AXES}
            known = labels.setdefault(identity.case_id(things, label.speed_kmh / KMH), [])
            if all(
                label[:-1] != other[:-1] for other in known
            ):  # equal speeds are one, however they are written
                known.append(label)
        for case_id, (first, *others) in labels.items():
            yield Case(*first, case_id, (first, *others))

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return every named object in the form of study files, by kind and name."""
        return {
            kind: {
                name: thing.model_dump(mode="json", by_alias=True, exclude_none=True)
                for name, thing in named.items()
            }
            for kind, named in self.objects.items()
        }

    def document(self) -> dict[str, Any]:
        """Return the study with all definitions included, so that it can be resolved without the library."""
        document = self.study.model_dump(mode="json", by_alias=True, exclude_none=True)
        return document | self.parameters() | {"vehicle": {}}


def load(path: Path) -> Resolved:
    """Read, check and resolve a study file.

    Raises
    ------
    InputError
        With one line on the first fault: the key, its value and what is allowed.

    Warns
    -----
    PlausibilityWarning
        With the key of each value that is legal but unusual.
    """
    return resolve(read_toml(path))


def resolve(tables: Mapping[str, Any]) -> Resolved:
    """Check the tables of a study and look up everything it names.

    Raises
    ------
    InputError
        As for `load`.

    Warns
    -----
    PlausibilityWarning
        As for `load`.
    """
    study = validated(Study, plain(tables))
    definitions: dict[str, Mapping[str, Any]] = {kind: getattr(study, kind) for kind in library.KINDS}
    for kind in library.KINDS:  # also those that no axis uses
        for name, table in definitions[kind].items():
            library.build(kind, table, where=f"{kind}.{name}", vehicles=study.vehicle)
    objects: dict[str, dict[str, BaseModel]] = {}
    for kind in AXES:
        objects[kind] = {}
        for name in getattr(study.sweep, kind):
            try:
                objects[kind][name] = library.resolve(kind, name, definitions)
            except InputError as error:
                raise InputError(f"sweep.{error}") from None
    return Resolved(study, objects)
