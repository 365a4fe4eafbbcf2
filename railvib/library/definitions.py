"""From definitions to objects: those of a study stand before the library's, and both take the same form."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal, overload

from railvib.errors import InputError
from railvib.library.catalogue import Kind, check_kind, entry, names, unknown_name, without_documentation
from railvib.parameters.composite_vehicle import CompositeVehicle
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.validation import Parameters, keys, shown, validated, warn, without_cautions
from railvib.parameters.vehicle import LARGEST_TRAIN, Train, Vehicle
from railvib.parameters.wheel_roughness import WheelRoughness

Definition = Mapping[str, Any] | Sequence[Any]
"""What a study or the library says of one thing: its parameters; of a train also a list of its vehicles."""

AnyVehicle = Vehicle | CompositeVehicle

Definitions = Mapping[str, Mapping[str, Definition]]
"""A study's own definitions, by kind and name."""

MODELS: Mapping[Kind, tuple[type[Parameters], ...]] = {
    "soil": (Ground,),
    "track": (Track,),
    "vehicle": (Vehicle, CompositeVehicle),
    "train": (Train,),
    "unevenness": (Unevenness,),
}
"""What a definition of each kind may become."""


def model(kind: Kind, definition: Mapping[str, Any]) -> type[Parameters]:
    """Return the class of the object that a definition describes: that with most of its keys."""
    return max(MODELS[kind], key=lambda candidate: len(set(keys(candidate)).intersection(definition)))


@overload
def load(kind: Literal["soil"], name: str) -> Ground: ...
@overload
def load(kind: Literal["track"], name: str) -> Track: ...
@overload
def load(kind: Literal["vehicle"], name: str) -> AnyVehicle: ...
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
def resolve(kind: Literal["soil"], name: str, definitions: Definitions) -> Ground: ...
@overload
def resolve(kind: Literal["track"], name: str, definitions: Definitions) -> Track: ...
@overload
def resolve(kind: Literal["vehicle"], name: str, definitions: Definitions) -> AnyVehicle: ...
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
    of_study = definitions.get(check_kind(kind), {})
    if name in of_study:
        return build(kind, of_study[name], where=f"{kind}.{name}", vehicles=definitions.get("vehicle"))
    if name not in names(kind):
        raise InputError(unknown_name(kind, name, (*of_study, *names(kind))))
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

    Warns
    -----
    PlausibilityWarning
        If a value is unusual; the message names the key as well.
    """
    where = where or kind
    if check_kind(kind) == "train":
        return resolve_train(definition, vehicles, where=where)
    if not isinstance(definition, Mapping):
        raise InputError(f"{where} = {shown(definition)}: must be a table of parameters")
    return validated(model(kind, definition), without_documentation(definition), where)


def resolve_train(
    definition: Definition, vehicles: Mapping[str, Definition] | None = None, *, where: str = "train"
) -> Train:
    """Return the train that a definition describes, its vehicles listed from the head to the tail.

    Parameters
    ----------
    definition
        One group ``{vehicle = "regina", number = 4}``, a list of groups, or ``{vehicles = [groups]}``. The
        vehicle of a group is a name or a table of parameters; these may also stand in the group itself, and a
        bare name is a group of one. ``wheel_roughness`` beside a vehicle gives its wheels another roughness.
    vehicles
        Definitions of vehicles by name; they stand before the library's.
    where
        How messages name the train, such as ``train.mixed``.

    Raises
    ------
    InputError
        If the definition is wrong, a vehicle is unknown, or there are too many.
    """
    groups: Any = definition
    if isinstance(definition, Mapping):
        table = without_documentation(definition)
        if "vehicles" not in table:
            return _train([(where, table)], vehicles or {}, where)
        groups = table.pop("vehicles")
        if table:
            raise InputError(f"{where}.{min(table)}: unknown key beside vehicles")
        where += ".vehicles"
    if not isinstance(groups, Sequence) or isinstance(groups, str) or not groups:
        raise InputError(f"{where} = {shown(groups)}: must be a list of at least one vehicle")
    return _train([(f"{where}[{index}]", group) for index, group in enumerate(groups)], vehicles or {}, where)


def _train(groups: Sequence[tuple[str, Any]], vehicles: Mapping[str, Definition], where: str) -> Train:
    """Return the train of some groups, each with its place in the file."""
    members: list[AnyVehicle] = []
    places: list[str] = []
    for place, group in groups:
        table = {"vehicle": group} if isinstance(group, str) else group
        if not isinstance(table, Mapping):
            raise InputError(f"{place} = {shown(group)}: must be a table with vehicle and number")
        number = table.get("number", 1)
        if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number <= LARGEST_TRAIN:
            raise InputError(
                f"{place}.number = {shown(number)}: must be a whole number from 1 to {LARGEST_TRAIN}"
            )
        members += [_vehicle({key: table[key] for key in table if key != "number"}, vehicles, place)] * number
        places += [place] * number
        if len(members) > LARGEST_TRAIN:
            raise InputError(f"{where}: more than {LARGEST_TRAIN} vehicles; must have at most so many")
    with without_cautions():  # those of single vehicles have been given with them
        try:
            train = Train(vehicles=tuple(members))
        except InputError as error:
            raise InputError(_at_groups(str(error).removeprefix("Train"), places)) from None
    warn(_at_groups(f".{text}", places) for text in train.unusual())
    return train


def _at_groups(text: str, places: Sequence[str]) -> str:
    """Return a message about vehicles of a train with their groups' places in the file."""
    return re.sub(r"^\.vehicles\[(\d+)\]", lambda match: places[int(match[1])], text)


def _vehicle(table: Mapping[str, Any], vehicles: Mapping[str, Definition], where: str) -> AnyVehicle:
    """Return the vehicle of a group: a name, parameters below ``vehicle``, or parameters themselves."""
    definition: Any = table
    if "vehicle" in table:
        foreign = set(table) - {"vehicle", "wheel_roughness"}
        if foreign:
            raise InputError(
                f"{where}.{min(foreign)}: unknown key beside vehicle, number and wheel_roughness"
            )
        if "wheel_roughness" in table:
            wheels = table["wheel_roughness"]
            if not isinstance(wheels, Mapping):
                raise InputError(f"{where}.wheel_roughness = {shown(wheels)}: must be a table of parameters")
            roughness = validated(WheelRoughness, wheels, f"{where}.wheel_roughness")
            smooth = _vehicle({"vehicle": table["vehicle"]}, vehicles, where)
            return smooth.model_copy(update={"wheel_roughness": roughness})
        definition, where = table["vehicle"], f"{where}.vehicle"
    if isinstance(definition, str):
        name = definition
        if name not in vehicles and name not in names("vehicle"):
            raise InputError(f"{where}: {unknown_name('vehicle', name, (*vehicles, *names('vehicle')))}")
        return resolve("vehicle", name, {"vehicle": vehicles})
    vehicle = build("vehicle", definition, where=where)
    assert isinstance(vehicle, AnyVehicle)
    return vehicle
