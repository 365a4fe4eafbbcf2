"""A study, its cases and the plan of what it needs, checked against a directory before anything runs."""

import os
from collections.abc import Mapping, Set
from dataclasses import dataclass, replace
from pathlib import Path

from railvib.errors import InputError
from sweep import plan
from sweep.running.lock import LOCK
from sweep.storage import location, records
from sweep.study import Case, Resolved
from sweep.unit import Unit
from sweep.wanted import wanted_units

MOST_CASES = 200_000
"""Largest number of cases of a study; each takes some 54 kB of the driver's memory."""


@dataclass(frozen=True)
class Request:
    """A study with its cases and the plan of what it needs.

    Attributes
    ----------
    wanted
        Per case and approach, the units that hold its results, the spectra first.
    store
        Where results lie that cases share, if not with the run.
    """

    resolved: Resolved
    cases: tuple[Case, ...]
    wanted: Mapping[tuple[str, str], tuple[Unit, ...]]
    plan: plan.Plan
    store: str | None = None

    def resting_on(self, identities: Set[str]) -> "Request":
        """Return the request restricted to results that rest on one of these units."""
        return replace(self, plan=self.plan.resting_on(identities))


def prepare(resolved: Resolved, directory: Path, store: str | None = None, complete: bool = False) -> Request:
    """Plan a study against the results in a directory and in a shared store; writes nothing.

    Parameters
    ----------
    resolved
        The study.
    directory
        Its run directory, which may not exist yet.
    store
        Path or address of the store outside; without one, that of the directory's latest run.
    complete
        Also plan missing units that only finished results rest on.

    Raises
    ------
    InputError
        If the directory belongs to another study, or to something else, or the store cannot be used.
    """
    check_directory(directory, resolved.study.study.name)
    check_number(resolved)
    store = location.address(store) if store else next(map(str, records.homes(directory)[1:]), None)
    present = records.ids_at(directory)
    if store:
        location.at(store).check()
        present |= records.ids_at(store)
    cases = tuple(resolved.cases())
    wanted: dict[tuple[str, str], tuple[Unit, ...]] = {
        (case.case_id, approach): wanted_units(resolved, case, approach)
        for case in cases
        for approach in resolved.study.approaches.compare
    }
    missing = plan.make((unit for units in wanted.values() for unit in units), present, complete)
    return Request(resolved, cases, wanted, missing, store)


def check_number(resolved: Resolved) -> None:
    """Check that the driver has memory to plan all cases of a study.

    Raises
    ------
    InputError
        Naming the longest axis.
    """
    axes = {name: getattr(resolved.study.sweep, name) for name in type(resolved.study.sweep).model_fields}
    number = resolved.study.sweep.combinations
    if number > MOST_CASES:
        longest = max(axes, key=lambda name: len(axes[name]))
        raise InputError(
            f"sweep.{longest}: {len(axes[longest])} values make {number} cases; must be at most {MOST_CASES}:"
            " split this axis over studies that share a --store"
        )


UNREADABLE = frozenset("?\\\N{REPLACEMENT CHARACTER}")
"""Characters that no folder above a database may have; the last one stands for bytes that are no text."""


def check_directory(directory: Path, name: str) -> None:
    """Check that a directory is new, empty or holds earlier runs of this study.

    A directory of results whose manifests are gone or damaged may go on with any: ids say what is there.

    Raises
    ------
    InputError
        If it does not.
    """
    place = os.fsencode(directory.resolve()).decode(errors="replace")
    if not UNREADABLE.isdisjoint(place):
        raise InputError(
            f"--out = {place!r}: must be in UTF-8 and without ? and \\, "
            "which DuckDB does not read as names of files"
        )
    if not directory.exists() or (
        directory.is_dir() and {path.name for path in directory.iterdir()} <= {LOCK}
    ):
        return
    try:
        other = records.Run.load(directory)["study_name"]
    except (OSError, ValueError, KeyError):
        if (directory / records.RECORDS).is_dir():
            return
        raise InputError(
            f"--out = {str(directory)!r}: holds something else; must be new, empty or of the study {name!r}"
        ) from None
    if other != name:
        raise InputError(
            f"--out = {str(directory)!r}: is of the study {other!r}; must be new, empty or of {name!r}"
        )
