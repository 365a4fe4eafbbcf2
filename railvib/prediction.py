"""One case from Python: no cluster, no files."""

import warnings
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from railvib.errors import InputError, PlausibilityWarning
from railvib.forces.receptance import (
    Receptances,
    highest_tabulated_frequency,
    receptances,
    tabulated_receptances,
)
from railvib.forces.wheel_rail import axle_distances
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import third_octaves, threads
from railvib.parameters.approach import APPROACHES, Approach, Averaging
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.plausibility import check_damping, check_speed
from railvib.psd.line_integrals import LineIntegrals, line_integrals
from railvib.psd.moving_roughness import spans
from railvib.psd.quasi_static import quasi_static_spectra
from railvib.psd.spectra import Spectra, highest_excitation, line_step, lines, spectra
from railvib.psd.train_average import TrainIntegrals, train_integrals
from railvib.transfer.table import Receiver, TransferBlock, TransferFunction
from railvib.transfer.tabulate import LOOSEST, TIGHTEST, largest_wavenumber, transfer_blocks

if TYPE_CHECKING:
    import xarray

_DEFAULT_APPROACHES: tuple[Approach, ...] = ("moving-roughness", "moving-roughness-uncorrelated", "full")


@lru_cache(maxsize=64)
def _rail_block(ground: Ground, track: Track, block: int, tolerance: float) -> TransferBlock:
    return transfer_blocks(ground, track, block, ["rail"], tolerance)["rail"]


@threads.limited
def rail_receptance(
    track: Track,
    ground: Ground,
    frequency: npt.ArrayLike,
    distance: npt.ArrayLike = 0.0,
    speed: float = 0.0,
    tolerance: float = 1e-4,
) -> np.ndarray:
    """Return the rail's displacement at a distance ahead of a standing or moving harmonic load.

    Parameters
    ----------
    track, ground
        The track, and the ground under it.
    frequency
        Frequency of the load, Hz, not negative.
    distance
        Signed distance ahead of the load, m. Both broadcast.
    speed
        Speed of the load, m/s, not negative.
    tolerance
        Relative error allowed.

    Returns
    -------
    ndarray of complex
        σ_R(d, ω; v), m/N.

    Raises
    ------
    InputError
        If a frequency or the speed is negative, a value is not finite, or the tolerance cannot be met.

    Notes
    -----
    Eq. 14 and 19 of the paper; CONVENTIONS section 3. The tables of a ground and a track are kept for the
    next call.
    """
    f, d = np.broadcast_arrays(np.asarray(frequency, float), np.asarray(distance, float))
    if not (np.all(np.isfinite(f)) and np.all(f >= 0.0)):
        raise InputError(f"frequency = {frequency!r} Hz: must be finite and not negative")
    if not (np.isfinite(speed) and speed >= 0.0):
        raise InputError(f"speed = {speed} m/s: must be finite and not negative")
    if not np.all(np.isfinite(d)):
        raise InputError(f"distance = {distance!r} m: must be finite")
    _check_tolerance(tolerance)
    check_damping(ground)
    if speed == 0.0:
        needed = sorted({int(each) for each in blocks.assigned(f.ravel(), range(blocks.LOWEST, 20))})
    else:
        needed = list(blocks.up_to(highest_tabulated_frequency(track, float(f.max()), speed)))
    rail = TransferFunction((_rail_block(ground, track, block, tolerance) for block in needed), track)
    out = np.empty(f.shape, complex)
    for each in np.unique(f):
        here = f == each
        out[here] = receptances(rail, track, speed, d[here], [each], tolerance)[0]
    return out[()]


