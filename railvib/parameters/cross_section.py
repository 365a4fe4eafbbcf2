"""Cross-section of the track in the FE/BE model: what the paper's numbers per metre of track leave open.

The semi-analytical model knows a ballast by its stiffness k_B and mass m_B per length and its width 2b. A
solid of height h under uniform vertical strain has the same stiffness and mass if its constrained modulus is
k_B h/(2b) and its density m_B/(2b h). Height and Poisson's ratio remain to be chosen; they are not fitted.
"""

from typing import Literal, Self

from pydantic import Field, model_validator

from railvib.errors import InputError
from railvib.parameters.track import Track, TrackLayer
from railvib.parameters.validation import Integer, Number, Parameters


class CrossSection(Parameters):
    """How the track's cross-section and its contact with the ground are modelled.

    The defaults are the verification model. The other choices take it back, step by step, to the
    semi-analytical one, to see what each step does: ``columns`` of lumped springs that know nothing of their
    neighbours in place of a solid, ``smooth`` contact without horizontal stresses, one element, and the
    ``centre`` of the contact for its displacement.

    Raises
    ------
    InputError
        If a value is out of range, columns are to carry horizontal stresses, or a displacement at the centre
        is asked for with more than one element.
    """

    layer_height: Number = Field(default=0.35, alias="layer_height_m", ge=0.01, le=10.0)
    """Height of every layer between the sleepers or the slab and the ground, m."""
    poisson_ratio: Number = Field(default=0.2, ge=0.0, lt=0.5)
    """Poisson's ratio of these layers."""
    elements: Integer = Field(default=8, ge=1, le=64)
    """Boundary elements from the centre line to the edge, each under one column of finite elements."""
    rows: Integer = Field(default=3, ge=1, le=64)
    """Rows of finite elements in a layer."""
    bed: Literal["solid", "columns"] = "solid"
    """Viscoelastic solids, or independent columns of lumped springs with consistent mass."""
    contact: Literal["bonded", "smooth"] = "bonded"
    """Whether bed and ground exchange horizontal stresses."""
    displacement: Literal["average", "centre"] = "average"
    """What of the ground's displacement follows the track: averages over the elements, or the centre's."""

    @model_validator(mode="after")
    def _choices_fit(self) -> Self:
        if self.bed == "columns" and self.contact == "bonded":
            raise InputError('.contact = "bonded": columns carry no horizontal stress, so must be "smooth"')
        if self.displacement == "centre" and (self.bed, self.elements) != ("columns", 1):
            raise InputError('.displacement = "centre": needs bed = "columns" and elements = 1')
        return self

    def constrained_modulus(self, track: Track, layer: TrackLayer) -> float:
        """Return k_B h/(2b) of a layer, Pa."""
        return layer.stiffness * self.layer_height / track.contact_width

    def density(self, track: Track, layer: TrackLayer) -> float:
        """Return m_B/(2b h) of a layer, kg/m³."""
        return layer.mass / (track.contact_width * self.layer_height)
