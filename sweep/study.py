"""The study file: what is asked for, checked at once and in full before anything is computed or written.

Names are resolved to physical objects here, inline definitions before the library's. What follows works with
objects and ids only; names come back in the manifest, as labels.
"""

import difflib
import math
import tomllib
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict, ValidationError, model_validator

from railvib import library
from railvib.errors import InputError
from railvib.numerics.third_octaves import midbands
from railvib.parameters.approach import Approach, Averaging
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH, unit_of
from railvib.parameters.vehicle import Vehicle
from sweep import identity
from sweep.identity import Canonical

LOWEST_HZ, HIGHEST_HZ = 0.1, 500.0
"""Midbands for which the physics has been verified."""

LARGEST_AXIS = 100_000
MESSAGES = {
    "too_short": "must have at least one value",
    "tuple_type": "must be a list",
    "string_pattern_mismatch": "may consist of letters, digits and _ . + - only",
}
"""Of those faults whose general wording speaks of Python."""
AXES: tuple[library.Kind, ...] = ("soil", "track", "train", "unevenness")
MODELS: dict[str, type[BaseModel]] = {
    "soil": Ground,
    "track": Track,
    "unevenness": Unevenness,
    "vehicle": Vehicle,
}
"""What inline tables hold; a train's are groups of vehicles, which the library reads."""

Model = TypeVar("Model", bound=BaseModel)

Number = Annotated[float, Strict()]
NonNegative = Annotated[float, Strict(), Field(ge=0.0)]
Positive = Annotated[float, Strict(), Field(gt=0.0)]
Name = Annotated[str, Strict(), Field(min_length=1, pattern=r"^[\w.+-]+$")]


class Section(BaseModel):
    """A table of the study file: unknown keys, NaN and infinity are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Heading(Section):
    """What the study is called; names its output directory, and enters no id."""

    name: Name


class Frequency(Section):
    """The one-third-octave bands by their lowest and highest midband, nominal or exact."""

    minimum_hz: Annotated[float, Strict(), Field(ge=LOWEST_HZ, le=HIGHEST_HZ)]
    maximum_hz: Annotated[float, Strict(), Field(ge=LOWEST_HZ, le=HIGHEST_HZ)]

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if self.minimum_hz >= self.maximum_hz:
            raise InputError(
                f".minimum_hz = {self.minimum_hz:g} Hz: must be below maximum_hz = {self.maximum_hz:g} Hz"
            )
        midbands(self.minimum_hz, self.maximum_hz)
        return self


class Receivers(Section):
    """Where vibration is wanted: on the rail, and on the ground at distances from the track's centre line."""

    rail: Annotated[bool, Strict()] = True
    offsets_m: tuple[NonNegative, ...] = ()

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if not self.rail and not self.offsets_m:
            raise InputError(".offsets_m = []: without the rail, at least one offset in m is needed")
        return self


class Approaches(Section):
    """Which approaches are compared, with which of them, and what their spectra are averaged over."""

    compare: Annotated[tuple[Approach, ...], Field(min_length=1)]
    reference: Approach
    averaging: Annotated[tuple[Averaging, ...], Field(min_length=1)] = ("line",)

    @model_validator(mode="after")
    def _reference_is_computed(self) -> Self:
        if self.reference not in self.compare:
            raise InputError(
                f".reference = {self.reference!r}: must be one of compare = {list(self.compare)}"
            )
        return self


