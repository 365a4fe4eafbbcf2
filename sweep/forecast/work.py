"""How much work a task is, as amounts that processor time grows with: what the pilot measures rates of.

Amounts follow from a unit's inputs alone. They need not be exact: the same formulas count the pilot's own
tasks, so that a constant error in a formula is in the rate as well, and goes.
"""

import math
from collections.abc import Mapping, Sequence

from railvib.numerics import frequency_blocks as blocks
from railvib.transfer.tabulate import MOST_LEVELS, distance_class
from sweep import units
from sweep.kinds import Inputs, Unit

Amounts = Mapping[str, float]

STAGES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "transfer": {"fit": ("fits", "fits of layers"), "transfer functions": ("values", "values of layers")},
    "moving roughness": {"line average": ("pairs of receivers",)},
    "full": {"passage": ("turned", "values")},
}
"""By sort of task, the stages whose time follows from some of its amounts alone; all else from the others."""

FE_BE = "fe-be transfer"
"""The sort of tasks that tabulate the FE/BE model."""
CHECKS = 5
"""Places between the frequencies of each level at which a table is checked."""
RESOLVING = 9
"""Rows of nodes that finding the panels takes, about: three frequencies, halved some times."""


def amounts(task: Sequence[Unit]) -> tuple[str, Amounts]:
    """Return the sort of a task, within which rates are the same, and its amounts of work."""
    first = task[0]
    if first.kind == "transfer" and "cross_section" in first.inputs:
        return FE_BE, _fe_be([unit.inputs for unit in task])
    if first.kind == "transfer":
        return "transfer", _transfer([unit.inputs for unit in task])
    if first.kind == "receptance":
        sort = "moving receptance" if first.inputs["speed"] else "standing receptance"
        return sort, _sum([_receptance(unit.inputs) for unit in task])
    if first.kind == "line_integrals":
        return first.kind, _sum([_line_integrals(unit.inputs) for unit in task])
    if first.kind == "train_integrals":
        return first.kind, _sum([_train_integrals(unit.inputs) for unit in task])
    if first.kind == "spectra" and first.inputs["approach"] == "full":
        return "full", _sum([_full(unit.inputs) for unit in task])
    if first.kind == "spectra":
        return "moving roughness", _sum([_moving_roughness(unit.inputs) for unit in task])
    return first.kind, {"units": float(len(task))}


def _sum(parts: Sequence[Amounts]) -> Amounts:
    return {name: sum(part[name] for part in parts) for name in parts[0]}


def table_size(inputs: Inputs, resolved: float = 4.0) -> tuple[int, float]:
    """Return how many frequencies and nodes a table of a transfer function is expected to have.

    `resolved` is the number of waves up to the receiver that the coarsest level still follows.
    """
    waves = units.waves_between(inputs)
    level = min(max(math.ceil(math.log2(max(waves, 1.0) / resolved)), 0), MOST_LEVELS)
    return blocks.indices(int(inputs["block"]), level).size, 400.0 + 10.0 * waves


def _transfer(receivers: Sequence[Inputs]) -> Amounts:
    """Return fits, shared by the receivers of a task, and values of the receivers' functions."""
    layers = receivers[0]["ground"]["layers"]
    sizes = [table_size(inputs) for inputs in receivers]
    fits = 1.0 if len(layers) == 1 else max(rows for rows, _ in sizes) + CHECKS
    return {
        "tasks": 1.0,
        "fits": fits,
        "fits of layers": fits * len(layers),
        "receivers": float(len(receivers)),
        "values": sum(rows * nodes for rows, nodes in sizes),
        "values of layers": sum(rows * nodes for rows, nodes in sizes) * len(layers),
    }


def _fe_be(receivers: Sequence[Inputs]) -> Amounts:
    """Return the places at which the FE/BE model is evaluated, shared by the receivers of a class."""
    classes: dict[float, float] = {}
    for inputs in receivers:
        rows, nodes = table_size(inputs, 8.0)  # no rate makes up for an estimate on the safe side here
        reach = distance_class(inputs["receiver"])
        classes[reach] = max(classes.get(reach, 0.0), (rows + CHECKS + RESOLVING) * nodes)
    return {"values": sum(classes.values())}


def _receptance(inputs: Inputs) -> Amounts:
    which = float(len(inputs["blocks"]))
    return {"blocks": which, "distances": which * len(inputs["distances"])}


def _table_nodes(inputs: Inputs, receivers: Sequence[str | float]) -> float:
    """Return how many nodes the tables of some receivers have together, in the highest block of a band."""
    block = max(units.covering(inputs["band"]))
    asked = ({"ground": inputs["ground"], "block": block, "receiver": each} for each in receivers)
    return sum(table_size(each)[1] for each in asked)


def _line_integrals(inputs: Inputs) -> Amounts:
    sizes = [table_size({**inputs, "block": block}) for block in inputs["blocks"]]
    values = sum(rows * nodes for rows, nodes in sizes)
    return {"units": 1.0, "values": values, "values of axles": values * len(inputs["distances"])}


def _train_integrals(inputs: Inputs) -> Amounts:
    values = float(units.narrow_lines(inputs).size) * _table_nodes(inputs, [inputs["receiver"]])
    return {"units": 1.0, "values": values, "values of axles": values * len(inputs["axle_position"]) ** 2}


def _moving_roughness(inputs: Inputs) -> Amounts:
    axles = len(units.train_axles(inputs["train"]).position)
    lines, receivers = float(units.line_count(inputs)), len(inputs["receivers"])
    return {
        "units": 1.0,
        "pairs": lines * axles**2,
        "matrices": lines * axles**3,
        "pairs of receivers": lines * axles**2 * receivers * len(inputs["averaging"]),
    }


def _full(inputs: Inputs) -> Amounts:
    axles = len(units.train_axles(inputs["train"]).position)
    lines, excitations = float(units.line_count(inputs)), float(units.excitation_count(inputs))
    values = lines * _table_nodes(inputs, inputs["receivers"])
    return {
        "units": 1.0,
        "pairs": excitations * axles**2,
        "matrices": excitations * axles**3,
        "turned": lines * excitations * axles,
        "values": values,
    }
