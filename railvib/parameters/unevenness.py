"""Power spectral densities of rail unevenness over wavenumber, in the forms that the literature uses.

One-sided S_w(β) in m²/(rad/m), β > 0: the variance in a band of wavenumbers is ∫ S_w dβ over it. Forms
published over cycles per metre are converted by S_w(β) = S(n)/2π, n = β/2π. The forms, their sources and
ranges of validity are in docs/theory/unevenness.md.
"""

import math
from typing import Annotated, Literal, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.numerics import third_octaves
from railvib.parameters.validation import Integer, Number, Parameters

T = TypeVar("T")

Wavelength = Annotated[Number, Field(ge=1e-4, le=1e5)]
Density = Annotated[Number, Field(ge=1e-30, le=1e12)]

Form = Literal[
    "fra-hamid-yang",
    "fra-av",
    "german-low",
    "german-high",
    "sncf-good",
    "sncf-poor",
    "table",
    "power-law",
]

# Hamid and Yang (1981) as in Frýba (1996): cycles/m, and m for classes 1 to 6.
HAMID_YANG_N1, HAMID_YANG_N2 = 0.0233, 0.131
HAMID_YANG_A = (15.53e-8, 8.85e-8, 4.92e-8, 2.75e-8, 1.57e-8, 0.98e-8)

# The FRA's form with roughness coefficients A_v, Garg and Dukkipati (1984): rad/m, and m²·rad/m by class.
FRA_K, FRA_BETA_C = 0.25, 0.8245
FRA_A = (1.2107e-4, 1.0181e-4, 0.6816e-4, 0.5376e-4, 0.2095e-4, 0.0339e-4)

# The German spectra, ORE B176 (1989): rad/m and m²·rad/m.
GERMAN_BETA_C, GERMAN_BETA_R = 0.8246, 0.0206
GERMAN_A = {"german-low": 4.032e-7, "german-high": 1.08e-6}

# The SNCF's spectra, Frýba (1996): cycles/m and m³.
SNCF_N0 = 0.0489
SNCF_A = {"sncf-good": 308e-6 * 0.509, "sncf-poor": 308e-6 * 1.79}

WAVELENGTHS: dict[str, tuple[float, float]] = {
    "fra-hamid-yang": (1.524, 304.8),
    "fra-av": (1.524, 304.8),
    "german-low": (3.0, 150.0),
    "german-high": (3.0, 150.0),
    "sncf-good": (2.0, 40.0),
    "sncf-poor": (2.0, 40.0),
    "power-law": (0.0, math.inf),
}
"""Shortest and longest wavelength in m for which a form is stated; a power law states none."""

FORM_FIELDS = ("line_class", "wavelength", "level", "spectral_density", "amplitude", "exponent")

OWN_FIELDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "fra-hamid-yang": (("line_class",),),
    "fra-av": (("line_class",),),
    "table": (("wavelength", "level"), ("wavelength", "spectral_density")),
    "power-law": (("amplitude", "exponent"),),
}
"""What a form needs of `FORM_FIELDS`, as alternatives; the others are refused. Forms not listed need none."""

# Every form but tables and power laws is smooth over ln β, its nearest singularity π/2 off the axis: over
# panels of unit width twelve Gauss points leave rounding only.
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)


STEEPEST = 50.0
"""Largest |d ln S/d ln β| with which a spectrum continues beyond a table: 50 dB per one-third octave."""


class UnevennessBands(NamedTuple):
    """One-third octaves of unevenness over wavelength."""

    wavelength: NDArray[np.float64]
    """Exact midbands in m, ascending."""
    mean_square: NDArray[np.float64]
    """Variance of each band in m²."""
    extrapolated_share: NDArray[np.float64]
    """Share of it that comes from outside the form's range of validity."""


