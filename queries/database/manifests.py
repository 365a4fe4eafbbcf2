"""The manifests of all runs of a directory as rows of tables; no array is read here."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from typing import Any

from queries.database import definitions
from queries.database.definitions import KINDS

Row = Mapping[str, Any]
Manifest = Mapping[str, Any]

LABEL = ("case_id", *KINDS)
"""Key columns of cases, which have a row for every label."""


@dataclass(frozen=True)
class Contents:
    """The manifests of all runs together.

    Attributes
    ----------
    tables
        Rows per table.
    owners
        The pairs of case and approach that each unit serves.
    narrow_band
        Which narrow-band lines the newest study wants in the database.
    """

    tables: dict[str, list[Row]]
    owners: dict[str, set[tuple[str, str]]]
    narrow_band: Any

    @cached_property
    def _labels(self) -> dict[str, list[Row]]:
        labels: dict[str, list[Row]] = {}
        for row in self.tables["cases"]:
            labels.setdefault(row["case_id"], []).append(row)
        return labels

    def label_values(self, unit: str, columns: Sequence[str]) -> list[tuple[Any, ...]]:
        """Return some columns of the labels of all cases that a unit serves, each combination once."""
        cases = {case for case, _ in self.owners[unit]}
        rows = (row for case in cases for row in self._labels[case])
        return sorted({tuple(row[column] for column in columns) for row in rows}, key=str)

    def key(self, unit: str) -> str:
        """Return a digest of all else that rows of a unit's arrays depend on: a change makes them stale."""
        named = self.label_values(unit, ("soil_id", "track_id"))
        text = json.dumps([sorted(self.owners[unit]), named, self.narrow_band], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def contents(manifests: Sequence[Manifest]) -> Contents:
    """Return the content of manifests, which come earliest first."""
    tables: dict[str, list[Row]] = {
        "runs": [_run(manifest) for manifest in manifests],
        "run_cases": [],
        "case_units": [],
    }
    cases: dict[tuple[Any, ...], Row] = {}
    bands: dict[tuple[str, float], Row] = {}
    defined: dict[str, dict[tuple[Any, ...], Row]] = {table: {} for table in definitions.TABLES}
    owners: dict[str, set[tuple[str, str]]] = {}
    for manifest in manifests:
        for table, rows in definitions.rows(manifest).items():
            key = definitions.TABLES[table]
            defined[table].update({tuple(row[column] for column in key): row for row in rows})
        ids = definitions.identities(manifest)
        for name, rows in manifest.get("unevenness_bands", {}).items():
            unevenness_id = ids["unevenness"].get(name, name)
            for row in rows:
                place = unevenness_id, row["wavelength_m"]
                bands[place] = {**row, "unevenness": name, "unevenness_id": unevenness_id}
        run_id = manifest["run_id"]
        for case in manifest["cases"]:
            case_id = case["case_id"]
            for label in _labels(case):
                row = {"case_id": case_id, **label}
                row |= {f"{kind}_id": ids[kind].get(label[kind]) for kind in KINDS}
                cases[tuple(row[column] for column in LABEL)] = row
            tables["run_cases"].append({"run_id": run_id, "case_id": case_id})
            for approach, units in case["units"].items():
                of_case = {"run_id": run_id, "case_id": case_id, "approach": approach}
                for unit in units:
                    unit_row = {"unit_id": unit["unit_id"], "scope": unit["scope"]}
                    tables["case_units"].append({**of_case, **unit_row})
                    owners.setdefault(unit["unit_id"], set()).add((case_id, approach))
    tables |= {"cases": list(cases.values()), "unevenness_bands": list(bands.values())}
    tables |= {table: list(rows.values()) for table, rows in defined.items()}
    return Contents(tables, owners, _narrow_band(manifests[-1]))


def _labels(case: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the labels of a case: its names and speed."""
    for label in case.get("labels", [case]):  # in older manifests the case itself holds its one label
        yield {name: label[name] for name in (*KINDS, "speed_kmh")}


def utc(moment: Any) -> str | None:
    """Return a moment, ISO text or seconds since 1970, as the text of a TIMESTAMP in UTC."""
    if moment is None or moment == "":
        return None
    if isinstance(moment, int | float):
        when = datetime.fromtimestamp(moment, UTC)
    else:
        when = datetime.fromisoformat(moment)
        when = when.astimezone(UTC) if when.tzinfo else when
    return when.replace(tzinfo=None).isoformat()


def _run(manifest: Manifest) -> Row:
    amounts = {
        f"{when}_{name}": value
        for when in ("planned", "measured")
        for name, value in (manifest.get(when) or {}).items()
    }
    return {
        **manifest,
        **amounts,
        "study": manifest.get("study_name"),
        "versions": json.dumps(manifest.get("versions"), sort_keys=True),
        "resolved_study": json.dumps(manifest.get("study"), sort_keys=True),
        "started": utc(manifest.get("started")),
        "finished": utc(manifest.get("finished")),
    }


def _narrow_band(manifest: Manifest) -> Any:
    output = manifest.get("study", {}).get("output") or {}
    return output.get("narrow_band", "all")