@threads.limited
def predict(
    ground: Ground,
    track: Track,
    train: Train,
    unevenness: Unevenness,
    speed: float,
    offsets: Iterable[float] = (),
    *,
    rail: bool = True,
    approaches: Sequence[Approach] = _DEFAULT_APPROACHES,
    averaging: Averaging = "line",
    minimum_frequency: float = 1.0,
    maximum_frequency: float = 100.0,
    tolerance: float = 1e-4,
    refinement: int = 1,
    cross_section: CrossSection | None = None,
) -> "xarray.Dataset":
    """Predict the vibration of one case by several approaches.

    Parameters
    ----------
    ground, track, train, unevenness
        What the case is made of.
    speed
        m/s, positive.
    offsets
        Distances of ground receivers from the centre line, m, not negative.
    rail
        Whether the rail is a receiver too.
    approaches
        Which approaches; see `railvib.parameters.approach.APPROACHES`.
    averaging
        Moving roughness averaged over the whole line, as a full pass-by sees it, or over the length of the
        train (Eq. 26).
    minimum_frequency, maximum_frequency
        Centres of the lowest and the highest one-third octave, Hz.
    tolerance
        Relative error allowed in the transfer functions.
    refinement
        For studies of convergence, a power of two: 2 halves all steps and panels that the tolerance gives
        and doubles the ranges of wavenumber and excitation.
    cross_section
        What the approach ``"fe-be"`` makes of the track's cross-section; without it the defaults.

    Returns
    -------
    xarray.Dataset
        ``velocity_psd`` and ``velocity_mean_square`` over (approach, contribution, receiver, frequency or
        band), ``force_psd`` and ``force_mean_square`` over (approach, axle, …), in SI units; axle 1 leads.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    asked = tuple(sorted({float(each) for each in offsets}))
    _check(speed, asked, approaches, rail, refinement)
    _check_tolerance(tolerance)
    check_damping(ground)
    check_speed(ground, track, speed)
    midband = third_octaves.midbands(minimum_frequency, maximum_frequency)
    receivers: list[Receiver] = ["rail", *asked] if rail else [*asked]
    highest = highest_excitation(midband, largest_wavenumber(track, refinement), speed, refinement)
    lower, upper = third_octaves.edges(midband)
    covering = blocks.covering(float(lower[0]), float(upper[-1]))
    moving = "full" in approaches
    tables: dict[Receiver, list[TransferBlock]] = {"rail": [], **{each: [] for each in asked}}
    top = (
        highest_tabulated_frequency(track, blocks.reach(blocks.up_to(highest)[-1]), speed, refinement)
        if moving
        else blocks.edges(covering[-1])[1]
    )
    for block in blocks.up_to(top):
        wanted: list[Receiver] = ["rail", *asked] if block in covering else ["rail"]
        for receiver, table in transfer_blocks(ground, track, block, wanted, tolerance, refinement).items():
            tables[receiver].append(table)
    _report(tables, tolerance)
    by_model = {False: {receiver: TransferFunction(table, track) for receiver, table in tables.items()}}
    if "fe-be" in approaches:
        section = cross_section or CrossSection()
        by_model[True] = _fe_be_functions(ground, track, section, covering, receivers, tolerance, refinement)
    distances = axle_distances(train)
    frequency = lines(midband, line_step(train.length, speed, refinement))
    made: list[Spectra] = []
    rails: dict[tuple[bool, float], Receptances] = {}
    integrals: dict[bool, dict[Receiver, LineIntegrals]] = {}
    over_train: dict[bool, dict[Receiver, TrainIntegrals]] = {}
    still: dict[bool, dict[Receiver, np.ndarray]] = {}
    for approach in approaches:
        v = speed if approach == "full" else 0.0
        model = approach == "fe-be"
        functions = by_model[model]
        if (model, v) not in rails:
            wanted_blocks = blocks.up_to(highest) if v else covering
            rails[model, v] = tabulated_receptances(
                functions["rail"], track, v, distances, wanted_blocks, tolerance, refinement
            )
        if model not in still:
            still[model] = quasi_static_spectra(
                {each: functions[each] for each in receivers},
                train.axle_positions,
                train.axle_loads,
                train.length,
                speed,
                frequency,
            )
        if approach != "full" and model not in integrals:
            integrals[model] = line_integrals(
                {each: functions[each] for each in receivers},
                spans(train.axle_positions),
                covering,
                tolerance,
                refinement,
            )
            if averaging == "train":
                over_train[model] = {
                    each: train_integrals(functions[each], train.axle_positions, frequency)
                    for each in receivers
                }
        made.append(
            spectra(
                approach,
                train,
                unevenness,
                speed,
                midband,
                rails[model, v],
                still[model],
                {each: functions[each] for each in receivers},
                integrals.get(model),
                highest,
                over_train.get(model),
                tolerance,
                refinement,
            )
        )
    return _dataset(made, averaging)


def _fe_be_functions(
    ground: Ground,
    track: Track,
    section: CrossSection,
    covering: range,
    receivers: Sequence[Receiver],
    tolerance: float,
    refinement: int,
) -> dict[Receiver, TransferFunction]:
    """Return the transfer functions by finite and boundary elements."""
    from railvib.fe_be.model import fe_be_blocks  # brings a finite-element library

    made = [
        fe_be_blocks(ground, track, section, block, receivers, tolerance, refinement) for block in covering
    ]
    return {receiver: TransferFunction((each[receiver] for each in made), track) for receiver in receivers}


def _check_tolerance(tolerance: float) -> None:
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise InputError(f"tolerance = {tolerance}: must be from {TIGHTEST:g} to {LOOSEST:g}")


def _check(
    speed: float, offsets: tuple[float, ...], approaches: Sequence[str], rail: bool, refinement: int
) -> None:
    if not (np.isfinite(speed) and speed > 0.0):
        raise InputError(f"speed = {speed} m/s: must be positive and finite")
    for offset in offsets:
        if not (np.isfinite(offset) and offset >= 0.0):
            raise InputError(f"offset = {offset} m: must be finite and not negative")
    for approach in approaches:
        if approach not in APPROACHES:
            raise InputError(f"approach = {approach!r}: must be one of {', '.join(APPROACHES)}")
    if not approaches:
        raise InputError(f"approaches is empty: must name at least one of {', '.join(APPROACHES)}")
    if refinement < 1 or refinement & (refinement - 1):
        raise InputError(f"refinement = {refinement}: must be 1, 2, 4 or another power of two")
    if not offsets and not rail:
        raise InputError("offsets is empty and rail is False: there is no receiver")


def _report(tables: dict[Receiver, list[TransferBlock]], tolerance: float) -> None:
    for table in tables.values():
        worst = max(table, key=lambda each: each.interpolation_error)
        shortfall = worst.shortfall(tolerance)
        if shortfall:
            warnings.warn(shortfall, PlausibilityWarning, stacklevel=3)


def _dataset(made: Sequence[Spectra], averaging: str) -> "xarray.Dataset":
    import xarray

    first = made[0]
    force = first.quantity == "wheel_rail_force"
    contributions = ["dynamic", "quasi-static", "total"]
    at = first.contribution == "quasi-static"
    names = [
        "rail" if name == "rail" else f"ground {y:g} m"
        for name, y in zip(first.receiver[at], first.offset_m[at], strict=True)
    ]

    def rows(each: Spectra, contribution: str) -> np.ndarray:
        # The full model and the quasi-static response are those of a whole pass-by, however the moving
        # roughness is averaged.
        there = (each.contribution == contribution) & (each.quantity == "velocity")
        averaged = there & (each.averaging == averaging)
        return np.asarray(averaged if averaged.any() else there)

    return xarray.Dataset(
        {
            "velocity_psd": (
                ("approach", "contribution", "receiver", "frequency"),
                np.array([[each.psd[rows(each, name)] for name in contributions] for each in made]),
                {"unit": "(m/s)2/Hz"},
            ),
            "velocity_mean_square": (
                ("approach", "contribution", "receiver", "band"),
                np.array([[each.mean_square[rows(each, name)] for name in contributions] for each in made]),
                {"unit": "(m/s)2"},
            ),
            "force_psd": (
                ("approach", "axle", "frequency"),
                np.array([each.psd[each.quantity == "wheel_rail_force"] for each in made]),
                {"unit": "N2/Hz"},
            ),
            "force_mean_square": (
                ("approach", "axle", "band"),
                np.array([each.mean_square[each.quantity == "wheel_rail_force"] for each in made]),
                {"unit": "N2"},
            ),
            "extrapolated_share": (("band",), first.extrapolated_share, {"unit": "1"}),
        },
        coords={
            "approach": [each.approach for each in made],
            "contribution": contributions,
            "receiver": names,
            "offset": ("receiver", first.offset_m[at], {"unit": "m"}),
            "axle": [int(name.removeprefix("axle-")) for name in first.receiver[force]],
            "frequency": ("frequency", first.frequency, {"unit": "Hz"}),
            "band": ("band", first.band, {"unit": "Hz"}),
        },
        attrs={"averaging": averaging},
    ).sortby("axle")
