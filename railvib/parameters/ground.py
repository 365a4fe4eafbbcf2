"""The layered ground: what it is made of, in the conventions of the whole project.

Axes: x along the track, y lateral, z downward. Time factor e^{+iωt}. Hysteretic damping: the shear modulus
and the constrained modulus are both multiplied by 1 + iη sgn ω, so both wave speeds share the complex factor
√(1 + iη).
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.parameters.validation import LossFactor, Number, Parameters

USUAL_DENSITY = 500.0, 3500.0
"""kg/m³, from peat to heavy rock; beyond, a density was probably given in another unit."""


@cache
def _rayleigh_ratio(ratio: float) -> float:
    """Return the Rayleigh speed over the shear speed, for ratio = (c_s/c_p)²."""
    # Rayleigh's equation, rationalised, in ξ = (c/c_s)²; its smallest root between 0 and 1 is the wave's.
    roots = np.roots([1.0, -8.0, 24.0 - 16.0 * ratio, -16.0 * (1.0 - ratio)])
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)]
    return float(np.sqrt(real.min()))


class Layer(Parameters):
    """One homogeneous, isotropic, viscoelastic layer of the ground.

    Raises
    ------
    InputError
        If a value is out of range, or if the dilatational speed does not exceed √(4/3) of the shear speed
        (which would be a negative bulk modulus).
    """

    shear_speed: Number = Field(alias="shear_speed_m_s", ge=10.0, le=5000.0)
    """Speed of shear waves without damping, m/s."""
    dilatational_speed: Number = Field(alias="dilatational_speed_m_s", ge=10.0, le=1e5)
    """Speed of dilatational waves without damping, m/s."""
    density: Number = Field(alias="density_kg_m3", ge=1.0, le=1e8)
    """Mass density, kg/m³."""
    loss_factor: LossFactor
    """Hysteretic loss factor η, twice the damping ratio."""
    thickness: Number | None = Field(default=None, alias="thickness_m", ge=0.01, le=1e4)
    """Thickness, m; None for the half-space below all layers."""

    @model_validator(mode="after")
    def _bulk_modulus_is_positive(self) -> Self:
        least = math.sqrt(4.0 / 3.0) * self.shear_speed
        if self.dilatational_speed <= least:
            raise InputError(
                f".dilatational_speed_m_s = {self.dilatational_speed:g} m/s: must exceed sqrt(4/3) of "
                f"shear_speed_m_s = {self.shear_speed:g} m/s, {least:.6g} m/s: else the bulk modulus is < 0"
            )
        return self

    def unusual(self) -> Iterator[str]:
        """Yield that the density is not one of soil or rock."""
        lowest, highest = USUAL_DENSITY
        if not lowest <= self.density <= highest:
            usual = f"soil and rock have {lowest:g} to {highest:g} kg/m³"
            yield f"density_kg_m3 = {self.density:g} kg/m³: {usual}"

    @property
    def shear_modulus(self) -> float:
        """Shear modulus without damping, Pa."""
        return self.density * self.shear_speed**2

    @property
    def rayleigh_speed(self) -> float:
        """Speed of Rayleigh waves on a half-space of this material without damping, m/s."""
        return self.shear_speed * _rayleigh_ratio((self.shear_speed / self.dilatational_speed) ** 2)

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio."""
        ratio = (self.shear_speed / self.dilatational_speed) ** 2
        return (1.0 - 2.0 * ratio) / (2.0 - 2.0 * ratio)


class Ground(Parameters):
    """Horizontal layers on a half-space or on rigid bedrock.

    Raises
    ------
    InputError
        If there is no layer, a layer above the base has no thickness, or the last layer's thickness does not
        fit the base.
    """

    layers: tuple[Layer, ...] = Field(min_length=1, max_length=200)
    """From the surface down; the last is the half-space unless the base is rigid."""
    base: Literal["half-space", "rigid"] = "half-space"
    """What lies under the layers."""

    @model_validator(mode="after")
    def _thicknesses_fit_base(self) -> Self:
        finite = self.layers if self.base == "rigid" else self.layers[:-1]
        for number, layer in enumerate(finite):
            if layer.thickness is None:
                raise InputError(
                    f".layers[{number}].thickness_m: is missing; a layer above the base has a thickness in m"
                )
        if self.base == "half-space" and self.layers[-1].thickness is not None:
            raise InputError(
                f".layers[{len(self.layers) - 1}].thickness_m = {self.layers[-1].thickness:g} m: the last "
                'layer is the half-space and has no thickness, unless base = "rigid"'
            )
        return self

    @property
    def homogeneous(self) -> bool:
        """Whether this is one half-space, whose flexibility depends on wavenumber over frequency only."""
        first = self.layers[0].model_copy(update={"thickness": None})
        return self.base == "half-space" and all(
            layer.model_copy(update={"thickness": None}) == first for layer in self.layers
        )

    @property
    def slowest_speed(self) -> float:
        """Lower bound of the speeds of waves along the surface, m/s: just below every Rayleigh speed."""
        return 0.98 * min(layer.rayleigh_speed for layer in self.layers)

    def wave_speeds(self) -> Iterator[float]:
        """Yield every layer's dilatational and shear speed, m/s."""
        for layer in self.layers:
            yield layer.dilatational_speed
            yield layer.shear_speed

    def require_damping(self, least: float) -> None:
        """Refuse a layer whose loss factor is below `least`: the response to its waves is hardly bounded.

        Raises
        ------
        InputError
            Naming the first such layer.
        """
        for number, layer in enumerate(self.layers):
            if layer.loss_factor < least:
                raise InputError(
                    f"layers[{number}].loss_factor = {layer.loss_factor:g}: must be {least:g} or more for a "
                    "prediction: undamped, the response is infinite at the wavenumbers of its waves"
                )

    def stack(self) -> np.ndarray:
        """Return the layers as the kernels read them.

        Returns
        -------
        ndarray of float, shape (layers, 5)
            Shear speed, dilatational speed, density, loss factor, thickness, in SI units.
            Thickness is infinite for a half-space; a rigid base has none.
        """
        return np.array(
            [
                (
                    layer.shear_speed,
                    layer.dilatational_speed,
                    layer.density,
                    layer.loss_factor,
                    np.inf if layer.thickness is None else layer.thickness,
                )
                for layer in self.layers
            ]
        )
