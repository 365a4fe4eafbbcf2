"""The form of manifests and records; a file of another form counts as damaged."""

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

Form = Callable[[Mapping[str, Any]], bool]


def is_manifest(content: Mapping[str, Any]) -> bool:
    """Return whether a manifest has all entries that are read without further checks."""
    return (
        _has(content, run_id=str, study_name=str, study=dict, cases=list, host=str, started=str)
        and _has(content, finished=str | None, exit_status=int | None)
        and all(_is_moment(content[name]) for name in ("started", "finished"))
        and all(map(_is_case, content["cases"]))
    )


def is_record(content: Mapping[str, Any]) -> bool:
    """Return whether a commit record has all entries that are read without further checks."""
    return (
        _has(content, kind=str, unit_id=str, group=str, arrays=dict, inputs=dict, costs=list)
        and ".." not in content["group"].split("/")
        and all(_has(array, sha256=str, shape=list, dtype=str) for array in content["arrays"].values())
        and all(isinstance(cost, dict) for cost in content["costs"])
    )


def is_failure(content: Mapping[str, Any]) -> bool:
    """Return whether the record of a failure has all entries that are read without further checks."""
    return _has(content, kind=str, unit_id=str, traceback=str)


def _has(content: Any, **types: Any) -> bool:
    return isinstance(content, dict) and all(
        name in content and isinstance(content[name], kind) for name, kind in types.items()
    )


def _is_case(case: Any) -> bool:
    return _has(case, case_id=str, units=dict) and all(
        isinstance(units, list) and all(_has(unit, unit_id=str) for unit in units)
        for units in case["units"].values()
    )


def _is_moment(text: str | None) -> bool:
    """Return whether a text is a date and time with a zone; None is a time to come."""
    try:
        return text is None or datetime.fromisoformat(text).tzinfo is not None
    except ValueError:
        return False
