"""Vehicles of ten degrees of freedom, trains of any vehicles, and their receptances at the wheelsets.

Axes as everywhere: x along the track in the direction of travel, z downward. Vehicles that do not stand on
each other are coupled through the track only. The derivation of the closed form is in docs/theory/vehicle.md.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.parameters.composite_vehicle import CompositeVehicle
from railvib.parameters.rake import Rake
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import GRAVITY
from railvib.parameters.validation import Number, Parameters, warn
from railvib.parameters.wheel_roughness import WheelRoughness

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
    wheel_roughness: WheelRoughness | None = None
    """Roughness of each wheelset, independent of the others; smooth wheels if not given."""

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
    def suspension_modes(self) -> NDArray[np.complex128]:
        """Eigenvalues of car and bogies on wheelsets that are held, as `Rake.suspension_modes`, (n,)."""
        return _suspension_modes(self)

    @property
    def contact_stiffness(self) -> float:
        """Hertz spring of one axle, two wheels in parallel, in N/m."""
        return 2.0 * self.contact_stiffness_per_wheel

    @property
    def axle_count(self) -> int:
        """How many axles the vehicle has."""
        return AXLES

    @property
    def shapes(self) -> NDArray[np.float64]:
        """What of each of `flexibilities` is between the wheelsets, (chains, wheelsets, wheelsets)."""
        return SHAPES

    def flexibilities(self, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the flexibilities of the vehicle's chains, as `chain_flexibilities`."""
        return chain_flexibilities(self, angular_frequency)


Block = Vehicle | Rake
"""What of a train moves on its own but for the track: a vehicle, or several that stand on each other.

Its receptances are Σ `flexibilities` · `shapes`.
"""


class Train(Parameters):
    """Vehicles, like or unlike, listed from the head of the train: ``vehicles[0]`` leads.

    Every array over axles ascends with x and so begins with the last axle of the last vehicle; axle-1 of the
    results, the leading axle, is the last entry of each.
    """

    vehicles: tuple[Vehicle | CompositeVehicle, ...] = Field(min_length=1, max_length=LARGEST_TRAIN)
    """From the head of the train to its tail."""

    @model_validator(mode="after")
    def _vehicles_stand(self) -> Self:
        ahead: Vehicle | CompositeVehicle | None = None
        for number, vehicle in enumerate(self.vehicles):
            if isinstance(vehicle, CompositeVehicle) and vehicle.support is not None:
                place = f".vehicles[{number}].on_vehicle_ahead"
                if not isinstance(ahead, CompositeVehicle):
                    raise InputError(
                        f"{place}: needs a vehicle ahead that is given by its parts, car and bogies"
                    )
                if vehicle.support.on == "bogie" and not ahead.bogies:
                    raise InputError(f'{place}.on = "bogie": the vehicle ahead has none')
            ahead = vehicle
        first = 0
        for block in self.blocks:
            count = len(block.vehicles) if isinstance(block, Rake) else 1
            if isinstance(block, Rake):
                block.check([f".vehicles[{first + index}]" for index in range(count)])
            first += count
        if not self.axle_count:
            raise InputError(".vehicles: have no axle")
        positions = self.axle_positions
        (behind,) = np.nonzero(np.diff(positions) < 0.0)
        if behind.size:
            number = self.axle_vehicles[behind[-1]]
            raise InputError(
                f".vehicles[{number - 1}]: its leading axle lies ahead of an axle of the vehicle ahead; "
                "check positions and length_m"
            )
        warn(self.unusual())
        return self

    def unusual(self) -> Iterator[str]:
        """Yield that axles of vehicles given by their parts carry another load than the masses weigh."""
        first = 0
        for block in self.blocks:
            if not isinstance(block, Rake):
                first += 1
                continue
            last = first + len(block.vehicles)
            place = f"vehicles[{first}]" if last == first + 1 else f"vehicles[{first}] to [{last - 1}]"
            load, weight = block.axle_loads.sum(), block.total_mass * GRAVITY
            lowest, highest = USUAL_LOAD
            if block.loads_are_given and not lowest < load / weight < highest:
                yield (
                    f"{place}: axle_load_n of {block.axle_count} axles are {load:.4g} N together, but "
                    f"{block.total_mass:.5g} kg weigh {weight:.4g} N"
                )
            first = last

    @property
    def blocks(self) -> tuple[Block, ...]:
        """What moves on its own but for the track, from the head to the tail."""
        return _blocks(self.vehicles)

    @property
    def length(self) -> float:
        """Length over all vehicles in m."""
        return sum(vehicle.length for vehicle in self.vehicles)

    @property
    def axle_count(self) -> int:
        """How many axles the train has."""
        return sum(block.axle_count for block in self.blocks)

    @property
    def axle_positions(self) -> NDArray[np.float64]:
        """Positions of all axles in m, ascending, from the tail end of the train; shape (axle_count,)."""
        blocks = self.blocks[::-1]
        rear_ends = np.cumsum([0.0] + [block.length for block in blocks[:-1]])
        return np.concatenate([x + block.axle_positions for x, block in zip(rear_ends, blocks, strict=True)])

    @property
    def axle_distances(self) -> NDArray[np.float64]:
        """Distinct signed distances α_j − α_k between axles, ascending, m."""
        alpha = self.axle_positions
        return np.unique(np.round(alpha[:, None] - alpha[None, :], 9))

    @property
    def axle_vehicles(self) -> NDArray[np.int64]:
        """Number of every axle's vehicle, 1 at the head, in the order of `axle_positions`."""
        numbers, first = [], 1
        for block in self.blocks:
            own = block.axle_vehicles if isinstance(block, Rake) else np.zeros(AXLES, np.int64)
            numbers.append(first + own)
            first += len(block.vehicles) if isinstance(block, Rake) else 1
        return np.concatenate(numbers[::-1])

    @property
    def wheel_spectra(self) -> tuple[Unevenness | None, ...]:
        """Roughness of every axle's wheels, None where they are smooth, in the order of `axle_positions`."""
        rough = [vehicle.wheel_roughness for vehicle in self.vehicles]
        return tuple(
            None if roughness is None else roughness.spectrum
            for roughness in (rough[number - 1] for number in self.axle_vehicles)
        )

    @property
    def has_rough_wheels(self) -> bool:
        """Whether any wheelset is out of round."""
        return any(vehicle.wheel_roughness is not None for vehicle in self.vehicles)

    @property
    def axle_loads(self) -> NDArray[np.float64]:
        """Static axle loads in N, in the order of `axle_positions`."""
        return np.concatenate(
            [
                block.axle_loads if isinstance(block, Rake) else np.full(AXLES, block.axle_load)
                for block in self.blocks[::-1]
            ]
        )

    @property
    def contact_stiffness(self) -> NDArray[np.float64]:
        """Hertz spring per axle in N/m, in the order of `axle_positions`."""
        return np.concatenate(
            [np.broadcast_to(block.contact_stiffness, block.axle_count) for block in self.blocks[::-1]]
        )


