"""The units that a study wants: spectra of its cases by its approaches, and levels of their passages."""

from typing import Any

from railvib.numerics import third_octaves
from railvib.parameters.approach import Approach
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.units import KMH
from railvib.stages import case_spectra
from railvib.stages.passage_levels import PassageLevelsOfCase
from sweep.study import Case, Resolved
from sweep.unit import Unit, unit_of


def wanted_units(resolved: Resolved, case: Case, approach: Approach) -> tuple[Unit, ...]:
    """Return the units that a study wants of one case by one approach: spectra first, then levels if any."""
    spectra = spectra_unit(resolved, case, approach)
    levels = resolved.study.levels
    if levels is None:
        return (spectra,)
    stage = spectra.stage
    fields = ("ground", "track", "train", "unevenness", "speed", "band", "receivers", "tolerance")
    shared: dict[str, Any] = {name: getattr(stage, name) for name in (*fields, "cross_section", "refinement")}
    return spectra, unit_of(PassageLevelsOfCase(approach=approach, **shared, **dict(levels)))


def spectra_unit(resolved: Resolved, case: Case, approach: Approach) -> Unit:
    """Return the unit of the spectra of one case by one approach."""
    study = resolved.study
    offsets = sorted(set(study.receivers.offsets_m))
    stage = case_spectra(
        approach,
        ground=resolved.objects["soil"][case.soil],
        track=resolved.objects["track"][case.track],
        train=resolved.objects["train"][case.train],
        unevenness=resolved.objects["unevenness"][case.unevenness],
        speed=case.speed_kmh / KMH,
        band=tuple(third_octaves.midbands(study.frequency.minimum_hz, study.frequency.maximum_hz).tolist()),
        receivers=(*([RAIL] if study.receivers.rail else []), *map(Receiver, offsets)),
        averaging=tuple(sorted(set(study.approaches.averaging))),
        tolerance=study.accuracy.tolerance,
        cross_section=study.cross_section,
    )
    return unit_of(stage)
