"""One run of the benchmark: its sections one after the other, and the document that it writes."""

import json
import os
import platform
import socket
import subprocess
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import railvib
from benchmarks.figures import Figure
from benchmarks.limit import rates
from benchmarks.limit.rates import Rates
from benchmarks.sections import extras, growth, kernel, paper, transfer
from benchmarks.sizes import Size
from railvib.numerics import threads
from sweep.host import host_class
from sweep.manifest import LIBRARIES
from sweep.storage.folder import Folder

SCHEMA = 1
_MEASURES: Mapping[str, Callable[[Size, Rates], Iterator[Figure]]] = {
    kernel.SECTION: kernel.measure,
    transfer.SECTION: transfer.measure,
    paper.SECTION: lambda size, rates: paper.measure(size),
    growth.SECTION: lambda size, rates: growth.measure(size),
    extras.SECTION: lambda size, rates: extras.measure(size),
}


def measure(
    size: Size, sections: Iterable[str], report: Callable[[Figure], None]
) -> tuple[dict[str, Any], list[Figure]]:
    """Measure sections in this process and its children; return the document and the figures in it.

    Parameters
    ----------
    size
        How much to measure.
    sections
        Names of sections.
    report
        Called with every figure as soon as it is known.
    """
    document = _head(size)
    figures: list[Figure] = []
    with threads.single():  # the rates are those of one core
        core = rates.measure()
        for name in sections:
            for figure in _MEASURES[name](size, core):
                figures.append(figure)
                report(figure)
    document |= {
        "rates": asdict(core),
        "finished": _now(),
        "load_after": os.getloadavg()[0],
        "figures": [figure.document() for figure in figures],
    }
    return document, figures


def write(document: Mapping[str, Any], directory: Path) -> Path:
    """Write a document to a directory, which is created if missing; return the file."""
    directory.mkdir(parents=True, exist_ok=True)
    name = f"benchmark-{document['started'][:19].replace(':', '')}.json"
    content = json.dumps(document, indent=1, ensure_ascii=False).encode() + b"\n"
    Folder(directory).replace(name, content)
    return directory / name


def _head(size: Size) -> dict[str, Any]:
    """Return the size, the machine and the versions measured."""
    return {
        "schema": SCHEMA,
        "size": size.name,
        "started": _now(),
        "host": socket.gethostname(),
        "host_class": host_class(),
        "processors": os.cpu_count(),
        "load_before": os.getloadavg()[0],
        "commit": _commit(),
        "model_version": railvib.MODEL_VERSION,
        "versions": {
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in LIBRARIES},
        },
    }


def _commit() -> str | None:
    """Return the git commit of the source, marked dirty if the source was changed; None outside git."""
    home = Path(railvib.__file__).parent
    command = ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12", "--match="]
    try:
        process = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return process.stdout.strip()


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
