"""Amplitudes of a passage by moving roughness.

    U_nm = (Δf/v) H̃(β_n − 2πf_m/v, y, f_n) A(β_n, f_m) i2πf_n √Δβ_n,        f_n = β_n v/2π

The response is that to the unevenness at its own frequency f_n, at the place where the train is: the transfer
function at f_n is heard at the lines f_m while the train moves, or while the receiver moves past a train that
stands. Waves of low frequency are heard along more line than a record holds. There the lines are closer by a
power of two, and a window cuts the record out of the longer one.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.signal import upfirdn

from railvib.passage.amplitudes import Block, Response, line_phases, trimmed
from railvib.passage.grid import Grid
from railvib.transfer.transfer_function import TransferFunction

_MOST_DIVISIONS = 64
"""Largest number of parts into which the step of the lines is divided."""
_FLAT = 0.2
"""Share of the record on either side of its middle that the window leaves unchanged."""
_TAPS = 12
"""Lines on either side that the window spreads a line over."""


class Harmonics(NamedTuple):
    """Amplitudes of some harmonics on all lines at which they are heard."""

    row: int
    """Index of the first harmonic."""
    division: int
    """Number of parts into which the step of the lines is divided."""
    first: int
    """First line, in steps."""
    value: np.ndarray
    """U_nm, complex (harmonics, lines), m/s; the middle of the train passes at 0 s."""
    set: int
    """Which unevenness."""


def moving_roughness_harmonics(
    function: TransferFunction,
    amplitude: np.ndarray,
    position: np.ndarray,
    speed: float,
    grid: Grid,
) -> Iterator[Harmonics]:
    """Yield the amplitudes of velocity at a receiver, octave by octave of the unevenness.

    Parameters
    ----------
    function
        The receiver's transfer function.
    amplitude
        q_l of every set of unevenness at the grid's wavenumbers, N/√(rad/m), complex (sets, n, axles).
    position
        Axles from the middle of the train, m, (axles,).
    speed
        m/s.
    grid
        Lines and wavenumbers; harmonics whose own frequency lies beyond the lines are left out.
    """
    excited = grid.wavenumber * speed / (2.0 * np.pi)
    rows = np.flatnonzero((excited >= grid.frequency[0]) & (excited <= grid.frequency[-1]))
    for group in np.split(rows, np.flatnonzero(np.diff(np.floor(2.0 * np.log2(excited[rows])))) + 1):
        if not group.size:
            continue
        beta, f = grid.wavenumber[group], excited[group]
        division = _division(grid, float(beta[0]), speed)
        step = grid.step / division
        for inside, response in Response.of(function, f):
            reach = response.reach * speed / (2.0 * np.pi)
            own = f[inside]
            first, last = int(np.floor((own[0] - reach) / step)), int(np.ceil((own[-1] + reach) / step))
            line = step * np.arange(first, last + 1)
            kappa = beta[inside][:, None] - 2.0 * np.pi / speed * line
            transfer = response.at(kappa[:, ::-1])[:, ::-1]
            transfer *= (2j * np.pi * own * step / speed * np.sqrt(grid.width[group][inside]))[:, None]
            phase = line_phases(line, position, speed).T
            for number, sets in enumerate(amplitude):
                value = (sets[group][inside] @ phase) * transfer
                yield Harmonics(int(group[inside][0]), division, first, value, number)


def moving_roughness_amplitudes(
    function: TransferFunction,
    amplitude: np.ndarray,
    position: np.ndarray,
    speed: float,
    grid: Grid,
) -> Iterator[Block]:
    """Yield the amplitudes of velocity at a receiver on the lines of the record.

    Parameters
    ----------
    function, amplitude, position, speed, grid
        As for `moving_roughness_harmonics`.
    """
    first_line = round(grid.frequency[0] / grid.step)
    count = grid.frequency.size
    for harmonics in moving_roughness_harmonics(function, amplitude, position, speed, grid):
        start, value = _on_record(harmonics)
        value = value * np.where(np.arange(start, start + value.shape[1]) % 2, -1.0, 1.0)
        for conjugate in (False, True):
            if conjugate:
                start, value = 1 - start - value.shape[1], value[:, ::-1].conj()
            low, high = max(start, first_line), min(start + value.shape[1], first_line + count)
            if low >= high:
                continue
            part = value[:, low - start : high - start]
            block = trimmed(Block(harmonics.row, low - first_line, part, conjugate, harmonics.set))
            if block is not None:
                yield block


def _division(grid: Grid, beta: float, speed: float) -> int:
    """Return into how many parts the step is divided so that the line heard at β fits into a record."""
    heard = (grid.period + grid.stretch / beta) * grid.step / speed
    return int(min(2 ** max(np.ceil(np.log2(heard)), 0.0), _MOST_DIVISIONS))


def _on_record(harmonics: Harmonics) -> tuple[int, np.ndarray]:
    """Return the first line of the record, and the amplitudes on its lines."""
    if harmonics.division == 1:
        return harmonics.first, harmonics.value
    window = _window(harmonics.division)
    half = window.size // 2
    start, lead = divmod(harmonics.first - half, harmonics.division)
    padded = np.pad(harmonics.value, ((0, 0), (lead, 0)))
    return start, np.asarray(upfirdn(window, padded, 1, harmonics.division, axis=1))


@lru_cache(16)
def _window(division: int) -> np.ndarray:
    """Return the spectrum of the window on the closer lines, (taps,)."""
    time = (np.arange(4096) + 0.5) / 4096 - 0.5
    ramp = np.clip((np.abs(time) - _FLAT) / (0.5 - _FLAT), 0.0, 1.0)
    shape = np.cos(0.5 * np.pi * ramp) ** 2
    place = np.arange(-_TAPS * division, _TAPS * division + 1) / division
    return np.asarray(np.cos(2.0 * np.pi * place[:, None] * time) @ shape / time.size)
