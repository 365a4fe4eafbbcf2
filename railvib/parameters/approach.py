"""The names of the ways from a case to its spectra, and of what moving roughness is averaged over."""

from typing import Literal, get_args

Approach = Literal[
    "moving-roughness", "moving-roughness-by-axle", "moving-roughness-uncorrelated", "full", "fe-be"
]
APPROACHES: tuple[Approach, ...] = get_args(Approach)

Averaging = Literal["line", "train"]
"""The whole line, as a full pass-by sees it, or the length of the train (Eq. 26)."""
