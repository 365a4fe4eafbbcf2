"""Named soils, tracks, vehicles, trains and unevenness with their sources.

The data are TOML beside this file, in the form of study files; ``title``, ``source`` and ``sources`` document
an entry and are no parameters.
"""

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any, Literal, get_args

from railvib.errors import InputError

Kind = Literal["soil", "track", "vehicle", "train", "unevenness"]
KINDS: tuple[Kind, ...] = get_args(Kind)

DOCUMENTATION = ("title", "source", "sources")


@dataclass(frozen=True)
class Entry:
    """What the library holds under one name."""

    kind: Kind
    name: str
    title: str
    source: str
    """Where the parameters come from, unless `sources` says otherwise."""
    sources: Mapping[str, str]
    """Sources of single parameters, by key."""
    parameters: Mapping[str, Any]
    """Parameters in the form of study files."""

    def source_of(self, key: str) -> str:
        """Return the source of one parameter."""
        return self.sources.get(key, self.source)


def names(kind: Kind) -> tuple[str, ...]:
    """Return the names that the library holds of a kind, in the order of its file.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    return tuple(_catalogue(check_kind(kind)))


def entry(kind: Kind, name: str) -> Entry:
    """Return an entry with its raw parameters and their sources.

    Raises
    ------
    InputError
        If there is no such kind or name; the message gives the nearest known.
    """
    catalogue = _catalogue(check_kind(kind))
    if name not in catalogue:
        raise InputError(unknown_name(kind, name, catalogue))
    return catalogue[name]


@cache
def _catalogue(kind: Kind) -> Mapping[str, Entry]:
    text = (resources.files("railvib.library") / "data" / f"{kind}.toml").read_text(encoding="utf-8")
    return MappingProxyType(
        {
            name: Entry(
                kind=kind,
                name=name,
                title=table["title"],
                source=table["source"],
                sources=MappingProxyType(table.get("sources", {})),
                parameters=MappingProxyType(without_documentation(table)),
            )
            for name, table in tomllib.loads(text).items()
        }
    )


def without_documentation(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of an entry or a definition alone."""
    return {key: value for key, value in table.items() if key not in DOCUMENTATION}


def check_kind(kind: Kind) -> Kind:
    """Return a kind that exists.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if kind not in KINDS:
        raise InputError(f"kind = {kind!r}: must be one of {', '.join(KINDS)}")
    return kind


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the message about a name that is not known, with the nearest one that is."""
    candidates = sorted(set(known))
    nearest = difflib.get_close_matches(name, candidates, n=1, cutoff=0.5)
    hint = f"the nearest known is {nearest[0]!r}" if nearest else f"known are {', '.join(candidates)}"
    return f"{kind} = {name!r}: is unknown; {hint}"
