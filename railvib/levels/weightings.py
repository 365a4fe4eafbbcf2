"""Frequency weightings as analogue filters, and their exact application by Fourier transform.

With s = if, f in Hz, every weighting is a product of

    high pass  s²/(s² + √2 f₁ s + f₁²)        low pass  f₂²/(s² + √2 f₂ s + f₂²)

and what the standard adds. A digital filter made by the bilinear transform differs from these near half its
sampling rate; a product with the spectrum of a signal padded with zeros does not.

| weighting | acts on | source |
|---|---|---|
| band limits 1–80 and 4–315 Hz, KB | velocity | DIN 45669-1:2010 (3), (4) |
| SBR-B | velocity | 1/√(1 + (5.6/f)²), without a printed band limit |
| Wb, Wd, Wk, Wm | acceleration | ISO 8041-1:2017 table 3 |
| W'm | velocity | Wm of the derivative, times 0.028 s |
| third octave | any | Butterworth filter of order 3, IEC 61260-1 |
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from railvib.numerics.third_octaves import HALF_BAND

Response = Callable[[NDArray[np.float64]], NDArray[np.complex128]]
"""Complex response at frequencies ≥ 0 in Hz."""

KB_CORNER = 5.6
"""Hz."""
BAND_MARGIN = 0.8
"""Corner of a meter's high pass over its lowest frequency, and highest frequency over the low pass's."""
WM_TIME = 0.028
"""s: 1/(2π·0.028 s) = 5.684 Hz is the corner of Wm."""
REST = 6.0
"""Periods of a weighting's lowest corner after which nothing is left of its response, below 1e-11."""


