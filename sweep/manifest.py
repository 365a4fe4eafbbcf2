"""The manifest of a run: what was asked, by whom and with what, what was planned, and how it went."""

import json
import os
import platform
import secrets
import socket
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import railvib
from sweep import description
from sweep.host import host_class
from sweep.request import Request
from sweep.storage import records
from sweep.study import Case

if TYPE_CHECKING:
    from sweep.running.scheduler import Tally

LIBRARIES = (
    "railvib",
    "numpy",
    "scipy",
    "numba",
    "zarr",
    "dask",
    "distributed",
    "pydantic",
    "xarray",
    "duckdb",
)
DONE, FAILED = 0, 1
"""Exit statuses; one of a run that was interrupted is that of `railvib.signals`."""


def begin(request: Request, threads: int, planned: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the manifest of a run that begins, under a new id."""
    resolved = request.resolved
    return {
        "schema": records.SCHEMA,
        "run_id": f"{datetime.now(UTC):%Y%m%dT%H%M%S}-{secrets.token_hex(4)}",
        "study_name": resolved.study.study.name,
        "study": resolved.document(),
        "store": request.store,
        "reference": resolved.study.approaches.reference,
        "versions": {
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in LIBRARIES},
        },
        "model_version": railvib.MODEL_VERSION,
        "host": socket.gethostname(),
        "host_class": host_class(),
        "threads": threads,
        "pid": os.getpid(),
        "started": _now(),
        "finished": None,
        "exit_status": None,
        "parameters": resolved.parameters(),
        "unevenness_bands": description.unevenness_bands(resolved),
        "rayleigh_speeds_m_s": description.rayleigh_speeds(resolved),
        "axles": description.axles(resolved),
        "cases": [_case(case, request) for case in request.cases],
        "planned": planned,
        "measured": None,
    }


def end(
    manifest: Mapping[str, Any], status: int, tallies: Sequence["Tally"], wall_s: float
) -> dict[str, Any]:
    """Return the manifest of a run that has ended, from the tally of each plan that it ran."""
    measured = {
        "tasks": sum(tally.done + tally.failed for tally in tallies),
        "task_starts": sum(tally.starts for tally in tallies),
        "bytes": sum(tally.bytes_written for tally in tallies),
        "peak_memory_bytes": max((tally.peak_rss_bytes for tally in tallies), default=0),
        "cpu_s": sum(tally.cpu_s for tally in tallies),
        "wall_s": wall_s,
    }
    return {**manifest, "finished": _now(), "exit_status": status, "measured": measured}


def stands_already(manifest: Mapping[str, Any], directory: Path) -> bool:
    """Return whether the latest run of a directory completed the same request."""
    try:
        latest = records.Run.load(directory)
    except FileNotFoundError:
        return False
    asked = ("study", "cases", "model_version", "parameters", "store")
    return latest["exit_status"] == DONE and all(
        latest.get(name) == json.loads(json.dumps(manifest[name])) for name in asked
    )


def _case(case: Case, request: Request) -> dict[str, Any]:
    approaches = {}
    for approach in request.resolved.study.approaches.compare:
        closures = (request.plan.closure[unit.id] for unit in request.wanted[case.case_id, approach])
        rests_on = dict.fromkeys(identity for closure in closures for identity in closure)
        approaches[approach] = [
            {"unit_id": unit.id, "scope": unit.scope}
            for unit in (request.plan.units[identity] for identity in rests_on)
        ]
    return {
        "case_id": case.case_id,
        "soil": case.soil,
        "track": case.track,
        "train": case.train,
        "unevenness": case.unevenness,
        "speed_kmh": case.speed_kmh,
        "labels": [label._asdict() for label in case.labels],
        "units": approaches,
    }


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
