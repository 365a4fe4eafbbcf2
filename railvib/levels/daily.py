"""Values of a day or a night from those of single passages, as standards form them."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railvib.errors import InputError
from railvib.levels import references
from railvib.levels.weightings import KB_CORNER
from railvib.numerics import third_octaves

TAKT = 30.0
"""Clock interval, s."""
SUPPRESSION = 0.1
"""KB, or v_eff in mm/s, up to which a value counts as zero (DIN 4150-2, SBR-B)."""
INTERVALS: Mapping[str, int] = MappingProxyType({"day": 1920, "night": 960})
"""Clock intervals of DIN 4150-2: day from 6 to 22 h, and night."""
SBR_INTERVALS: Mapping[str, int] = MappingProxyType({"day": 1440, "evening": 480, "night": 960})
"""Clock intervals of SBR-B: day from 7 to 19 h, evening to 23 h, and night."""
TRAIN_FACTOR: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "tram": MappingProxyType({"surface": 0.7, "underground": 1.0}),
        "suburban": MappingProxyType({"surface": 0.8, "underground": 1.0}),
        "passenger": MappingProxyType({"surface": 0.9, "underground": 1.0}),
        "freight": MappingProxyType({"surface": 1.0, "underground": 1.0}),
        "long-freight": MappingProxyType({"surface": 1.3, "underground": 1.3}),
    }
)
"""Weighting factor α of E DIN 4150-2:2023-08, table 2; a long freight train has more than 600 m."""
MAXIMUM_FACTOR = 1.5
"""KB_Fmax of a category of trains over its KB_FTm, E DIN 4150-2:2023-08 (7)."""
PEAK_FACTOR = 3.0
"""Peak velocity in mm/s over KB_Fmax, E DIN 45672-3:2023-02."""
KB_BANDS = (4.0, 80.0)
"""Nominal midbands in Hz whose maximum levels make KB, E DIN 45672-3:2023-02 clause 7."""


def kb_ftm(maxima: ArrayLike) -> float:
    """Return KB_FTm of the maxima KB_FTi of clock intervals, DIN 45669-1:2010 (2).

    A maximum up to 0.1 counts as zero, and its interval still counts.
    """
    return float(np.sqrt(np.mean(_suppressed(_values("maxima", maxima)) ** 2)))


def kb_ftr(kb_ftm: ArrayLike, intervals: ArrayLike, period: str) -> float:
    """Return KB_FTr by DIN 4150-2:1999 (A.3), without the factor of rest hours, which rail traffic has not.

    Parameters
    ----------
    kb_ftm
        KB_FTm of every class of trains.
    intervals
        Clock intervals that the class occupies in the period.
    period
        ``"day"`` or ``"night"``.

    Raises
    ------
    InputError
        If a value is negative, the arrays do not fit, the period is unknown or has fewer intervals.
    """
    severity, number = _values("kb_ftm", kb_ftm), _values("intervals", intervals)
    total = _intervals(period, INTERVALS)
    if number.sum() > total:
        raise InputError(f"intervals = {number.sum():g}: a {period} has {total}")
    return float(np.sqrt(_sum_of_squares(severity, number) / total))


def category_kb_ftm(maxima: ArrayLike) -> float:
    """Return KB_FTm,Zug of a category from the maxima of its passages, E DIN 4150-2:2023-08 (5).

    One interval per passage, and none suppressed.
    """
    return float(np.sqrt(np.mean(_values("maxima", maxima) ** 2)))


def category_kb_ftr(kb_ftm: ArrayLike, trains: ArrayLike, factor: ArrayLike, period: str) -> float:
    """Return KB_FTr by E DIN 4150-2:2023-08 (6): one interval per train, categories up to 0.1 suppressed.

    Parameters
    ----------
    kb_ftm
        KB_FTm,Zug of every category, from `category_kb_ftm`.
    trains
        Its trains in the period.
    factor
        Its weighting factor α, from `TRAIN_FACTOR`, or one for all.
    period
        ``"day"`` or ``"night"``.

    Raises
    ------
    InputError
        If a value is negative, the arrays do not fit, or the period is unknown.
    """
    severity = _suppressed(_values("kb_ftm", kb_ftm)) * _values("factor", factor)
    total = _intervals(period, INTERVALS)
    return float(np.sqrt(_sum_of_squares(severity, _values("trains", trains)) / total))


def kb_of_bands(midband: ArrayLike, level: ArrayLike) -> float:
    """Return KB_FTm,Zug from maximum Fast levels in one-third octaves, E DIN 45672-3:2023-02 clause 7.

    The weighting is that of table 2, KB at the nominal midbands in tenths of a decibel.

    Parameters
    ----------
    midband
        Exact midband frequencies, Hz.
    level
        Levels of velocity, dB re 5e-8 m/s; those from 4 to 80 Hz count.
    """
    nominal = np.array([float(third_octaves.nominal_label(f)) for f in np.atleast_1d(midband)])
    weighting = np.round(-10.0 * np.log10(1.0 + (KB_CORNER / nominal) ** 2), 1)
    square = references.mean_square(np.asarray(level) + weighting, references.VELOCITY_DIN)
    lowest, highest = KB_BANDS
    return float(np.sqrt(square[(nominal >= lowest) & (nominal <= highest)].sum()) / 1e-3)


def v_per(maxima: ArrayLike, numbers: ArrayLike, period: str) -> float:
    """Return V_per of SBR-B: √(mean of v²_eff,max,30 over all clock intervals of a period).

    Parameters
    ----------
    maxima
        v_eff,max,30 of every kind of interval, 1 at 1 mm/s; up to 0.1 it counts as zero.
    numbers
        How many such intervals the period has.
    period
        ``"day"``, ``"evening"`` or ``"night"``.

    Raises
    ------
    InputError
        If a value is negative, the arrays do not fit, or the period is unknown.
    """
    total = _intervals(period, SBR_INTERVALS)
    severity = _suppressed(_values("maxima", maxima))
    return float(np.sqrt(_sum_of_squares(severity, _values("numbers", numbers)) / total))


def vdv_of_events(vdv: ArrayLike, numbers: ArrayLike) -> float:
    """Return the vibration dose value of a day or night from those of its events (BS 6472-1), m/s^1.75.

    Parameters
    ----------
    vdv
        Vibration dose value of every kind of event, m/s^1.75.
    numbers
        How many there are.
    """
    dose = _values("vdv", vdv)
    return float(_sum_of_squares(dose**2, _values("numbers", numbers)) ** 0.25)


def equivalent_mean_square(
    mean_square: ArrayLike, duration: ArrayLike, numbers: ArrayLike, over: float
) -> float:
    """Return the mean square over a time of the events in it, as the Leq of the FTA is formed.

    Parameters
    ----------
    mean_square
        Mean square of every kind of event over its duration.
    duration
        Its duration, s.
    numbers
        How many there are.
    over
        The time, s, such as 3600.
    """
    energy = _values("mean_square", mean_square) * _values("duration", duration)
    return float(np.sum(energy * _values("numbers", numbers)) / over)


def _suppressed(value: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(value <= SUPPRESSION, 0.0, value)


def _sum_of_squares(value: NDArray[np.float64], number: NDArray[np.float64]) -> float:
    if value.shape != number.shape:
        raise InputError(f"{value.size} values and {number.size} numbers: must be one number for each value")
    return float(np.sum(number * value**2))


def _values(name: str, value: ArrayLike) -> NDArray[np.float64]:
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if not array.size or not np.all(np.isfinite(array) & (array >= 0.0)):
        raise InputError(f"{name} = {value!r}: must be finite and not negative, and at least one")
    return array


def _intervals(period: str, intervals: Mapping[str, int]) -> int:
    if period not in intervals:
        raise InputError(f"period = {period!r}: must be one of {', '.join(intervals)}")
    return intervals[period]
