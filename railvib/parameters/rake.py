"""Vehicles by parts that stand on each other: their masses and springs, static loads and receptances.

Axes as everywhere: x along the track in the direction of travel, from the rear end of the rake; z downward.
The derivation is in docs/theory/vehicle.md.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import null_space

from railvib.errors import InputError
from railvib.numerics import threads
from railvib.parameters.composite_vehicle import Axle, CompositeVehicle
from railvib.parameters.units import GRAVITY

_ONE_PLACE = 1e-3
"""Distance below which two axles stand in one place, m."""


class PlacedAxle(NamedTuple):
    """An axle of a rake."""

    x: float
    """Distance from the rear end of the rake, m."""
    vehicle: int
    """Number of its vehicle, 0 at the head."""
    body: int
    """Number of the body that stands on it."""
    axle: Axle


@dataclass
class _Layout:
    """The bodies of a rake, their axles and joints, as they are found from the head to the tail."""

    inertia: list[float] = field(default_factory=list)
    """Mass and pitch inertia of every body, kg and kg·m²."""
    weight: list[float] = field(default_factory=list)
    """Weight of every body and 0 for its pitch, N."""
    centre: list[float] = field(default_factory=list)
    """x of every body, m."""
    axles: list[PlacedAxle] = field(default_factory=list)
    joints: list[tuple[float, int, int, float, float]] = field(default_factory=list)
    """x, the body above, the body below, stiffness in N/m (infinite if rigid) and damping in N·s/m."""

    def add_body(self, x: float, mass: float, pitch_inertia: float) -> int:
        """Add a body and return its number."""
        self.inertia += [mass, pitch_inertia]
        self.weight += [GRAVITY * mass, 0.0]
        self.centre.append(x)
        return len(self.centre) - 1

    def add_axles(self, front: float, vehicle: int, body: int, axles: Iterable[Axle]) -> None:
        """Add the axles under a body."""
        self.axles += [PlacedAxle(front - axle.position, vehicle, body, axle) for axle in axles]

    def add_joint(
        self, x: float, above: int, below: int, stiffness: float | None, damping: float | None
    ) -> None:
        """Add a joint, which is rigid without a stiffness."""
        self.joints.append((x, above, below, np.inf if stiffness is None else stiffness, damping or 0.0))

    def displacement(self, body: int, x: float) -> NDArray[np.float64]:
        """Return the displacement of a body at x per motion of all bodies, (motions,)."""
        row = np.zeros(len(self.inertia))
        row[2 * body : 2 * body + 2] = 1.0, x - self.centre[body]
        return row


class _Matrices(NamedTuple):
    """A rake as matrices over its motions: bounce and pitch of every body."""

    inertia: NDArray[np.float64]
    """Masses and pitch inertias, (motions,)."""
    weight: NDArray[np.float64]
    """Weights, (motions,), N."""
    axle: NDArray[np.float64]
    """Displacement above every axle, (motions, axles)."""
    joint: NDArray[np.float64]
    """Displacement below every joint less that above it, (motions, joints)."""
    primary: NDArray[np.float64]
    """Stiffness and damping above every axle, (2, axles), N/m and N·s/m."""
    spring: NDArray[np.float64]
    """Stiffness and damping of every joint, (2, joints)."""
    wheelset: NDArray[np.float64]
    """Masses of the wheelsets, (axles,), kg."""


@dataclass(frozen=True)
class Rake:
    """Vehicles by parts that stand on each other, or one vehicle alone.

    Attributes
    ----------
    vehicles
        From the head; all but the first stand on the one ahead.
    """

    vehicles: tuple[CompositeVehicle, ...]

    @property
    def length(self) -> float:
        """Length over all vehicles, m."""
        return sum(vehicle.length for vehicle in self.vehicles)

    @property
    def axle_count(self) -> int:
        """How many axles the rake has."""
        return len(self._layout.axles)

    @property
    def total_mass(self) -> float:
        """Mass of all vehicles, kg."""
        return sum(vehicle.total_mass for vehicle in self.vehicles)

    @property
    def axle_positions(self) -> NDArray[np.float64]:
        """Positions of the axles in m, ascending, from the rear end of the rake."""
        return np.array([placed.x for placed in self._layout.axles])

    @property
    def axle_vehicles(self) -> NDArray[np.int64]:
        """Number of every axle's vehicle, 0 at the head, in the order of `axle_positions`."""
        return np.array([placed.vehicle for placed in self._layout.axles], np.int64)

    @property
    def contact_stiffness(self) -> NDArray[np.float64]:
        """Hertz spring per axle in N/m, in the order of `axle_positions`."""
        return np.array([self.vehicles[placed.vehicle].contact_stiffness for placed in self._layout.axles])

    @property
    def axle_loads(self) -> NDArray[np.float64]:
        """Static axle loads in N, in the order of `axle_positions`: as given, or from the masses."""
        given = [placed.axle.load for placed in self._layout.axles]
        # Loads are part of identities: rounded, they are the same whichever library solves for them.
        weights = np.round(self.weights_on_axles, 6)
        return np.array([load or weight for load, weight in zip(given, weights, strict=True)])

    @property
    def loads_are_given(self) -> bool:
        """Whether any axle load is given, so that it may contradict the masses."""
        return any(placed.axle.load is not None for placed in self._layout.axles)

    @cached_property
    def weights_on_axles(self) -> NDArray[np.float64]:
        """What the axles carry at rest on level rails, N, in the order of `axle_positions`."""
        matrices = self._matrices
        motions, axles = matrices.axle.shape
        springs = axles + matrices.joint.shape[1]
        matrix = np.zeros((motions + springs,) * 2)
        matrix[:motions, motions:] = np.hstack([matrices.axle, -matrices.joint])
        matrix[motions:, :motions] = matrix[:motions, motions:].T
        spring = np.arange(motions, motions + springs)
        matrix[spring, spring] = -1.0 / np.concatenate([matrices.primary[0], matrices.spring[0]])
        load = np.concatenate([matrices.weight, np.zeros(springs)])
        carried = np.linalg.solve(matrix, load)[motions : motions + axles]
        return np.asarray(carried + GRAVITY * matrices.wheelset)

    @property
    def shapes(self) -> NDArray[np.float64]:
        """What of each of `flexibilities` is between the axles, (terms, axles, axles)."""
        row, column = np.triu_indices(self.axle_count)
        term = np.arange(row.size)
        shapes = np.zeros((row.size, self.axle_count, self.axle_count))
        shapes[term, row, column] = shapes[term, column, row] = 1.0
        return shapes

    @threads.single()
    def flexibilities(self, angular_frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the receptances between the axles, the upper triangle row by row.

        Parameters
        ----------
        angular_frequency
            ω in rad/s, any shape, not 0.

        Returns
        -------
        Receptances in m/N, shape (terms,) + ω.shape.

        Notes
        -----
        The forces in the joints are the unknowns. So free bodies cost no digits at low frequency, and a rigid
        joint is one without flexibility.
        """
        omega = np.asarray(angular_frequency, dtype=np.float64)
        flat = omega.reshape(-1)
        matrices = self._matrices
        free = matrices.axle / matrices.inertia[:, None]
        # Of the bodies above the axles, −ω² times displacement per force.
        moved = (matrices.axle.T @ free)[None]
        if matrices.joint.size:
            across = matrices.joint.T @ free
            given_way = (matrices.joint.T / matrices.inertia) @ matrices.joint
            joints = _diagonal(_flexibility(matrices.spring, flat)) - given_way
            moved = moved + across.T @ np.linalg.solve(joints, across[None])
        suspended = moved - _diagonal(_flexibility(matrices.primary, flat))
        on_wheelsets = suspended * matrices.wheelset + np.eye(self.axle_count)
        receptance = np.linalg.solve(on_wheelsets, suspended) / -(flat**2)[:, None, None]
        row, column = np.triu_indices(self.axle_count)
        return np.ascontiguousarray(receptance[:, row, column].T).reshape(row.size, *omega.shape)

    @cached_property
    def suspension_modes(self) -> NDArray[np.complex128]:
        """Eigenvalues of the bodies on wheelsets that are held, one of each oscillating pair, (n,).

        σ + iω with ω > 0: the mode e^{(σ + iω)t} has the frequency ω in rad/s, and σ ≤ 0. Overdamped modes,
        which do not oscillate, are left out. On a track much stiffer than the suspension the wheel–rail
        forces peak near these frequencies.
        """
        matrices = self._matrices
        rigid = np.isinf(matrices.spring[0])
        motions = np.eye(matrices.inertia.size)
        if rigid.any():
            motions = null_space(matrices.joint[:, rigid].T)
        across = motions.T @ np.hstack([matrices.axle, matrices.joint[:, ~rigid]])
        springs = np.hstack([matrices.primary, matrices.spring[:, ~rigid]])
        inertia = motions.T @ (matrices.inertia[:, None] * motions)
        stiffness, damping = (across * values @ across.T for values in springs)
        count = len(inertia)
        state = np.eye(2 * count, k=count)
        state[count:] = -np.linalg.solve(inertia, np.hstack([stiffness, damping]))
        eigenvalue = np.linalg.eigvals(state)
        return np.asarray(eigenvalue[eigenvalue.imag > 0.0])

    def check(self, where: Sequence[str]) -> None:
        """Refuse a rake that does not stand, or whose axles share a place.

        Parameters
        ----------
        where
            How messages name each vehicle, such as ``.vehicles[0]``.

        Raises
        ------
        InputError
            With the vehicle, and the value where there is one.
        """
        matrices, axles = self._matrices, self._layout.axles
        held = np.hstack([matrices.axle, matrices.joint])
        if np.linalg.matrix_rank(held) < held.shape[0]:
            raise InputError(
                f"{where[0]}: does not stand; every car and bogie needs two places that hold it up, on "
                "axles, bogies or a neighbour"
            )
        for behind, ahead in zip(axles[:-1], axles[1:], strict=True):
            if ahead.x - behind.x < _ONE_PLACE:
                raise InputError(
                    f"{where[behind.vehicle]}: an axle at position_m = {behind.axle.position:g} m stands "
                    "where another one does"
                )
        lightest = int(self.weights_on_axles.argmin())
        if self.weights_on_axles[lightest] <= 0.0:
            placed = axles[lightest]
            raise InputError(
                f"{where[placed.vehicle]}: the axle at position_m = {placed.axle.position:g} m would lift "
                f"off, carrying {self.weights_on_axles[lightest]:.4g} N at rest; check positions and masses"
            )

    @cached_property
    def _layout(self) -> _Layout:
        layout = _Layout()
        front = self.length
        car_ahead = bogie_ahead = -1
        for number, vehicle in enumerate(self.vehicles):
            car = layout.add_body(front - vehicle.car.position, vehicle.car.mass, vehicle.car.pitch_inertia)
            layout.add_axles(front, number, car, vehicle.axles)
            support = vehicle.support
            if support is not None:
                below = bogie_ahead if support.on == "bogie" else car_ahead
                layout.add_joint(front - support.position, car, below, support.stiffness, support.damping)
            for bogie in vehicle.bogies:
                frame = layout.add_body(front - bogie.position, bogie.mass, bogie.pitch_inertia)
                layout.add_axles(front, number, frame, bogie.axles)
                pivot = front - (bogie.position if bogie.pivot is None else bogie.pivot)
                layout.add_joint(pivot, car, frame, bogie.secondary_stiffness, bogie.secondary_damping)
                bogie_ahead = frame
            car_ahead = car
            front -= vehicle.length
        layout.axles.sort(key=lambda placed: placed.x)
        return layout

    @cached_property
    def _matrices(self) -> _Matrices:
        layout = self._layout
        axles = [placed.axle for placed in layout.axles]
        joint = [
            layout.displacement(below, x) - layout.displacement(above, x)
            for x, above, below, _stiffness, _damping in layout.joints
        ]
        return _Matrices(
            np.array(layout.inertia),
            np.array(layout.weight),
            np.array([layout.displacement(placed.body, placed.x) for placed in layout.axles]).T,
            np.array(joint).reshape(-1, len(layout.inertia)).T,
            np.array([[axle.primary_stiffness, axle.primary_damping] for axle in axles]).T,
            np.array([spring[3:] for spring in layout.joints]).reshape(-1, 2).T,
            np.array([axle.wheelset_mass for axle in axles]),
        )


def _flexibility(spring: NDArray[np.float64], omega: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return ω²/(k + iωc) of springs given as stiffness and damping, (frequencies, springs); 0 if rigid."""
    elastic = np.isfinite(spring[0])
    out = np.zeros((omega.size, spring.shape[1]), complex)
    out[:, elastic] = (omega**2)[:, None] / (spring[0, elastic] + 1j * omega[:, None] * spring[1, elastic])
    return out


def _diagonal(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return diagonal matrices, (n, m, m), of the rows of values, (n, m)."""
    return np.asarray(values[:, :, None] * np.eye(values.shape[1]))
