"""One case, or the rail's receptance, from Python: no cluster, no files."""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from railvib.errors import InputError
from railvib.forces.receptance import receptances
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import third_octaves, threads
from railvib.parameters.approach import APPROACHES, Approach, Averaging
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.metric import FEWEST_PASSAGES, METRICS, MOST_PASSAGES, Metric
from railvib.parameters.receiver import FARTHEST, RAIL, Receiver
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.plausibility import check_contact, check_damping, check_inputs, check_speed, check_tolerance
from railvib.psd.spectra import Spectra
from railvib.stages.graph import case_spectra, evaluate
from railvib.stages.passage_dataset import passage_dataset
from railvib.stages.passage_levels import PassageLevelsOfCase
from railvib.stages.transfer_table import TransferTable
from railvib.transfer.highest_frequencies import highest_tabulated_frequency
from railvib.transfer.table import TransferBlock
from railvib.transfer.transfer_function import TransferFunction

if TYPE_CHECKING:
    import xarray

_DEFAULT_APPROACHES: tuple[Approach, ...] = ("moving-roughness", "moving-roughness-uncorrelated", "full")
_CONTRIBUTIONS = ("dynamic", "quasi-static", "total")


@lru_cache(maxsize=64)
def _table(stage: TransferTable) -> TransferBlock:
    table: TransferBlock = evaluate([stage])[stage]
    return table


