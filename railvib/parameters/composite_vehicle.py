"""Vehicles given by their parts: a car on bogies or on axles, and on the vehicle ahead.

Positions are distances behind the front end of the vehicle, as trains are listed from their head. What is not
given has no springs: a bogie without secondary suspension carries the car on a rigid pivot, as freight bogies
do. `railvib.parameters.rake` puts the parts together.
"""

from collections.abc import Iterator
from typing import Literal, Self

from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.parameters.validation import Number, Parameters
from railvib.parameters.wheel_roughness import WheelRoughness

MOST_AXLES = 32
"""Axles of one vehicle."""
_BEYOND = 10.0
"""How far a part may lie outside of its vehicle, m; a shared bogie stands half under the next one."""


class Axle(Parameters):
    """A wheelset on the primary suspension under a bogie, or under the car itself."""

    position: Number = Field(alias="position_m", ge=-_BEYOND, le=500.0 + _BEYOND)
    """Distance behind the front end of the vehicle, m."""
    wheelset_mass: Number = Field(alias="wheelset_mass_kg", ge=10.0, le=1e5)
    """Unsprung mass, kg."""
    primary_stiffness: Number = Field(alias="primary_stiffness_n_m", ge=1000.0, le=1e12)
    """Stiffness of the suspension above the axle, both sides together, N/m."""
    primary_damping: Number = Field(alias="primary_damping_n_s_m", ge=0.0, le=1e9)
    """Viscous damping of the suspension above the axle, N·s/m."""
    load: Number | None = Field(default=None, alias="axle_load_n", ge=100.0, le=1e6)
    """Static load on the track, N; from the masses if not given."""


class Bogie(Parameters):
    """A bogie frame on its axles, with the car on a secondary suspension or on a rigid pivot."""

    position: Number = Field(alias="position_m", ge=-_BEYOND, le=500.0 + _BEYOND)
    """Distance of the centre of gravity behind the front end of the vehicle, m."""
    mass: Number = Field(alias="mass_kg", ge=10.0, le=1e5)
    """Mass of the frame, kg."""
    pitch_inertia: Number = Field(alias="pitch_inertia_kg_m2", ge=1.0, le=1e7)
    """Pitching moment of inertia of the frame, kg·m²."""
    axles: tuple[Axle, ...] = Field(min_length=1, max_length=MOST_AXLES)
    """Its axles."""
    secondary_stiffness: Number | None = Field(
        default=None, alias="secondary_stiffness_n_m", ge=1000.0, le=1e12
    )
    """Stiffness of the secondary suspension, both sides together, N/m; a rigid pivot if not given."""
    secondary_damping: Number | None = Field(default=None, alias="secondary_damping_n_s_m", ge=0.0, le=1e9)
    """Viscous damping of the secondary suspension, N·s/m."""
    pivot: Number | None = Field(default=None, alias="pivot_m", ge=-_BEYOND, le=500.0 + _BEYOND)
    """Where the car stands on it, as a distance behind the vehicle's front end, m; at `position` if not
    given.
    """

    @model_validator(mode="after")
    def _damping_needs_a_spring(self) -> Self:
        if self.secondary_stiffness is None and self.secondary_damping is not None:
            raise InputError(".secondary_damping_n_s_m: needs secondary_stiffness_n_m beside it")
        return self


class Car(Parameters):
    """The body of a vehicle."""

    mass: Number = Field(alias="mass_kg", ge=100.0, le=1e6)
    """Mass, kg."""
    pitch_inertia: Number = Field(alias="pitch_inertia_kg_m2", ge=10.0, le=1e9)
    """Pitching moment of inertia, kg·m²."""
    position: Number = Field(alias="position_m", ge=0.0, le=500.0)
    """Distance of the centre of gravity behind the front end of the vehicle, m."""


class Support(Parameters):
    """Where a car stands on the vehicle ahead: on its last bogie, which both share, or on its car."""

    position: Number = Field(alias="position_m", ge=-_BEYOND, le=_BEYOND)
    """Distance behind the front end of the vehicle that stands, m."""
    on: Literal["bogie", "car"] = "bogie"
    """The last bogie of the vehicle ahead, or its car."""
    stiffness: Number | None = Field(default=None, alias="stiffness_n_m", ge=1000.0, le=1e12)
    """Stiffness, N/m; a rigid joint that lets both pitch if not given."""
    damping: Number | None = Field(default=None, alias="damping_n_s_m", ge=0.0, le=1e9)
    """Viscous damping, N·s/m."""

    @model_validator(mode="after")
    def _damping_needs_a_spring(self) -> Self:
        if self.stiffness is None and self.damping is not None:
            raise InputError(".damping_n_s_m: needs stiffness_n_m beside it")
        return self


class CompositeVehicle(Parameters):
    """A vehicle given by its parts.

    Raises
    ------
    InputError
        If a value is out of range, or there is nothing under the car.
    """

    length: Number = Field(alias="length_m", ge=0.5, le=500.0)
    """Length over the couplings, m; of vehicles that share a bogie from joint to joint."""
    contact_stiffness_per_wheel: Number = Field(alias="contact_stiffness_per_wheel_n_m", ge=1e5, le=1e13)
    """Linearised Hertz spring of one wheel on its rail, N/m; an axle has two."""
    car: Car
    """The body."""
    bogies: tuple[Bogie, ...] = Field(default=(), max_length=MOST_AXLES)
    """From the front end backwards; the last one may be shared with the vehicle behind."""
    axles: tuple[Axle, ...] = Field(default=(), max_length=MOST_AXLES)
    """Axles under the car itself."""
    support: Support | None = Field(default=None, alias="on_vehicle_ahead")
    """Where the car stands on the vehicle ahead, in an articulated train."""
    wheel_roughness: WheelRoughness | None = None
    """Roughness of each wheelset, independent of the others; smooth wheels if not given."""

    @model_validator(mode="after")
    def _stands_on_something(self) -> Self:
        if not self.bogies and not self.axles and self.support is None:
            raise InputError(".bogies: is missing; a car stands on bogies, axles or the vehicle ahead")
        if self.car.position > self.length:
            raise InputError(
                f".car.position_m = {self.car.position:g} m: must be at most length_m = {self.length:g} m"
            )
        places = {f"axles[{index}]": axle.position for index, axle in enumerate(self.axles)}
        for number, bogie in enumerate(self.bogies):
            places[f"bogies[{number}]"] = bogie.position
            for index, axle in enumerate(bogie.axles):
                places[f"bogies[{number}].axles[{index}]"] = axle.position
        for place, position in places.items():
            if position > self.length + _BEYOND:
                raise InputError(
                    f".{place}.position_m = {position:g} m: must be at most {_BEYOND:g} m beyond "
                    f"length_m = {self.length:g} m"
                )
        return self

    def all_axles(self) -> Iterator[Axle]:
        """Yield the axles under the car and under its bogies."""
        yield from self.axles
        for bogie in self.bogies:
            yield from bogie.axles

    @property
    def axle_count(self) -> int:
        """How many axles the vehicle has of its own."""
        return sum(1 for _ in self.all_axles())

    @property
    def total_mass(self) -> float:
        """Mass of the whole vehicle in kg, its bogies included."""
        frames = sum(bogie.mass for bogie in self.bogies)
        return self.car.mass + frames + sum(axle.wheelset_mass for axle in self.all_axles())

    @property
    def contact_stiffness(self) -> float:
        """Hertz spring of one axle, two wheels in parallel, in N/m."""
        return 2.0 * self.contact_stiffness_per_wheel
