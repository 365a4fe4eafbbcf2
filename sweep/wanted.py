"""The units that a study wants: the spectra of its cases by its approaches."""

from railvib.numerics import third_octaves
from railvib.parameters.approach import Approach
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.units import KMH
from railvib.stages import case_spectra
from sweep.study import Case, Resolved
from sweep.unit import Unit, unit_of


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