def axis(value: Any) -> Any:
    """Return the values of a numeric axis: a list, {start, stop, step} or {start, stop, number, scale}.

    Raises
    ------
    ValueError
        If a range is incomplete, does not ascend, or has more than `LARGEST_AXIS` values.
    """
    if not isinstance(value, Mapping):
        return value
    keys = set(value)
    if keys != {"start", "stop", "step"} and keys - {"scale"} != {"start", "stop", "number"}:
        raise ValueError(
            'must be a list, {start, stop, step} or {start, stop, number, scale = "log" | "linear"}'
        )
    numbers = {key: _number(key, value[key]) for key in keys - {"scale"}}
    start, stop = numbers["start"], numbers["stop"]
    scale = value.get("scale", "linear")
    if scale not in ("log", "linear"):
        raise ValueError(f'scale = {scale!r} must be "log" or "linear"')
    if not start < stop:
        raise ValueError(f"start = {start:g} must be below stop = {stop:g}")
    if "step" in numbers:
        step = numbers["step"]
        if step <= 0.0:
            raise ValueError(f"step = {step:g} must be above 0")
        intervals = math.floor((stop - start) / step * (1.0 + 1e-12))
        _check_length(intervals + 1)
        return [_rounded(start + step * index) for index in range(intervals + 1)]
    number = numbers["number"]
    if number < 2 or number != int(number):
        raise ValueError(f"number = {number:g} must be an integer of 2 or more")
    _check_length(int(number))
    fractions = [index / (number - 1) for index in range(int(number))]
    if scale == "linear":
        return [_rounded(start + (stop - start) * fraction) for fraction in fractions]
    if start <= 0.0:
        raise ValueError(f"start = {start:g} must be above 0 for a logarithmic scale")
    return [_rounded(start * (stop / start) ** fraction) for fraction in fractions]


class Axes(Section):
    """The axes of the sweep; every combination of their values is a case."""

    soil: Annotated[tuple[Name, ...], Field(min_length=1)]
    track: Annotated[tuple[Name, ...], Field(min_length=1)]
    train: Annotated[tuple[Name, ...], Field(min_length=1)]
    unevenness: Annotated[tuple[Name, ...], Field(min_length=1)]
    speed_kmh: Annotated[tuple[Positive, ...], BeforeValidator(axis), Field(min_length=1)]


class Accuracy(Section):
    """How exact the transfer functions are, relative to themselves, at each requested offset."""

    tolerance: Annotated[float, Strict(), Field(ge=1e-6, le=1e-2)] = 1e-4


class Lines(Section):
    """Spectral lines that go to the database."""

    approach: Approach
    receiver: Name
    offset_m: NonNegative | None = None


class Output(Section):
    """What of the narrow-band spectra goes to the database; all of it stays in the store."""

    narrow_band: Literal["all", "none"] | tuple[Lines, ...] = "all"


class Study(Section):
    """A whole study file."""

    study: Heading
    frequency: Frequency
    receivers: Receivers
    approaches: Approaches
    sweep: Axes
    accuracy: Accuracy = Accuracy()
    output: Output = Output()
    cross_section: CrossSection = CrossSection()
    soil: Mapping[str, Any] = {}
    track: Mapping[str, Any] = {}
    train: Mapping[str, Any] = {}
    vehicle: Mapping[str, Any] = {}
    unevenness: Mapping[str, Any] = {}


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

    Where two names stand for equal things, a case has several labels; the first gives it its names.
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
    """A study whose names are known: every physical object by kind and name."""

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
        """Yield the cases, each once, soil by soil so that what shares a ground is together."""
        axes = self.study.sweep
        labels: dict[str, list[Label]] = {}
        for label in map(
            Label._make, product(axes.soil, axes.track, axes.train, axes.unevenness, axes.speed_kmh)
        ):
            things: dict[str, Canonical] = {kind: self.canonical[kind][getattr(label, kind)] for kind in AXES}
            known = labels.setdefault(identity.case_id(things, label.speed_kmh / KMH), [])
            if all(label[:-1] != other[:-1] for other in known):  # equal speeds are one, however written
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
        """Return the study with all it names spelt out: it can be resolved without the library."""
        document = self.study.model_dump(mode="json")
        section = self.study.cross_section.model_dump(mode="json", by_alias=True)
        return document | self.parameters() | {"vehicle": {}, "cross_section": section}


def load(path: Path) -> Resolved:
    """Read, check and resolve a study file.

    Raises
    ------
    InputError
        With one line that names the key, its value and what is allowed; the first fault found is the one
        told.
    """
    return resolve(read_toml(path))


