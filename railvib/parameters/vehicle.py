"""Vehicles of ten degrees of freedom, trains of them, and their receptances at the wheelsets.

Axes as everywhere: x along the track in the direction of travel, z downward. Vehicles are coupled through
the track only. The derivation of the closed form is in docs/theory/vehicle.md.
"""

from collections.abc import Iterator
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.parameters.units import GRAVITY
from railvib.parameters.validation import Number, Parameters, warn

AXLES = 4
"""Wheelsets of one vehicle."""

LARGEST_TRAIN = 1000
"""Vehicles; ten times those of the longest trains there are."""

USUAL_LOAD = 0.8, 1.25
"""Load of the axles over the weight of the masses."""

# The wheelsets' displacement shapes, ascending in x, in which the symmetric vehicle falls apart into chains.
BOUNCE = np.array([1.0, 1.0, 1.0, 1.0])
CAR_PITCH = np.array([-1.0, -1.0, 1.0, 1.0])
BOGIE_PITCH = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0]])
SHAPES = np.stack(
    [np.outer(BOUNCE, BOUNCE) / 4.0, np.outer(CAR_PITCH, CAR_PITCH) / 4.0, BOGIE_PITCH.T @ BOGIE_PITCH / 2.0]
)
"""What of a chain's flexibility per wheelset is between the wheelsets, (chains, wheelsets, wheelsets)."""


class Vehicle(Parameters):
    """A vehicle of ten degrees of freedom: bounce and pitch of the car and two bogies, four wheelsets.

    It is symmetric fore and aft. The car rests on the bogie centres, so that a bogie pitches on its primary
    suspension alone. Sheng, Jones and Thompson (2004), as in section 2.1 of the paper.

    Raises
    ------
    InputError
        If a value is out of range, or the axles do not fit the length.

    Warns
    -----
    PlausibilityWarning
        If the axle load does not fit the masses.
    """

    car_mass: Number = Field(alias="car_mass_kg", ge=100.0, le=1e6)
    """Mass of the car body, kg."""
    car_pitch_inertia: Number = Field(alias="car_pitch_inertia_kg_m2", ge=10.0, le=1e9)
    """Pitching moment of inertia of the car body, kg·m²."""
    bogie_mass: Number = Field(alias="bogie_mass_kg", ge=10.0, le=1e5)
    """Mass of one bogie frame, kg."""
    bogie_pitch_inertia: Number = Field(alias="bogie_pitch_inertia_kg_m2", ge=1.0, le=1e7)
    """Pitching moment of inertia of one bogie frame, kg·m²."""
    wheelset_mass: Number = Field(alias="wheelset_mass_kg", ge=10.0, le=1e5)
    """Unsprung mass of one wheelset, kg."""
    primary_stiffness: Number = Field(alias="primary_stiffness_n_m", ge=1000.0, le=1e12)
    """Stiffness k1 of one axle's primary suspension, both sides together, N/m."""
    primary_damping: Number = Field(alias="primary_damping_n_s_m", ge=0.0, le=1e9)
    """Viscous damping c1 of one axle's primary suspension, N·s/m."""
    secondary_stiffness: Number = Field(alias="secondary_stiffness_n_m", ge=1000.0, le=1e12)
    """Stiffness k2 of one bogie's secondary suspension, both sides together, N/m."""
    secondary_damping: Number = Field(alias="secondary_damping_n_s_m", ge=0.0, le=1e9)
    """Viscous damping c2 of one bogie's secondary suspension, N·s/m."""
    axle_spacing: Number = Field(alias="axle_spacing_m", ge=0.1, le=50.0)
    """Distance between the two axles of a bogie, m."""
    bogie_spacing: Number = Field(alias="bogie_spacing_m", ge=0.1, le=200.0)
    """Distance between the two bogie centres, m."""
    length: Number = Field(alias="length_m", ge=0.5, le=500.0)
    """Length over the couplings, m."""
    axle_load: Number = Field(alias="axle_load_n", ge=100.0, le=1e6)
    """Static load of one axle on the track, N."""
    contact_stiffness_per_wheel: Number = Field(alias="contact_stiffness_per_wheel_n_m", ge=1e5, le=1e13)
    """Linearised Hertz spring of one wheel on its rail, N/m; an axle has two."""

    @model_validator(mode="after")
    def _geometry_is_consistent(self) -> Self:
        if self.axle_spacing >= self.bogie_spacing:
            raise InputError(
                f".axle_spacing_m = {self.axle_spacing:g} m: must be below "
                f"bogie_spacing_m = {self.bogie_spacing:g} m"
            )
        if self.bogie_spacing + self.axle_spacing > self.length:
            raise InputError(
                f".length_m = {self.length:g} m: must be at least bogie_spacing_m + axle_spacing_m = "
                f"{self.bogie_spacing + self.axle_spacing:g} m"
            )
        warn(self.unusual())
        return self

    def unusual(self) -> Iterator[str]:
        """Yield that the axles carry another load than the masses weigh."""
        weight = self.total_mass * GRAVITY
        lowest, highest = USUAL_LOAD
        if not lowest < AXLES * self.axle_load / weight < highest:
            yield (
                f"axle_load_n = {self.axle_load:g} N: the four axles carry {AXLES * self.axle_load:.4g} N, "
                f"but the vehicle of {self.total_mass:.5g} kg weighs {weight:.4g} N"
            )

    @property
    def total_mass(self) -> float:
        """Mass of the whole vehicle in kg."""
        return self.car_mass + 2.0 * self.bogie_mass + AXLES * self.wheelset_mass

    @property
    def axle_positions(self) -> NDArray[np.float64]:
        """Positions of the four axles in m, ascending, from the rear end of the vehicle."""
        from_centre = self.bogie_spacing * CAR_PITCH + self.axle_spacing * BOGIE_PITCH.sum(axis=0)
        return np.asarray(0.5 * (self.length + from_centre))

    @property
    def contact_stiffness(self) -> float:
        """Hertz spring of one axle, two wheels in parallel, in N/m."""
        return 2.0 * self.contact_stiffness_per_wheel