@dataclass(frozen=True)
class Weighting:
    """A frequency weighting.

    Attributes
    ----------
    quantity
        What it acts on.
    unit
        Unit of what is weighted; "1" where it is divided by 1 mm/s.
    reference
        What the quantity is divided by, in its SI unit.
    lowest_corner
        Hz.
    response
        Its response to the quantity over the reference.
    """

    quantity: Literal["velocity", "acceleration"]
    unit: str
    reference: float
    lowest_corner: float
    response: Response

    def of_velocity(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return its response to velocity in m/s at frequencies ≥ 0 in Hz, of the same shape."""
        f = np.asarray(frequency, dtype=np.float64)
        derivative = 2j * np.pi * f if self.quantity == "acceleration" else 1.0
        return np.asarray(self.response(f) * derivative / self.reference)

    @property
    def rest(self) -> float:
        """Time after a signal's end until its weighted form is at rest, s."""
        return REST / self.lowest_corner


def band_limit(lowest: float, highest: float) -> Response:
    """Return the band limitation of a meter that works from a lowest to a highest frequency, Hz.

    DIN 45669-1:2010 (3); its corners are 0.8 of the lowest frequency and the highest one over 0.8.
    """
    return _band(BAND_MARGIN * lowest, highest / BAND_MARGIN)


def kb(lowest: float = 1.0, highest: float = 80.0) -> Response:
    """Return the KB weighting of a meter with a band limitation, DIN 45669-1:2010 (4)."""
    limit = band_limit(lowest, highest)
    return lambda f: limit(f) * sbr_b(f)


def sbr_b(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the weighting of SBR-B, s/(s + 5.6 Hz)."""
    s = 1j * frequency
    return np.asarray(s / (s + KB_CORNER))


def third_octave(midband: float) -> Response:
    """Return the Butterworth filter of order 3 of a one-third octave, −3.01 dB at its edges.

    Parameters
    ----------
    midband
        Exact midband frequency, Hz.
    """
    quality = 1.0 / (HALF_BAND - 1.0 / HALF_BAND)

    def response(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        s = 1j * frequency
        # p = q(s/f + f/s), multiplied by s so that 0 Hz is no exception.
        p, one = quality * (s * s + midband**2) / midband, s
        return np.asarray(one**3 / ((p + one) * (p * p + p * one + one * one)))

    return response


def _band(low: float, high: float) -> Response:
    def response(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        s = 1j * frequency
        high_pass = s * s / (s * s + np.sqrt(2.0) * low * s + low**2)
        low_pass = high**2 / (s * s + np.sqrt(2.0) * high * s + high**2)
        return np.asarray(high_pass * low_pass)

    return response


def _whole_body(
    band: tuple[float, float],
    transition: tuple[float, float],
    step: tuple[float, float, float, float] | None = None,
    gain: float = 1.0,
) -> Response:
    """Return a weighting of ISO 8041-1 from f₁ and f₂, f₃ = f₄ and Q₄, f₅, Q₅, f₆ and Q₆, and K."""
    limit = _band(*band)
    f4, q4 = transition

    def response(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        s = 1j * frequency
        h = gain * limit(frequency) * (1.0 + s / f4) / (1.0 + s / (q4 * f4) + (s / f4) ** 2)
        if step is not None:
            f5, q5, f6, q6 = step
            h *= (1.0 + s / (q5 * f5) + (s / f5) ** 2) / (1.0 + s / (q6 * f6) + (s / f6) ** 2)
            h *= (f5 / f6) ** 2
        return np.asarray(h)

    return response


_WB = _whole_body((0.4, 100.0), (16.0, 0.55), (2.5, 0.9, 4.0, 0.95), 1.024)
_WD = _whole_body((0.4, 100.0), (2.0, 0.63))
_WK = _whole_body((0.4, 100.0), (12.5, 0.63), (2.37, 0.91, 3.35, 0.91))
_WM = _whole_body((10.0**-0.1, 100.0), (1.0 / (2.0 * np.pi * WM_TIME), 0.5))


def _wm_velocity(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.asarray(_WM(frequency) * 2j * np.pi * frequency * WM_TIME)


WEIGHTINGS: Mapping[str, Weighting] = MappingProxyType(
    {
        "band-1-80": Weighting("velocity", "m/s", 1.0, 0.8, band_limit(1.0, 80.0)),
        "band-4-315": Weighting("velocity", "m/s", 1.0, 3.2, band_limit(4.0, 315.0)),
        "kb": Weighting("velocity", "1", 1e-3, 0.8, kb()),
        "kb-4-315": Weighting("velocity", "1", 1e-3, 3.2, kb(4.0, 315.0)),
        "sbr-b": Weighting("velocity", "1", 1e-3, KB_CORNER, sbr_b),
        "wb": Weighting("acceleration", "m/s2", 1.0, 0.4, _WB),
        "wd": Weighting("acceleration", "m/s2", 1.0, 0.4, _WD),
        "wk": Weighting("acceleration", "m/s2", 1.0, 0.4, _WK),
        "wm": Weighting("acceleration", "m/s2", 1.0, 10.0**-0.1, _WM),
        "wm-velocity": Weighting("velocity", "m/s", 1.0, 10.0**-0.1, _wm_velocity),
    }
)
"""Weightings by name."""


def weighted(signal: ArrayLike, step: float, response: Response, rest: float) -> NDArray[np.float64]:
    """Return signals after a filter that was at rest when they began.

    Parameters
    ----------
    signal
        Samples, (..., n).
    step
        Time between samples, s.
    response
        The filter's response to the signal.
    rest
        Time until the filter's own response has died out, s, such as `Weighting.rest`.

    Returns
    -------
    ndarray, shape (..., n)
    """
    samples = np.asarray(signal, dtype=np.float64)
    count = samples.shape[-1]
    padded = fft.next_fast_len(count + int(np.ceil(rest / step)), real=True)
    spectrum = fft.rfft(samples, padded) * response(fft.rfftfreq(padded, step))
    return np.asarray(fft.irfft(spectrum, padded)[..., :count])


def weighted_rms(frequency: ArrayLike, psd: ArrayLike, response: Response) -> NDArray[np.float64]:
    """Return √∫ S |H|² df over equidistant lines of one-sided PSDs.

    Parameters
    ----------
    frequency
        Hz, (n,), equidistant.
    psd
        One-sided densities per Hz, (..., n).
    response
        Response to the quantity of the PSD.
    """
    f = np.asarray(frequency, dtype=np.float64)
    square = np.abs(response(f)) ** 2
    return np.asarray(np.sqrt(np.trapezoid(np.asarray(psd) * square, f, axis=-1)))
