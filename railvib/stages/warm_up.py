"""Compiling the kernels before they are needed, by computing a small case."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from railvib import library
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.track import Track
from railvib.parameters.vehicle import Train
from railvib.stages.graph import case_spectra, evaluate
from railvib.stages.transfer_table import TransferTable


@cache
def warm_up() -> None:
    """Compile the kernels of the common stages, or load them where that has been done."""
    from railvib.soil.rational_fit import fit_flexibility
    from railvib.transfer.compliance_under_track import compliance_under_track
    from railvib.transfer.intensity import squares
    from railvib.transfer.transfer_function import TransferFunction

    case: dict[str, Any] = {
        "ground": library.load("soil", "horstwalde"),
        "track": library.load("track", "ballasted-paper"),
        "train": Train(vehicles=(library.load("vehicle", "regina"),)),
        "unevenness": library.load("unevenness", "german-low"),
        "speed": 1.0,
        "band": (0.1,),
        "receivers": (RAIL, Receiver(8.0)),
        "averaging": ("line",),
        "tolerance": 1e-2,
        "cross_section": CrossSection(),
    }
    results = evaluate([case_spectra(approach, **case) for approach in ("moving-roughness", "full")])
    # |H|² of tables that need more frequencies than they have, as these do not.
    for stage, table in results.items():
        if isinstance(stage, TransferTable):
            finer = replace(table, square_level=table.level + 1)
            squares(TransferFunction([finer], stage.track), finer.block)
    fit = fit_flexibility(case["ground"], 1.0, 1e-4)
    following = Track(**{**case["track"].model_dump(), "coupling": "mean"})
    compliance_under_track(fit, np.zeros(1), following)