class Train(Parameters):
    """Vehicles, like or unlike, listed from the head of the train: ``vehicles[0]`` leads.

    Every array over axles ascends with x and so begins with the last axle of the last vehicle; axle-1 of the
    results, the leading axle, is the last entry of each.
    """

    vehicles: tuple[Vehicle, ...] = Field(min_length=1, max_length=LARGEST_TRAIN)
    """From the head of the train to its tail."""

    @property
    def length(self) -> float:
        """Length over all vehicles in m."""
        return sum(vehicle.length for vehicle in self.vehicles)

    @property
    def axle_count(self) -> int:
        """How many axles the train has."""
        return AXLES * len(self.vehicles)

    @property
    def axle_positions(self) -> NDArray[np.float64]:
        """Positions of all axles in m, ascending, from the tail end of the train; shape (axle_count,)."""
        vehicles = self.vehicles[::-1]
        rear_ends = np.cumsum([0.0] + [vehicle.length for vehicle in vehicles[:-1]])
        return np.concatenate(
            [x + vehicle.axle_positions for x, vehicle in zip(rear_ends, vehicles, strict=True)]
        )

    @property
    def axle_loads(self) -> NDArray[np.float64]:
        """Static axle loads in N, in the order of `axle_positions`."""
        return np.repeat([vehicle.axle_load for vehicle in self.vehicles[::-1]], AXLES)

    @property
    def contact_stiffness(self) -> NDArray[np.float64]:
        """Hertz spring per axle in N/m, in the order of `axle_positions`."""
        return np.repeat([vehicle.contact_stiffness for vehicle in self.vehicles[::-1]], AXLES)


