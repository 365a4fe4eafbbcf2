"""What the manifests of all runs of a directory say, as rows of tables; no array is read here."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from queries.database import parameters

Row = Mapping[str, Any]


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

    def key(self, unit: str) -> str:
        """Return what the rows of a unit's arrays depend on besides the unit: a change makes them stale."""
        pairs = sorted(self.owners[unit])
        cases = {row["case_id"]: row for row in self.tables["cases"]}
        named = sorted({(cases[case]["soil_id"], cases[case]["track_id"]) for case, _ in pairs}, key=str)
        return hashlib.sha256(
            json.dumps([pairs, named, self.narrow_band], sort_keys=True).encode()
        ).hexdigest()


def contents(manifests: list[dict[str, Any]]) -> Contents:
    """Return what the manifests say, the earliest first; the newest names a case."""
    tables: dict[str, list[Row]] = {
        "runs": [_run(manifest) for manifest in manifests],
        "run_cases": [],
        "case_units": [],
    }
    cases: dict[str, Row] = {}
    bands: dict[tuple[str, float], Row] = {}
    named: dict[str, dict[tuple[Any, ...], parameters.Row]] = {table: {} for table in parameters.TABLES}
    owners: dict[str, set[tuple[str, str]]] = {}
    for manifest in manifests:
        run_id, given = manifest["run_id"], manifest.get("parameters", {})
        for table, rows in parameters.rows(given, manifest.get("rayleigh_speeds_m_s", {})).items():
            named[table].update({tuple(row[name] for name in parameters.TABLES[table]): row for row in rows})
        ids = {
            kind: {name: parameters.identity(name, thing) for name, thing in given.get(kind, {}).items()}
            for kind in parameters.KINDS
        }
        for name, rows in manifest.get("unevenness_bands", {}).items():
            key = ids["unevenness"].get(name, name)
            for row in rows:
                bands[key, row["wavelength_m"]] = {**row, "unevenness": name, "unevenness_id": key}
        for case in manifest["cases"]:
            case_id = case["case_id"]
            names = {column: case[column] for column in (*parameters.KINDS, "case_id", "speed_kmh")}
            cases[case_id] = {
                **names,
                **{f"{kind}_id": ids[kind].get(case[kind]) for kind in parameters.KINDS},
            }
            tables["run_cases"].append({"run_id": run_id, "case_id": case_id})
            for approach, units in case["units"].items():
                for unit in units:
                    row = {"run_id": run_id, "case_id": case_id, "approach": approach}
                    tables["case_units"].append({**row, "unit_id": unit["unit_id"], "scope": unit["scope"]})
                    owners.setdefault(unit["unit_id"], set()).add((case_id, approach))
    tables |= {"cases": list(cases.values()), "unevenness_bands": list(bands.values())}
    tables |= {table: list(rows.values()) for table, rows in named.items()}
    return Contents(tables, owners, _narrow_band(manifests[-1]))


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


def _run(manifest: Row) -> Row:
    counted = {
        f"{when}_{name}": value
        for when in ("planned", "measured")
        for name, value in (manifest.get(when) or {}).items()
    }
    return {
        **manifest,
        **counted,
        "study": manifest.get("study_name"),
        "versions": json.dumps(manifest.get("versions"), sort_keys=True),
        "resolved_study": json.dumps(manifest.get("study"), sort_keys=True),
        "started": utc(manifest.get("started")),
        "finished": utc(manifest.get("finished")),
    }


def _narrow_band(manifest: Row) -> Any:
    output = manifest.get("study", {}).get("output") or {}
    return output.get("narrow_band", "all")
