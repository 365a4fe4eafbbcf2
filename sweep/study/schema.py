"""The sections of a study file, and the allowed values of their keys."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, Strict, model_validator

from railvib import library
from railvib.errors import InputError
from railvib.numerics.third_octaves import midbands
from railvib.parameters.approach import Approach, Averaging
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.metric import FEWEST_PASSAGES, MOST_PASSAGES, Metric
from railvib.parameters.receiver import FARTHEST
from railvib.parameters.speed import SpeedKmh, slow
from railvib.parameters.validation import Integer, Number, Parameters, keys
from sweep.study.names import Name, check_name
from sweep.study.ranges import LARGEST_AXIS, axis

Value = TypeVar("Value")

LARGEST_LIST = 1000
"""Largest number of names on an axis, and of offsets."""

Hertz = Annotated[Number, Field(ge=0.1, le=500.0)]
"""Range of midbands in which the physics has been verified."""

Offset = Annotated[Number, Field(ge=0.0, le=FARTHEST)]
Truth = Annotated[bool, Strict()]


def _once(values: tuple[Value, ...]) -> tuple[Value, ...]:
    """Return the values without repetitions, in order."""
    return tuple(dict.fromkeys(values))


Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=LARGEST_LIST), AfterValidator(_once)]


class Section(Parameters):
    """A table of the study file."""

    @classmethod
    def places(cls) -> dict[str, str]:
        """Return for each key the tables that have it, as text for hints about misplaced keys."""
        sections = {
            name: field.annotation
            for name, field in Study.model_fields.items()
            if isinstance(field.annotation, type) and issubclass(field.annotation, Parameters)
        }
        tables = {f"[{name}]": keys(section) for name, section in sections.items()}
        for kind, models in library.MODELS.items():
            for model in models:
                for key, place in model.places().items():
                    tables.setdefault(f"{place} in [{kind}.<name>]", []).append(key)
                tables.setdefault(f"[{kind}.<name>]", []).extend(keys(model))
        places: dict[str, str] = {}
        for place, known in tables.items():
            for key in dict.fromkeys(known):
                places[key] = f"{places[key]} or {place}" if key in places else place
        return places


class Heading(Section):
    """Name of the study, for its output directory, and its title, for people; neither enters an id."""

    name: Annotated[str, Strict()]
    title: Annotated[str, Strict(), Field(min_length=1, max_length=200)] | None = None

    @model_validator(mode="after")
    def _name_is_one(self) -> Self:
        try:
            check_name(self.name)
        except ValueError as error:
            free = "" if self.title else "; any text may be the title beside it"
            raise InputError(f".name = {self.name!r}: {error}{free}") from None
        return self

    @model_validator(mode="after")
    def _title_is_a_line(self) -> Self:
        if self.title and not self.title.isprintable():
            raise InputError(f".title = {self.title!r}: must be one line of printable characters")
        return self


class Frequency(Section):
    """The one-third-octave bands by their lowest and highest midband, nominal or exact."""

    minimum_hz: Hertz
    maximum_hz: Hertz

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if self.minimum_hz >= self.maximum_hz:
            raise InputError(
                f".minimum_hz = {self.minimum_hz:g} Hz: must be below maximum_hz = {self.maximum_hz:g} Hz"
            )
        midbands(self.minimum_hz, self.maximum_hz)
        return self


class Receivers(Section):
    """Receivers: on the rail, and on the ground at offsets from the track's centre line."""

    rail: Truth = True
    offsets_m: Annotated[tuple[Offset, ...], Field(max_length=LARGEST_LIST)] = ()

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if not self.rail and not self.offsets_m:
            raise InputError(".offsets_m = []: without the rail, at least one offset in m is needed")
        return self


class Approaches(Section):
    """Approaches to compare, the reference among them, and what spectra are averaged over."""

    compare: Annotated[tuple[Approach, ...], Field(min_length=1)]
    reference: Approach
    averaging: Annotated[tuple[Averaging, ...], Field(min_length=1)] = ("line",)

    @model_validator(mode="after")
    def _check_reference(self) -> Self:
        if self.reference not in self.compare:
            raise InputError(
                f".reference = {self.reference!r}: must be one of compare = {list(self.compare)}"
            )
        return self


class Axes(Section):
    """The axes of the sweep; every combination of their values is a case."""

    soil: Names
    track: Names
    train: Names
    unevenness: Names
    speed_kmh: Annotated[
        tuple[SpeedKmh, ...],
        BeforeValidator(axis),
        Field(min_length=1, max_length=LARGEST_AXIS),
        AfterValidator(_once),
    ]

    @property
    def combinations(self) -> int:
        """Number of combinations of the axes' values."""
        return math.prod(len(values) for values in dict(self).values())

    def unusual(self) -> Iterator[str]:
        """Yield a warning if the slowest speed is implausible for trains."""
        if text := slow(min(self.speed_kmh)):
            yield f"speed_kmh = {text}"


class Accuracy(Section):
    """Relative tolerance of the transfer functions at each requested offset."""

    tolerance: Annotated[Number, Field(ge=1e-6, le=1e-2)] = 1e-4


class Lines(Section):
    """Spectral lines that go to the database."""

    approach: Approach
    receiver: Name
    offset_m: Offset | None = None


class Output(Section):
    """Narrow-band spectra that go to the database; the store keeps all."""

    narrow_band: Literal["all", "none"] | tuple[Lines, ...] = "all"


class Levels(Section):
    """Levels of random passages that are wanted beside the spectra."""

    metrics: Annotated[tuple[Metric, ...], Field(min_length=1), AfterValidator(_once)]
    quantiles: Annotated[
        tuple[Annotated[Number, Field(gt=0.0, lt=1.0)], ...], Field(max_length=20), AfterValidator(_once)
    ] = (0.05, 0.5, 0.95)
    passages: Integer = 256
    seed: Annotated[Integer, Field(ge=0, le=2**32 - 1)] = 1

    @model_validator(mode="after")
    def _passages_suffice(self) -> Self:
        if self.passages and not FEWEST_PASSAGES <= self.passages <= MOST_PASSAGES:
            raise InputError(
                f".passages = {self.passages}: must be 0, for closed forms, or from {FEWEST_PASSAGES} "
                f"to {MOST_PASSAGES}"
            )
        return self


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
    levels: Levels | None = None
    soil: Mapping[str, Any] = {}
    track: Mapping[str, Any] = {}
    train: Mapping[str, Any] = {}
    vehicle: Mapping[str, Any] = {}
    unevenness: Mapping[str, Any] = {}