def chain_flexibilities(vehicle: Vehicle, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
    """Return the flexibilities of a vehicle's chains per wheelset: bounce, pitch of the car, of the bogies.

    Parameters
    ----------
    vehicle
        The vehicle.
    angular_frequency
        ω in rad/s, any shape, not 0: a free vehicle has no static receptance. Negative ω gives the conjugate.

    Returns
    -------
    Flexibilities in m/N, shape (3,) + ω.shape, in the order of `SHAPES`.

    Raises
    ------
    InputError
        If a frequency is 0 or not finite.

    Notes
    -----
    The symmetric vehicle separates into four chains of masses and springs, two of them alike; each is
    eliminated from the top down, so that the free-body limit −1/(mω²) comes out without any cancellation, at
    any frequency.
    """
    omega = np.asarray(angular_frequency, dtype=np.float64)
    if not np.all(np.isfinite(omega)) or np.any(omega == 0.0):
        refused = omega[~np.isfinite(omega) | (omega == 0.0)].flat[0]
        raise InputError(
            f"angular_frequency = {refused:g} rad/s: must be finite and not 0, where a free vehicle has none"
        )

    # Dynamic stiffnesses per wheelset: a mass m counts as −ω²m.
    inertia = -(omega**2)
    primary = vehicle.primary_stiffness + 1j * omega * vehicle.primary_damping
    secondary = 0.5 * (vehicle.secondary_stiffness + 1j * omega * vehicle.secondary_damping)
    wheelset = inertia * vehicle.wheelset_mass
    bogie = inertia * vehicle.bogie_mass / 2.0
    car = inertia * vehicle.car_mass / 4.0
    pitching_car = inertia * vehicle.car_pitch_inertia / vehicle.bogie_spacing**2
    pitching_bogie = inertia * 2.0 * vehicle.bogie_pitch_inertia / vehicle.axle_spacing**2

    bounce = wheelset + _in_series(primary, bogie + _in_series(secondary, car))
    car_pitch = wheelset + _in_series(primary, bogie + _in_series(secondary, pitching_car))
    bogie_pitch = wheelset + _in_series(primary, pitching_bogie)
    return np.asarray(1.0 / np.stack([bounce, car_pitch, bogie_pitch]))


def wheelset_receptance(vehicle: Vehicle, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
    """Return the receptances between the wheelsets of one vehicle, Σ_W = Bᵀ (K − ω²M)⁻¹ B (Eq. 4).

    Parameters
    ----------
    vehicle, angular_frequency
        As in `chain_flexibilities`.

    Returns
    -------
    Receptances in m/N, shape ω.shape + (4, 4), wheelsets ascending in x.
    """
    return np.asarray(np.einsum("c...,clm->...lm", chain_flexibilities(vehicle, angular_frequency), SHAPES))


def train_receptance(train: Train, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
    """Return the receptances between all wheelsets of a train, Σ_T (Eq. 5): block diagonal.

    Parameters
    ----------
    train
        The train.
    angular_frequency
        ω in rad/s, any shape, not 0.

    Returns
    -------
    Receptances in m/N, shape ω.shape + (axle_count, axle_count), axles as in `Train.axle_positions`.

    Raises
    ------
    InputError
        If a frequency is 0 or not finite.
    """
    omega = np.asarray(angular_frequency, dtype=np.float64)
    blocks = {vehicle: wheelset_receptance(vehicle, omega) for vehicle in set(train.vehicles)}
    receptance = np.zeros((*omega.shape, train.axle_count, train.axle_count), dtype=np.complex128)
    for index, vehicle in enumerate(reversed(train.vehicles)):
        axles = slice(AXLES * index, AXLES * (index + 1))
        receptance[..., axles, axles] = blocks[vehicle]
    return receptance


def _in_series(spring: NDArray[Any], beyond: NDArray[Any]) -> NDArray[np.complex128]:
    """Return the dynamic stiffness of a spring with the stiffness `beyond` at its far end."""
    return np.asarray(spring * beyond / (spring + beyond), dtype=np.complex128)