class Unevenness(Parameters):
    """The unevenness of the rail as a stationary random process, given by its one-sided PSD.

    ``Unevenness(form="fra-hamid-yang", line_class=3)`` is the one of the paper. Outside a form's range of
    validity it is extrapolated, unless cut-off wavelengths are set, outside which it is 0. A table is a power
    law between its points, and continues its first and last segments beyond them.

    Raises
    ------
    InputError
        If a value is out of range, or does not belong to the form.
    """

    form: Form
    """Which spectrum; those named ``fra-...`` have six classes."""
    line_class: Annotated[Integer, Field(ge=1, le=6)] | None = None
    """FRA class of the line, from 1, the roughest, to 6."""
    wavelength: tuple[Wavelength, ...] | None = Field(default=None, alias="wavelength_m")
    """Table: wavelengths, m, ascending or descending."""
    level: tuple[Annotated[Number, Field(ge=-1e6, le=1e6)], ...] | None = Field(
        default=None, alias="level_db"
    )
    """Table: one-third-octave levels centred at the wavelengths, dB re 1e-6 m."""
    spectral_density: tuple[Density, ...] | None = Field(default=None, alias="spectral_density_m3")
    """Table: S_w(2π/wavelength), m² per rad/m."""
    amplitude: Density | None = Field(default=None, alias="amplitude_m3")
    """Power law S(n) = A n^−w: A, the density at 1 cycle/m, m² per cycle/m."""
    exponent: Annotated[Number, Field(ge=-100.0, le=100.0)] | None = None
    """Power law S(n) = A n^−w: w."""
    minimum_wavelength: Wavelength | None = Field(default=None, alias="minimum_wavelength_m")
    """Cut-off: no unevenness at shorter wavelengths, m."""
    maximum_wavelength: Wavelength | None = Field(default=None, alias="maximum_wavelength_m")
    """Cut-off: no unevenness at longer wavelengths, m."""

    @model_validator(mode="after")
    def _fields_fit_form(self) -> Self:
        alternatives = OWN_FIELDS.get(self.form, ((),))
        given = tuple(name for name in FORM_FIELDS if getattr(self, name) is not None)
        if given not in alternatives:
            needed = " or ".join(" and ".join(map(_key, names)) for names in alternatives) or "no further key"
            raise ValueError(
                f"form = {self.form!r} needs {needed}, here given: {', '.join(map(_key, given)) or 'none'}"
            )
        return self

    @model_validator(mode="after")
    def _table_is_one(self) -> Self:
        if self.wavelength is None:
            return self
        values = self.level if self.level is not None else self.spectral_density
        count = 0 if values is None else len(values)
        if count != len(self.wavelength) or count < 2:
            raise ValueError(
                f"wavelength_m has {len(self.wavelength)} values, the column beside it {count}: "
                "a table needs equally many, at least 2"
            )
        steps = np.diff(self.wavelength)
        if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            raise ValueError("wavelength_m must ascend or descend throughout, each value once")
        with np.errstate(over="ignore"):
            density = self._knots[1]
        if not np.all((density > 0.0) & np.isfinite(density)):
            raise ValueError("the table's spectral densities must be positive and finite, in m3")
        return self

    @model_validator(mode="after")
    def _continuation_is_not_too_steep(self) -> Self:
        slopes: dict[str, float] = {}
        if self.form == "power-law":
            slopes = {"exponent": _require(self.exponent)}
        elif self.form == "table":
            slope = _slopes(*self._knots).tolist()
            slopes = {
                "the table's slope at its long end": slope[0],
                "the table's slope at its short end": slope[-1],
            }
        for name, value in slopes.items():
            if not abs(value) <= STEEPEST:
                raise ValueError(
                    f"{name} = {value:.3g}: |d ln S/d ln wavenumber| must be {STEEPEST:g} or less where the "
                    "spectrum continues"
                )
        return self

    @model_validator(mode="after")
    def _cut_offs_ascend(self) -> Self:
        shortest, longest = self.cut_offs
        if shortest >= longest:
            raise ValueError(
                f"minimum_wavelength_m = {shortest:g} m must be below maximum_wavelength_m = {longest:g} m"
            )
        return self

    @property
    def cut_offs(self) -> tuple[float, float]:
        """Shortest and longest wavelength in m of the unevenness: 0 and infinity where not set."""
        longest = math.inf if self.maximum_wavelength is None else self.maximum_wavelength
        return self.minimum_wavelength or 0.0, longest

    @property
    def uncut(self) -> "Unevenness":
        """The same unevenness without cut-offs."""
        return self.model_copy(update={"minimum_wavelength": None, "maximum_wavelength": None})

    @property
    def validity(self) -> tuple[float, float]:
        """Shortest and longest wavelength in m for which the form is stated; (0, inf) for a power law."""
        if self.wavelength is not None:
            return min(self.wavelength), max(self.wavelength)
        return WAVELENGTHS[self.form]

    def psd(self, wavenumber: ArrayLike) -> NDArray[np.float64]:
        """Return the one-sided S_w(β) in m²/(rad/m).

        Parameters
        ----------
        wavenumber
            β in rad/m, positive, any shape.

        Raises
        ------
        InputError
            If a wavenumber is not positive and finite.
        """
        beta = np.asarray(wavenumber, dtype=np.float64)
        if not np.all((beta > 0.0) & np.isfinite(beta)):
            refused = beta[~((beta > 0.0) & np.isfinite(beta))].flat[0]
            raise InputError(f"wavenumber = {refused:g} rad/m: must be positive and finite")
        lowest, highest = _wavenumbers(*self.cut_offs)
        return np.where((beta >= lowest) & (beta <= highest), self._uncut_psd(beta), 0.0)

    def band_mean_square(self, lower: ArrayLike, upper: ArrayLike) -> NDArray[np.float64]:
        """Return the variance ∫ S_w dβ between wavenumbers, in m², to rounding.

        Parameters
        ----------
        lower, upper
            Limits in rad/m, 0 < lower <= upper, of shapes that broadcast.

        Raises
        ------
        InputError
            If the limits are not positive, finite and ascending.
        """
        lower, upper = np.broadcast_arrays(np.asarray(lower, np.float64), np.asarray(upper, np.float64))
        if not np.all((lower > 0.0) & (lower <= upper) & np.isfinite(upper)):
            raise InputError("lower and upper wavenumbers: must be positive, finite and ascending, in rad/m")
        return self._integral(lower, upper, _wavenumbers(*self.cut_offs))

    def extrapolated_share(self, lower: ArrayLike, upper: ArrayLike) -> NDArray[np.float64]:
        """Return the share of the variance between wavenumbers that lies outside the form's validity.

        Parameters
        ----------
        lower, upper
            Limits in rad/m, 0 < lower <= upper, of shapes that broadcast.

        Returns
        -------
        Shares from 0 to 1; 0 where the band holds no unevenness.

        Raises
        ------
        InputError
            If the limits are not positive, finite and ascending.
        """
        total = self.band_mean_square(lower, upper)
        lower, upper = np.broadcast_arrays(np.asarray(lower, np.float64), np.asarray(upper, np.float64))
        lowest, highest = _wavenumbers(*self.cut_offs)
        first_valid, last_valid = _wavenumbers(*self.validity)
        outside = self._integral(lower, upper, (lowest, min(first_valid, highest)))
        outside += self._integral(lower, upper, (max(last_valid, lowest), highest))
        return np.divide(outside, total, out=np.zeros_like(total), where=total > 0.0)

    def third_octaves(self, minimum_wavelength: float, maximum_wavelength: float) -> UnevennessBands:
        """Return the one-third octaves over wavelength, as in figure 3 of the paper.

        Parameters
        ----------
        minimum_wavelength, maximum_wavelength
            Limits of the midbands in m, both included.

        Raises
        ------
        InputError
            If the limits are not positive, finite and ascending, or no midband lies between them.
        """
        wavelength = third_octaves.midbands(minimum_wavelength, maximum_wavelength)
        shortest, longest = third_octaves.edges(wavelength)
        limits = 2.0 * np.pi / longest, 2.0 * np.pi / shortest
        return UnevennessBands(wavelength, self.band_mean_square(*limits), self.extrapolated_share(*limits))

    def _uncut_psd(self, beta: NDArray[np.float64]) -> NDArray[np.float64]:
        n = beta / (2.0 * np.pi)
        match self.form:
            case "fra-hamid-yang":
                a, n1, n2 = HAMID_YANG_A[_require(self.line_class) - 1], HAMID_YANG_N1, HAMID_YANG_N2
                return a * n2**2 * (n**2 + n1**2) / (n**4 * (n**2 + n2**2)) / (2.0 * np.pi)
            case "fra-av":
                a, beta_c = FRA_A[_require(self.line_class) - 1], FRA_BETA_C
                return FRA_K * a * beta_c**2 / (beta**2 * (beta**2 + beta_c**2))
            case "german-low" | "german-high":
                a, beta_c, beta_r = GERMAN_A[self.form], GERMAN_BETA_C, GERMAN_BETA_R
                return a * beta_c**2 / ((beta**2 + beta_r**2) * (beta**2 + beta_c**2))
            case "sncf-good" | "sncf-poor":
                return SNCF_A[self.form] / (1.0 + n / SNCF_N0) ** 3 / (2.0 * np.pi)
            case "power-law":
                return _require(self.amplitude) * n ** -_require(self.exponent) / (2.0 * np.pi)
            case "table":
                return _power_laws_between(*self._knots, beta)

    @property
    def _knots(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The table's wavenumbers in rad/m, ascending, and S_w there; empty for a form without a table."""
        if self.wavelength is None:
            return np.empty(0), np.empty(0)
        beta = 2.0 * np.pi / np.asarray(self.wavelength)
        if self.spectral_density is not None:
            density = np.asarray(self.spectral_density)
        else:
            mean_square = third_octaves.UNEVENNESS_REFERENCE**2 * 10.0 ** (
                np.asarray(_require(self.level)) / 10.0
            )
            lower, upper = third_octaves.edges(beta)
            density = mean_square / (upper - lower)
        order = np.argsort(beta)
        return beta[order], density[order]

    def _integral(
        self, lower: NDArray[np.float64], upper: NDArray[np.float64], window: tuple[float, float]
    ) -> NDArray[np.float64]:
        """Return ∫ S_w dβ over the part of each interval that lies in a window of wavenumbers."""
        start, stop = np.maximum(lower, window[0]).ravel(), np.minimum(upper, window[1]).ravel()
        inside = start < stop
        # Cut at the knots of a table, and into panels of at most unit width in the logarithm.
        knots = self._knots[0]
        ends = np.sort(np.clip(knots, start[inside, None], stop[inside, None]), axis=1)
        limits = np.concatenate([start[inside, None], ends, stop[inside, None]], axis=1)
        result = np.zeros(start.size)
        if self.form in ("table", "power-law"):
            result[inside] = _power_law_integrals(limits, self._uncut_psd(limits)).sum(axis=1)
            return result.reshape(lower.shape)
        limits = np.log(limits)
        first, width = limits[:, :-1].ravel(), np.diff(limits, axis=1).ravel()
        count = np.maximum(np.ceil(width), 1.0).astype(int)
        owner = np.repeat(np.arange(count.size), count)
        place = np.arange(owner.size) - np.repeat(np.cumsum(count) - count, count)
        half = 0.5 * (width / count)[owner, None]
        beta = np.exp(first[owner, None] + half * (2.0 * place[:, None] + 1.0 + GAUSS_POINTS))
        part = (half * GAUSS_WEIGHTS * self._uncut_psd(beta) * beta).sum(axis=1)
        result[inside] = np.bincount(owner // (knots.size + 1), part, np.count_nonzero(inside))
        return result.reshape(lower.shape)


def _power_laws_between(
    knots: NDArray[np.float64], density: NDArray[np.float64], beta: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Interpolate log S linearly over log β, and continue the first and last segments beyond the table."""
    x, y = np.log(knots), np.log(density)
    slope = _slopes(knots, density)
    segment = np.clip(np.searchsorted(knots, beta) - 1, 0, slope.size - 1)
    return np.asarray(np.exp(y[segment] + slope[segment] * (np.log(beta) - x[segment])))


def _slopes(knots: NDArray[np.float64], density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return d ln S/d ln β between the points of a table."""
    return np.asarray(np.diff(np.log(density)) / np.diff(np.log(knots)))


def _power_law_integrals(beta: NDArray[np.float64], density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ∫ S dβ of the power laws between neighbouring wavenumbers, given with S along the last axis."""
    # ∫ βS d ln β, with βS exponential in ln β, written from the larger end so that nothing overflows.
    value = beta * density
    width = np.diff(np.log(beta))
    change = np.abs(np.diff(np.log(value)))
    mean = np.divide(-np.expm1(-change), change, out=np.ones_like(change), where=change > 0.0)
    return np.asarray(np.maximum(value[..., 1:], value[..., :-1]) * width * mean)


def _wavenumbers(shortest: float, longest: float) -> tuple[float, float]:
    """Return the lowest and highest wavenumber in rad/m of a range of wavelengths that may be open."""
    return 2.0 * math.pi / longest, 2.0 * math.pi / shortest if shortest > 0.0 else math.inf


def _key(name: str) -> str:
    """Return the name of a field in study files."""
    return Unevenness.model_fields[name].alias or name


def _require(value: T | None) -> T:
    """Return a field that the check of the form has found to be there."""
    assert value is not None
    return value
