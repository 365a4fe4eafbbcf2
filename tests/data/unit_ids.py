"""Writes unit_ids.json: the ids of all units of three studies, by kind, as they were at MODEL_VERSION 5.

Run from the top of the repository: ``python -m tests.data.unit_ids``.
"""

import json
from pathlib import Path

from sweep import identity, plan, study
from sweep.wanted import spectra_unit

STUDIES = Path(__file__).parents[2] / "studies"
FROZEN = Path(__file__).with_name("unit_ids.json")
MODEL_VERSION = "5"


def resolved_studies():
    """Return the studies by name: the paper's, the verification, and the paper's averaged over the train."""
    paper = study.read_toml(STUDIES / "paper.toml")
    averaged = {**paper, "approaches": {**paper["approaches"], "averaging": ["line", "train"]}}
    verification = study.read_toml(STUDIES / "verification.toml")
    documents = {"paper": paper, "verification": verification, "train-average": averaged}
    return {name: study.resolve(document) for name, document in documents.items()}


def unit_ids(resolved):
    """Return the ids of all units that a study needs, sorted, by kind."""
    wanted = [
        spectra_unit(resolved, case, approach)
        for case in resolved.cases()
        for approach in resolved.study.approaches.compare
    ]
    ids = {}
    for unit in plan.make(wanted, set()).units.values():
        inputs = {"kind": unit.stage_name, "model_version": MODEL_VERSION, "inputs": unit.inputs}
        ids.setdefault(unit.stage_name, []).append(identity.digest(inputs)[:16])
    return {kind: sorted(found) for kind, found in sorted(ids.items())}


if __name__ == "__main__":
    ids = {name: unit_ids(resolved) for name, resolved in resolved_studies().items()}
    FROZEN.write_text(json.dumps(ids, indent=1) + "\n", encoding="utf-8")