def resolve(data: Mapping[str, Any]) -> Resolved:
    """Check the tables of a study and look up everything it names.

    Raises
    ------
    InputError
        As for `load`.
    """
    study = validated(Study, data)
    definitions: dict[str, Mapping[str, Any]] = {kind: getattr(study, kind) for kind in library.KINDS}
    for kind in library.KINDS:
        for name, table in definitions[kind].items():
            _check_inline(kind, name, table, study.vehicle)
    objects: dict[str, dict[str, BaseModel]] = {}
    for kind in AXES:
        objects[kind] = {}
        for name in getattr(study.sweep, kind):
            try:
                objects[kind][name] = library.resolve(kind, name, definitions)
            except InputError as error:
                raise InputError(f"sweep.{error}") from None
    return Resolved(study, objects)


def validated(model: type[Model], data: Mapping[str, Any]) -> Model:
    """Return the tables of a file as a model.

    Raises
    ------
    InputError
        With one line on the first fault found.
    """
    check_keys(model, data, "")
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError(_describe(error)) from None


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a file.

    Raises
    ------
    InputError
        If it cannot be read, or is not valid.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not valid TOML: {error}") from None


def check_keys(model: type[BaseModel], data: Any, where: str) -> None:
    """Check that a table has no key that `model` does not know, and go on into the tables inside it.

    Raises
    ------
    InputError
        Naming the unknown key and the nearest known one.
    """
    if not isinstance(data, Mapping):
        return
    known = {field.alias or name: field.annotation for name, field in model.model_fields.items()}
    for key, value in data.items():
        path = f"{where}.{key}" if where else key
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.4)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(sorted(known))}"
            raise InputError(f"{path}: unknown key; {hint}")
        inner = [
            part for part in _leaves(known[key]) if isinstance(part, type) and issubclass(part, BaseModel)
        ]
        if len(inner) != 1:
            continue
        tables = enumerate(value) if isinstance(value, list) else [(None, value)]
        for index, table in tables:
            check_keys(inner[0], table, path if index is None else f"{path}[{index}]")


def _leaves(annotation: Any) -> Iterator[Any]:
    """Yield the types that an annotation is made of."""
    parts = typing.get_args(annotation)
    if parts:
        for part in parts:
            yield from _leaves(part)
    else:
        yield annotation


def _check_inline(kind: library.Kind, name: str, table: Any, vehicles: Mapping[str, Any]) -> None:
    """Check a definition of the study's own, also one that no axis names."""
    where = f"{kind}.{name}"
    if kind in MODELS and isinstance(table, Mapping):
        documented = {key: value for key, value in table.items() if key not in library.DOCUMENTATION}
        check_keys(MODELS[kind], documented, where)
    library.build(kind, table, where=where, vehicles=vehicles)


def _describe(error: ValidationError) -> str:
    """Return the first fault of a study in one line."""
    faults = error.errors(include_url=False)
    fault = next(
        (each for each in faults if each["type"] != "literal_error" or isinstance(each["input"], str)),
        faults[0],
    )
    # A union reports every alternative; its branches are no part of the key.
    parts = [
        part for part in fault["loc"] if isinstance(part, int) or not part.startswith(("tuple[", "literal["))
    ]
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).lstrip(".")
    if fault["type"] == "missing":
        return f"{key}: is missing"
    cause = fault.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        # An object of railvib names itself first: its place in the study says more.
        own = str(cause).removeprefix(CrossSection.__name__)
        if own.startswith((".", ":")):
            return (key + own).lstrip(".")
    message = MESSAGES.get(fault["type"]) or fault["msg"].removeprefix("Value error, ").replace(
        "Input should", "should"
    )
    value = fault["input"]
    if isinstance(value, Mapping) and key != "sweep.speed_kmh":
        return f"{key}: {message}"
    unit = unit_of(str(next((part for part in reversed(parts) if isinstance(part, str)), "")))
    shown = f"{value!r} {unit}".rstrip() if isinstance(value, int | float) else repr(value)
    return f"{key} = {shown}: {message}"


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{key} = {value!r} must be a finite number")
    return float(value)


def _check_length(length: int) -> None:
    if length > LARGEST_AXIS:
        raise ValueError(f"{length} values are more than {LARGEST_AXIS}")


def _rounded(value: float) -> float:
    """Return a value of an axis without its rounding errors: it shall have the id of the value typed in."""
    return float(f"{value:.12g}")