@lru_cache(64)
def _blocks(vehicles: tuple[Vehicle | CompositeVehicle, ...]) -> tuple[Block, ...]:
    """Return the blocks of a train's vehicles."""
    blocks: list[Block] = []
    standing: list[CompositeVehicle] = []
    for vehicle, behind in pairwise((*vehicles, None)):
        if isinstance(vehicle, Vehicle):
            blocks.append(vehicle)
            continue
        assert vehicle is not None
        standing.append(vehicle)
        if not isinstance(behind, CompositeVehicle) or behind.support is None:
            blocks.append(Rake(tuple(standing)))
            standing = []
    return tuple(blocks)


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
    omega = _free(angular_frequency)
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


@lru_cache(256)
def _suspension_modes(vehicle: Vehicle) -> NDArray[np.complex128]:
    """Return the eigenvalues of a vehicle's chains, see `chain_flexibilities`, that oscillate."""
    primary = np.array([vehicle.primary_damping, vehicle.primary_stiffness])
    secondary = 0.5 * np.array([vehicle.secondary_damping, vehicle.secondary_stiffness])
    bogie = vehicle.bogie_mass / 2.0
    pitching_bogie = 2.0 * vehicle.bogie_pitch_inertia / vehicle.axle_spacing**2
    modes = [np.roots([pitching_bogie, *primary])]
    for car in (vehicle.car_mass / 4.0, vehicle.car_pitch_inertia / vehicle.bogie_spacing**2):
        # Dynamic stiffnesses as polynomials in s, highest power first.
        below = np.polyadd([bogie, 0.0, 0.0], np.polyadd(primary, secondary))
        above = np.polyadd([car, 0.0, 0.0], secondary)
        modes.append(np.roots(np.polysub(np.polymul(below, above), np.polymul(secondary, secondary))))
    eigenvalue = np.concatenate(modes)
    return np.asarray(eigenvalue[eigenvalue.imag > 0.0])


def wheelset_receptance(vehicle: Block, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
    """Return the receptances between the wheelsets of a vehicle or a rake, Σ_W = Bᵀ (K − ω²M)⁻¹ B (Eq. 4).

    Parameters
    ----------
    vehicle, angular_frequency
        The vehicle, or several by parts that stand on each other; ω as in `chain_flexibilities`.

    Returns
    -------
    Receptances in m/N, shape ω.shape + (axles, axles), wheelsets ascending in x.
    """
    flexibilities = vehicle.flexibilities(_free(angular_frequency))
    return np.asarray(np.einsum("c...,clm->...lm", flexibilities, vehicle.shapes))


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
    receptances = {block: wheelset_receptance(block, omega) for block in set(train.blocks)}
    receptance = np.zeros((*omega.shape, train.axle_count, train.axle_count), dtype=np.complex128)
    first = 0
    for block in reversed(train.blocks):
        axles = slice(first, first + block.axle_count)
        receptance[..., axles, axles] = receptances[block]
        first += block.axle_count
    return receptance


def _free(angular_frequency: ArrayLike) -> NDArray[np.float64]:
    """Return frequencies at which a free vehicle has receptances.

    Raises
    ------
    InputError
        If one is 0 or not finite.
    """
    omega = np.asarray(angular_frequency, dtype=np.float64)
    if not np.all(np.isfinite(omega)) or np.any(omega == 0.0):
        refused = omega[~np.isfinite(omega) | (omega == 0.0)].flat[0]
        raise InputError(
            f"angular_frequency = {refused:g} rad/s: must be finite and not 0, where a free vehicle has none"
        )
    return omega


def _in_series(spring: NDArray[Any], beyond: NDArray[Any]) -> NDArray[np.complex128]:
    """Return the dynamic stiffness of a spring with the stiffness `beyond` at its far end."""
    return np.asarray(spring * beyond / (spring + beyond), dtype=np.complex128)