@threads.single()
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
    Eq. 14 and 19 of the paper; docs/conventions.md. The tables of a ground and a track are kept for the
    next call.
    """
    f, d = np.broadcast_arrays(np.asarray(frequency, float), np.asarray(distance, float))
    if not (np.all(np.isfinite(f)) and np.all(f >= 0.0)):
        raise InputError(f"frequency = {frequency!r} Hz: must be finite and not negative")
    if not (np.isfinite(speed) and speed >= 0.0):
        raise InputError(f"speed = {speed} m/s: must be finite and not negative")
    if not np.all(np.isfinite(d)):
        raise InputError(f"distance = {distance!r} m: must be finite")
    check_tolerance(tolerance)
    check_damping(ground)
    check_contact(ground, track, float(f.min(initial=np.inf)), float(f.max(initial=0.0)))
    if speed == 0.0:
        block_indices = sorted(
            {int(block) for block in blocks.nearest_block(f.ravel(), range(blocks.LOWEST, 20))}
        )
    else:
        block_indices = list(blocks.up_to(highest_tabulated_frequency(track, float(f.max()), speed)))
    stages = [
        TransferTable(ground=ground, track=track, tolerance=tolerance, receiver=RAIL, block=block)
        for block in block_indices
    ]
    rail = TransferFunction([_table(stage) for stage in stages], track)
    receptance = np.empty(f.shape, complex)
    for value in np.unique(f):
        rows = f == value
        receptance[rows] = receptances(rail, track, speed, d[rows], [value], tolerance)[0]
    return receptance[()]


@threads.single()
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
        Where wheels are out of round, contributions include ``rails`` and ``wheels``, the parts of
        ``dynamic``.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    receivers = _receivers(offsets, rail)
    _check(receivers, approaches, refinement)
    band = third_octaves.midbands(minimum_frequency, maximum_frequency)
    case = _case(ground, track, train, unevenness, speed, receivers, band, tolerance) | {
        "averaging": (averaging,),
        "cross_section": cross_section or CrossSection(),
        "refinement": refinement,
    }
    stages = [case_spectra(approach, **case) for approach in approaches]
    results = evaluate(stages)
    return _dataset([results[stage] for stage in stages], receivers, averaging)


@threads.single()
def predict_passage(
    ground: Ground,
    track: Track,
    train: Train,
    unevenness: Unevenness,
    speed: float,
    offsets: Iterable[float] = (),
    *,
    rail: bool = True,
    approaches: Sequence[Approach] = _DEFAULT_APPROACHES,
    minimum_frequency: float = 1.0,
    maximum_frequency: float = 100.0,
    tolerance: float = 1e-4,
    cross_section: CrossSection | None = None,
    metrics: Sequence[Metric] = METRICS,
    quantiles: Sequence[float] = (0.05, 0.5, 0.95),
    passages: int = 64,
    seed: int = 1,
) -> "xarray.Dataset":
    """Predict the random passage of one case in time, by several approaches.

    Parameters
    ----------
    ground, track, train, unevenness, speed, offsets, rail, approaches
        As for `predict`.
    minimum_frequency, maximum_frequency, tolerance, cross_section
        As for `predict`; the histories hold the bands between these frequencies.
    metrics
        Which levels; see `railvib.parameters.metric`.
    quantiles
        Over realisations of the unevenness, between 0 and 1.
    passages
        Number of sampled passages, from 16 to 65,536; all their histories are returned.
    seed
        Seed of the ensemble, which all cases share.

    Returns
    -------
    xarray.Dataset
        ``variance`` σ²(t), (m/s)², and ``quasi_static`` m(t), m/s, over (approach, receiver, time);
        ``velocity`` of the sampled passages over (approach, passage, receiver, time), m/s; ``level`` over
        (approach, receiver, metric, statistic), in the units of the coordinate ``unit``, NaN where a metric
        has no such statistic. The middle of the train passes at 0 s.

    Raises
    ------
    InputError
        If a value is out of range.

    Notes
    -----
    docs/theory/passage.md
    """
    receivers = _receivers(offsets, rail)
    _check(receivers, approaches, refinement=1)
    _check_levels(metrics, quantiles, passages, seed)
    band = third_octaves.midbands(minimum_frequency, maximum_frequency)
    case = _case(ground, track, train, unevenness, speed, receivers, band, tolerance)
    levels: dict[str, Any] = {
        "metrics": tuple(metrics),
        "quantiles": tuple(float(quantile) for quantile in quantiles),
        "passages": passages,
        "seed": seed,
    }
    section = cross_section or CrossSection()
    stages = [
        PassageLevelsOfCase(
            approach=approach, **case, **levels, cross_section=section if approach == "fe-be" else None
        )
        for approach in approaches
    ]
    results = evaluate(stages)
    return passage_dataset([(stage, results[stage]) for stage in stages], results.__getitem__)


def _case(
    ground: Ground,
    track: Track,
    train: Train,
    unevenness: Unevenness,
    speed: float,
    receivers: tuple[Receiver, ...],
    band: np.ndarray,
    tolerance: float,
) -> dict[str, Any]:
    """Return the fields that all stages of a case have, checked together."""
    check_inputs(ground, track, speed)
    check_tolerance(tolerance)
    check_damping(ground)
    check_speed(ground, track, speed)
    lower, upper = third_octaves.edges(band)
    check_contact(ground, track, float(lower[0]), float(upper[-1]))
    return {
        "ground": ground,
        "track": track,
        "train": train,
        "unevenness": unevenness,
        "speed": float(speed),
        "band": tuple(band.tolist()),
        "receivers": receivers,
        "tolerance": tolerance,
    }


def _check_levels(metrics: Sequence[str], quantiles: Sequence[float], passages: int, seed: int) -> None:
    for metric in metrics:
        if metric not in METRICS:
            raise InputError(f"metric = {metric!r}: must be one of {', '.join(METRICS)}")
    if not metrics:
        raise InputError(f"metrics is empty: must name at least one of {', '.join(METRICS)}")
    for quantile in quantiles:
        if not 0.0 < quantile < 1.0:
            raise InputError(f"quantile = {quantile}: must be above 0 and below 1")
    if not FEWEST_PASSAGES <= passages <= MOST_PASSAGES:
        raise InputError(f"passages = {passages}: must be from {FEWEST_PASSAGES} to {MOST_PASSAGES}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")


def _receivers(offsets: Iterable[float], rail: bool) -> tuple[Receiver, ...]:
    """Return the receivers, the rail first, then by offset."""
    ground = sorted({float(offset) for offset in offsets})
    return (*([RAIL] if rail else []), *(Receiver(offset) for offset in ground))


def _check(receivers: Sequence[Receiver], approaches: Sequence[str], refinement: int) -> None:
    for receiver in receivers:
        if receiver.offset is not None and not 0.0 <= receiver.offset <= FARTHEST:
            raise InputError(f"offset = {receiver.offset} m: must be from 0 to {FARTHEST:g} m")
    for approach in approaches:
        if approach not in APPROACHES:
            raise InputError(f"approach = {approach!r}: must be one of {', '.join(APPROACHES)}")
    if not approaches:
        raise InputError(f"approaches is empty: must name at least one of {', '.join(APPROACHES)}")
    if refinement < 1 or refinement & (refinement - 1):
        raise InputError(f"refinement = {refinement}: must be 1, 2, 4 or another power of two")
    if not receivers:
        raise InputError("offsets is empty and rail is False: there is no receiver")


def _dataset(spectra: Sequence[Spectra], receivers: Sequence[Receiver], averaging: str) -> "xarray.Dataset":
    """Return the spectra by several approaches as one dataset."""
    import xarray

    first = spectra[0]
    force = _forces(first)
    parts = ("rails", "wheels") if "wheels" in first.contribution else ()
    contributions = (*_CONTRIBUTIONS, *parts)

    def velocities(values: str) -> list[list[np.ndarray]]:
        return [
            [getattr(each, values)[_rows(each, name, averaging)] for name in contributions]
            for each in spectra
        ]

    def forces(values: str) -> list[np.ndarray]:
        return [getattr(each, values)[_forces(each)] for each in spectra]

    by_receiver, by_axle = ("approach", "contribution", "receiver"), ("approach", "axle")
    return xarray.Dataset(
        {
            "velocity_psd": ((*by_receiver, "frequency"), velocities("psd"), {"unit": "(m/s)2/Hz"}),
            "velocity_mean_square": ((*by_receiver, "band"), velocities("mean_square"), {"unit": "(m/s)2"}),
            "force_psd": ((*by_axle, "frequency"), forces("psd"), {"unit": "N2/Hz"}),
            "force_mean_square": ((*by_axle, "band"), forces("mean_square"), {"unit": "N2"}),
            "extrapolated_share": ("band", first.extrapolated_share, {"unit": "1"}),
        },
        coords={
            "approach": [each.approach for each in spectra],
            "contribution": list(contributions),
            "receiver": [receiver.title for receiver in receivers],
            "offset": ("receiver", [receiver.offset_m for receiver in receivers], {"unit": "m"}),
            "axle": [int(name.removeprefix("axle-")) for name in first.receiver[force]],
            "frequency": ("frequency", first.frequency, {"unit": "Hz"}),
            "band": ("band", first.band, {"unit": "Hz"}),
        },
        attrs={"averaging": averaging},
    ).sortby("axle")


def _forces(spectra: Spectra) -> np.ndarray:
    """Return which series are wheel–rail forces, of rails and wheels together."""
    return np.asarray((spectra.quantity == "wheel_rail_force") & (spectra.contribution == "dynamic"))


def _rows(spectra: Spectra, contribution: str, averaging: str) -> np.ndarray:
    """Return which series are velocities of a contribution.

    The full model and the response to the axle loads are those of a whole passage, however moving roughness
    is averaged.
    """
    rows = (spectra.contribution == contribution) & (spectra.quantity == "velocity")
    averaged = rows & (spectra.averaging == averaging)
    return np.asarray(averaged if averaged.any() else rows)
