"""Roughness of wheels out of round, as a random process along each wheel's tread."""

import math
from functools import lru_cache
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.numerics.third_octaves import UNEVENNESS_REFERENCE
from railvib.parameters.unevenness import Density, Unevenness, Wavelength
from railvib.parameters.validation import Number, Parameters

Level = Annotated[Number, Field(ge=-150.0, le=150.0)]

OWN_FIELDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "table": (("wavelength", "level"), ("wavelength", "spectral_density")),
    "power-law": (("amplitude", "exponent"),),
    "orders": (("order_level",),),
}
"""What a form needs, as alternatives; other fields of forms are refused."""


class WheelRoughness(Parameters):
    """The roughness of one wheelset, given by its one-sided PSD over wavelength, or by orders of the wheel.

    Wheelsets are independent of each other. No roughness is longer than the circumference, and a table ends
    where it ends. The level of an order is spread over half an order to either side of it, as that of wheels
    of different diameters is; between orders the density is a power law, within half a decibel of the orders'
    levels.

    Raises
    ------
    InputError
        If a value is out of range, or does not belong to the form.
    """

    form: Literal["table", "power-law", "orders"]
    """Which description."""
    circumference: Annotated[Number, Field(ge=0.5, le=10.0)] = Field(default=2.89, alias="circumference_m")
    """Of the wheels, m; 2.89 m at a diameter of 0.92 m."""
    wavelength: tuple[Wavelength, ...] | None = Field(default=None, alias="wavelength_m")
    """Table: wavelengths, m, ascending or descending."""
    level: tuple[Level, ...] | None = Field(default=None, alias="level_db")
    """Table: one-third-octave levels centred at the wavelengths, dB re 1e-6 m."""
    spectral_density: tuple[Density, ...] | None = Field(default=None, alias="spectral_density_m3")
    """Table: S_r(2π/wavelength), m² per rad/m."""
    amplitude: Density | None = Field(default=None, alias="amplitude_m3")
    """Power law S(n) = A n^−w: A, the density at 1 cycle/m, m² per cycle/m."""
    exponent: Annotated[Number, Field(ge=-50.0, le=50.0)] | None = None
    """Power law S(n) = A n^−w: w."""
    order_level: Annotated[tuple[Level, ...], Field(min_length=1, max_length=1000)] | None = Field(
        default=None, alias="order_level_db"
    )
    """Orders: root mean square of orders 1, 2, … of the circumference, dB re 1e-6 m."""

    @model_validator(mode="after")
    def _is_a_spectrum(self) -> Self:
        fields = ("wavelength", "level", "spectral_density", "amplitude", "exponent", "order_level")
        given = tuple(name for name in fields if getattr(self, name) is not None)
        if given not in OWN_FIELDS[self.form]:
            needed = " or ".join(" and ".join(map(_key, names)) for names in OWN_FIELDS[self.form])
            raise InputError(
                f".form = {self.form!r}: needs {needed}, here given: {', '.join(map(_key, given)) or 'none'}"
            )
        try:
            _ = self.spectrum
        except InputError as error:
            raise InputError(str(error).removeprefix("Unevenness")) from None
        return self

    @property
    def spectrum(self) -> Unevenness:
        """The spectrum as one of unevenness under the wheel, cut off where it ends."""
        return _spectrum(self)


@lru_cache(256)
def _spectrum(roughness: WheelRoughness) -> Unevenness:
    around = roughness.circumference
    if roughness.form == "power-law":
        return Unevenness(
            form="power-law",
            amplitude=roughness.amplitude,
            exponent=roughness.exponent,
            maximum_wavelength=around,
        )
    if roughness.form == "orders":
        # The variance of an order over its width of one order, 2π/circumference.
        levels = roughness.order_level or ()
        rms = [UNEVENNESS_REFERENCE * 10.0 ** (level / 20.0) for level in levels]
        density = [each**2 * around / (2.0 * math.pi) for each in rms]
        order = [0.5, *range(1, len(density) + 1), len(density) + 0.5]
        wavelength = [around / each for each in order]
        table: dict[str, Any] = {"spectral_density": (density[0], *density, density[-1])}
        longest = wavelength[0]
    else:
        assert roughness.wavelength is not None
        wavelength = list(roughness.wavelength)
        table = {"level": roughness.level, "spectral_density": roughness.spectral_density}
        longest = min(max(wavelength), around)
    return Unevenness(
        form="table",
        wavelength=tuple(wavelength),
        minimum_wavelength=min(wavelength),
        maximum_wavelength=longest,
        **table,
    )


def _key(name: str) -> str:
    """Return the name of a field in study files."""
    return WheelRoughness.model_fields[name].alias or name
