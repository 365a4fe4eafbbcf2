"""The track: two rails as one beam on pads, on sleepers or a slab, on ballast-like layers, on the ground.

All values are per metre of track and for both rails together. Hysteretic damping as in the ground: a
stiffness is multiplied by 1 + iη sgn ω.
"""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from railvib.errors import InputError
from railvib.parameters.validation import LossFactor, Number, Parameters

STIFFEST_ONE_RAIL = 7e6
"""N·m²; the bending stiffness of one heavy rail is below, of two light ones above."""
HEAVIEST_ONE_RAIL = 80.0
"""kg/m, in the same way."""


Coupling = Literal["centre", "mean"]
"""What of the ground's displacement a track follows: the centre line's, or the mean over its width."""


def _none_if_centre(coupling: Coupling | None) -> Coupling | None:
    """Return None for the coupling that tracks had before it could be chosen, so that their ids stay."""
    return None if coupling == "centre" else coupling


class TrackLayer(Parameters):
    """Distributed vertical springs with consistent mass: ballast, sub-ballast, embankment, slab mat."""

    stiffness: Number = Field(alias="stiffness_n_m2", ge=1e4, le=1e16)
    """Vertical stiffness per length of track, N/m²."""
    mass: Number = Field(default=0.0, alias="mass_kg_m", ge=0.0, le=1e6)
    """Mass per length of track, kg/m."""
    loss_factor: LossFactor = 0.0
    """Hysteretic loss factor."""


class Track(Parameters):
    """A ballasted or a slab track with an invariant cross-section.

    Raises
    ------
    InputError
        If a value is out of range, or does not belong to the form of the track.
    """

    form: Literal["ballasted", "slab"] = "ballasted"
    """Sleepers without bending stiffness along the track, or a slab as Euler beam."""
    rail_bending_stiffness: Number = Field(alias="rail_bending_stiffness_n_m2", ge=1e4, le=1e10)
    """Bending stiffness EI of both rails, N·m²."""
    rail_mass: Number = Field(alias="rail_mass_kg_m", ge=1.0, le=1e4)
    """Mass of both rails per length, kg/m."""
    rail_loss_factor: LossFactor = 0.0
    """Loss factor of the rails' bending stiffness."""
    pad_stiffness: Number = Field(alias="pad_stiffness_n_m2", ge=1e4, le=1e16)
    """Vertical stiffness of the rail pads per length of track, both rails, N/m²."""
    pad_loss_factor: LossFactor = 0.0
    """Loss factor of the rail pads."""
    contact_width: Number = Field(alias="contact_width_m", ge=0.1, le=100.0)
    """Width 2b over which the track presses on the ground, m."""
    coupling: Annotated[Coupling | None, AfterValidator(_none_if_centre)] = None
    """``"mean"``: the track follows the ground's mean displacement over the contact width; ``"centre"`` or
    None: that of the centre line, as in the paper. None is also what ``"centre"`` becomes.
    """
    layers: tuple[TrackLayer, ...] = Field(default=(), max_length=20)
    """From the sleepers or the slab down: ballast, sub-ballast, embankment."""
    sleeper_mass: Number | None = Field(default=None, alias="sleeper_mass_kg_m", ge=0.0, le=1e5)
    """Ballasted track: mass of the sleepers per length, kg/m."""
    slab_bending_stiffness: Number | None = Field(
        default=None, alias="slab_bending_stiffness_n_m2", ge=1e4, le=1e13
    )
    """Slab track: bending stiffness of the slab along the track, N·m²."""
    slab_mass: Number | None = Field(default=None, alias="slab_mass_kg_m", ge=1.0, le=1e6)
    """Slab track: mass of the slab per length, kg/m."""
    slab_loss_factor: LossFactor | None = None
    """Slab track: loss factor of the slab's bending stiffness."""
    mat: TrackLayer | None = None
    """Slab track: resilient mat under the slab."""

    @model_validator(mode="after")
    def _fields_fit_form(self) -> Self:
        needed = {"ballasted": ("sleeper_mass",), "slab": ("slab_bending_stiffness", "slab_mass")}
        foreign = {
            "ballasted": ("slab_bending_stiffness", "slab_mass", "slab_loss_factor", "mat"),
            "slab": ("sleeper_mass",),
        }
        for name in needed[self.form]:
            if getattr(self, name) is None:
                raise InputError(
                    f".{type(self).model_fields[name].alias}: is missing; a {self.form} track needs it"
                )
        for name in foreign[self.form]:
            if getattr(self, name) is not None:
                alias = type(self).model_fields[name].alias or name
                raise InputError(f".{alias}: does not belong to a {self.form} track")
        if self.form == "ballasted" and not self.layers:
            raise InputError(".layers = []: a ballasted track needs at least the ballast")
        return self

    def unusual(self) -> Iterator[str]:
        """Yield what is rather that of one rail than of two."""
        if self.rail_bending_stiffness < STIFFEST_ONE_RAIL:
            yield (
                f"rail_bending_stiffness_n_m2 = {self.rail_bending_stiffness:g} N·m²: below "
                f"{STIFFEST_ONE_RAIL:g} N·m², as of one rail; give that of both together"
            )
        if self.rail_mass < HEAVIEST_ONE_RAIL:
            yield (
                f"rail_mass_kg_m = {self.rail_mass:g} kg/m: below {HEAVIEST_ONE_RAIL:g} kg/m, "
                "as of one rail; give that of both together"
            )

    @property
    def half_width(self) -> float:
        """Half the contact width b, m."""
        return 0.5 * self.contact_width

    @property
    def follows_mean(self) -> bool:
        """Whether the track follows the ground's mean displacement over the contact width."""
        return self.coupling == "mean"

    @property
    def bed(self) -> tuple[TrackLayer, ...]:
        """All layers between the sleepers or the slab and the ground, from the top down."""
        return (self.mat, *self.layers) if self.mat is not None else self.layers
