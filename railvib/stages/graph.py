"""The graph of stages: the registry, the stages that a case wants, and evaluation in memory.

`railvib.predict` evaluates the graph here; a sweep plans, runs and stores the same one.
"""

from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

from railvib.errors import InputError
from railvib.parameters.approach import Approach
from railvib.parameters.cross_section import CrossSection
from railvib.stages.case_spectra import CaseSpectra
from railvib.stages.fe_be_table import FeBeTable
from railvib.stages.full_model import FullModelSpectra
from railvib.stages.line_integrals import ReceiverLineIntegrals
from railvib.stages.moving_roughness import MovingRoughnessSpectra
from railvib.stages.moving_transfer import RailMovingTransfer
from railvib.stages.passage_levels import PassageLevelsOfCase
from railvib.stages.quasi_static import QuasiStaticResponse
from railvib.stages.receptances import RailReceptances
from railvib.stages.stage import Stage
from railvib.stages.train_integrals import ReceiverTrainIntegrals
from railvib.stages.transfer_table import TransferTable

STAGES: dict[str, type[Stage]] = {
    stage.__name__: stage
    for stage in (
        FeBeTable,  # before the stage that it refines, see `stage_of`
        TransferTable,
        RailReceptances,
        RailMovingTransfer,
        ReceiverLineIntegrals,
        QuasiStaticResponse,
        ReceiverTrainIntegrals,
        MovingRoughnessSpectra,
        FullModelSpectra,
        PassageLevelsOfCase,
    )
}
"""Every stage by name; what is not here is neither predicted nor run."""


def case_spectra(approach: Approach, *, cross_section: CrossSection, **inputs: Any) -> CaseSpectra:
    """Return the stage of the spectra of a case by an approach.

    Parameters
    ----------
    approach
        The approach.
    cross_section
        Cross-section of the track, which only the FE/BE model takes.
    **inputs
        The other fields of `CaseSpectra`.
    """
    match approach:
        case "full":
            # It has the whole passage: only moving roughness can be averaged over the train as well.
            return FullModelSpectra(approach=approach, **{**inputs, "averaging": ("line",)})
        case "fe-be":
            return MovingRoughnessSpectra(approach=approach, cross_section=cross_section, **inputs)
        case _:
            return MovingRoughnessSpectra(approach=approach, **inputs)


def stage_of(name: str, inputs: Mapping[str, Any]) -> Stage:
    """Return the stage of a stored result, from its name and its inputs in plain form.

    Raises
    ------
    InputError
        If there is no stage of that name with such inputs.
    """
    for stage in STAGES.values():  # the first that takes them
        if stage.name != name:
            continue
        try:
            return stage.from_inputs(inputs)
        except ValueError:  # another stage of that name may take them
            continue
    raise InputError(f"{name}: no stage takes the inputs {', '.join(sorted(inputs))}")


def groups(stages: Iterable[Stage]) -> list[list[Stage]]:
    """Return stages in the groups in which they are computed together."""
    members: dict[Hashable, list[Stage]] = {}
    for stage in stages:
        members.setdefault((type(stage), stage.together()), []).append(stage)
    return list(members.values())


def evaluate(wanted: Sequence[Stage]) -> dict[Stage, Any]:
    """Compute stages and all that they need, in memory.

    Parameters
    ----------
    wanted
        The stages.

    Returns
    -------
    dict
        The result of every stage that was computed.

    Raises
    ------
    KeyError
        If a stage is not in the registry.
    """
    results: dict[Stage, Any] = {}
    ranks: dict[Stage, int] = {}

    def rank(stage: Stage) -> int:
        if stage not in ranks:
            ranks[stage] = 1 + max((rank(need) for need in stage.needs()), default=-1)
        return ranks[stage]

    for stage in wanted:
        rank(stage)
    for level in range(max(ranks.values(), default=-1) + 1):
        for group in groups(stage for stage in ranks if ranks[stage] == level):
            stage_class = STAGES[type(group[0]).__name__]
            for batch in stage_class.compute_together(group, results.__getitem__):
                results.update(batch)
    return results
