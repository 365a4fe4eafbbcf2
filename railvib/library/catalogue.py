"""Named soils, tracks, vehicles, trains and unevenness with their sources, and the way from name to object.

The data are TOML beside this file, in the form of study files; ``title``, ``source`` and ``sources`` document
an entry and are no parameters. Definitions inside a study take the same form and stand before the library's.
"""

import difflib
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, get_args, overload

from railvib.errors import InputError
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.validation import Parameters
from railvib.parameters.vehicle import Train, Vehicle

if TYPE_CHECKING:
    from railvib.parameters.ground import Ground
    from railvib.parameters.track import Track

Kind = Literal["soil", "track", "vehicle", "train", "unevenness"]
KINDS: tuple[Kind, ...] = get_args(Kind)

Definition = Mapping[str, Any] | Sequence[Any]
"""What a study or the library says of one thing: its parameters; of a train also a list of its vehicles."""

Definitions = Mapping[str, Mapping[str, Definition]]
"""A study's own definitions, by kind and name."""

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
    return tuple(_catalogue(_checked(kind)))


def entry(kind: Kind, name: str) -> Entry:
    """Return an entry with its raw parameters and their sources.

    Raises
    ------
    InputError
        If there is no such kind or name; the message gives the nearest known.
    """
    catalogue = _catalogue(_checked(kind))
    if name not in catalogue:
        raise InputError(_unknown(kind, name, catalogue))
    return catalogue[name]


@overload
def load(kind: Literal["soil"], name: str) -> "Ground": ...
@overload
def load(kind: Literal["track"], name: str) -> "Track": ...
@overload
def load(kind: Literal["vehicle"], name: str) -> Vehicle: ...
@overload
def load(kind: Literal["train"], name: str) -> Train: ...
@overload
def load(kind: Literal["unevenness"], name: str) -> Unevenness: ...
@overload
def load(kind: Kind, name: str) -> Parameters: ...
def load(kind: Kind, name: str) -> Parameters:
    """Return the object that the library holds under a name.

    >>> load("train", "grona-taget").length
    106.4

    Parameters
    ----------
    kind
        ``soil`` for a Ground, ``track``, ``vehicle``, ``train`` or ``unevenness``.
    name
        One of `names` of the kind.

    Raises
    ------
    InputError
        If there is no such kind or name; the message gives the nearest known.
    """
    return build(kind, entry(kind, name).parameters, where=f"{kind}.{name}")


@overload
def resolve(kind: Literal["soil"], name: str, definitions: Definitions) -> "Ground": ...
@overload
def resolve(kind: Literal["track"], name: str, definitions: Definitions) -> "Track": ...
@overload
def resolve(kind: Literal["vehicle"], name: str, definitions: Definitions) -> Vehicle: ...
@overload
def resolve(kind: Literal["train"], name: str, definitions: Definitions) -> Train: ...
@overload
def resolve(kind: Literal["unevenness"], name: str, definitions: Definitions) -> Unevenness: ...
@overload
def resolve(kind: Kind, name: str, definitions: Definitions) -> Parameters: ...
def resolve(kind: Kind, name: str, definitions: Definitions) -> Parameters:
    """Return the object of a name that stands in a study's own definitions or else in the library.

    Parameters
    ----------
    kind
        The kind of thing.
    name
        Its name in the study.
    definitions
        The study's tables by kind and name, ``{"soil": {"greby": {...}}}``; kinds may be absent.

    Raises
    ------
    InputError
        If the name is in neither, or its definition is wrong; the message begins with ``kind.name``.
    """
    own = definitions.get(_checked(kind), {})
    if name in own:
        return build(kind, own[name], where=f"{kind}.{name}", vehicles=definitions.get("vehicle"))
    if name not in names(kind):
        raise InputError(_unknown(kind, name, (*own, *names(kind))))
    return load(kind, name)


def build(
    kind: Kind,
    definition: Definition,
    *,
    where: str | None = None,
    vehicles: Mapping[str, Definition] | None = None,
) -> Parameters:
    """Return the object that a definition in the form of study files describes.

    Parameters
    ----------
    kind
        The kind of thing.
    definition
        Its parameters; documentation beside them is left out.
    where
        How messages name it, such as ``soil.greby``; the kind if not given.
    vehicles
        Definitions of vehicles by name, for a train; they stand before the library's.

    Raises
    ------
    InputError
        If the definition is wrong; one line that names the key.
    """
    where = where or kind
    if _checked(kind) == "train":
        return resolve_train(definition, vehicles, where=where)
    if not isinstance(definition, Mapping):
        raise InputError(f"{where} = {definition!r}: must be a table of parameters")
    model = _model(kind)
    try:
        return model(**_without_documentation(definition))
    except InputError as error:
        raise InputError(where + str(error).removeprefix(model.__name__)) from None


def resolve_train(
    definition: Definition, vehicles: Mapping[str, Definition] | None = None, *, where: str = "train"
) -> Train:
    """Return the train that a definition describes, its vehicles listed from the head to the tail.

    Parameters
    ----------
    definition
        One group ``{vehicle = "regina", number = 4}``, a list of groups, or ``{vehicles = [groups]}``. The
        vehicle of a group is a name or a table of parameters; these may also stand in the group itself, and a
        bare name is a group of one.
    vehicles
        Definitions of vehicles by name; they stand before the library's.
    where
        How messages name the train, such as ``train.mixed``.

    Raises
    ------
    InputError
        If the definition is wrong, or a vehicle is unknown.
    """
    groups: Any = definition
    if isinstance(definition, Mapping):
        parameters = _without_documentation(definition)
        groups = [parameters]
        if "vehicles" in parameters:
            groups = parameters.pop("vehicles")
            where += ".vehicles"
            if parameters:
                raise InputError(
                    f"{where.removesuffix('.vehicles')}.{min(parameters)}: unknown key beside vehicles"
                )
    if not isinstance(groups, Sequence) or isinstance(groups, str) or not groups:
        raise InputError(f"{where} = {groups!r}: must be a list of at least one vehicle")
    single = len(groups) == 1 and isinstance(definition, Mapping) and not where.endswith(".vehicles")
    members: list[Vehicle] = []
    for index, group in enumerate(groups):
        members += _group(group, vehicles or {}, where if single else f"{where}[{index}]")
    return Train(vehicles=tuple(members))


def _group(group: Any, vehicles: Mapping[str, Definition], where: str) -> list[Vehicle]:
    if isinstance(group, str):
        group = {"vehicle": group}
    if not isinstance(group, Mapping):
        raise InputError(f"{where} = {group!r}: must be a table with vehicle and number")
    rest = dict(group)
    number = rest.pop("number", 1)
    if not isinstance(number, int) or isinstance(number, bool) or number < 1:
        raise InputError(f"{where}.number = {number!r}: must be a whole number from 1")
    if "vehicle" not in rest:
        return [_vehicle(rest, where)] * number
    vehicle = rest.pop("vehicle")
    if rest:
        raise InputError(f"{where}.{min(rest)}: unknown key beside vehicle and number")
    where += ".vehicle"
    if not isinstance(vehicle, str):
        return [_vehicle(vehicle, where)] * number
    if vehicle in vehicles:
        return [_vehicle(vehicles[vehicle], f"vehicle.{vehicle}")] * number
    if vehicle not in names("vehicle"):
        raise InputError(f"{where}: {_unknown('vehicle', vehicle, (*vehicles, *names('vehicle')))}")
    return [load("vehicle", vehicle)] * number


def _vehicle(definition: Definition, where: str) -> Vehicle:
    vehicle = build("vehicle", definition, where=where)
    assert isinstance(vehicle, Vehicle)
    return vehicle


def _model(kind: Kind) -> type[Parameters]:
    """Return the class of a kind; ground and track when asked for, as they may bring kernels along."""
    match kind:
        case "soil":
            from railvib.parameters.ground import Ground

            return Ground
        case "track":
            from railvib.parameters.track import Track

            return Track
        case "vehicle":
            return Vehicle
        case "train":
            return Train
        case "unevenness":
            return Unevenness


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
                parameters=MappingProxyType(_without_documentation(table)),
            )
            for name, table in tomllib.loads(text).items()
        }
    )


def _without_documentation(table: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in DOCUMENTATION}


def _checked(kind: Kind) -> Kind:
    if kind not in KINDS:
        raise InputError(f"kind = {kind!r}: must be one of {', '.join(KINDS)}")
    return kind


def _unknown(kind: str, name: str, known: Iterable[str]) -> str:
    candidates = sorted(set(known))
    nearest = difflib.get_close_matches(name, candidates, n=1, cutoff=0.5)
    hint = f"the nearest known is {nearest[0]!r}" if nearest else f"known are {', '.join(candidates)}"
    return f"{kind} = {name!r}: is unknown; {hint}"
