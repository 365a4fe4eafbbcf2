"""report.html: summary, tables, figures and provenance of a run in one file, readable without a network."""

import html
import json
import os
import re
from pathlib import Path

import duckdb

from queries import database, summary
from queries.table import Table, number

_STYLE = """
:root { color-scheme: light }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
  max-width: 62rem; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.7rem; margin-bottom: 0 } h2 { font-size: 1.25rem; margin-top: 2.2rem }
table { border-collapse: collapse; font-size: 0.875rem; margin: 1rem 0 0.3rem;
  font-variant-numeric: tabular-nums }
caption { text-align: left; font-weight: 600; padding: 0.3rem 0 }
th, td { padding: 0.25rem 0.7rem; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top }
th { border-bottom: 2px solid #888 } td.number { text-align: right }
figure { margin: 1.5rem 0; break-inside: avoid } figure img { width: 100%; height: auto }
figcaption { font-size: 0.875rem; color: #444 }
.note { font-size: 0.8125rem; color: #555; margin-top: 0 } .scroll { overflow-x: auto }
@media print { body { margin: 0; max-width: none; font-size: 11pt } }
"""


def write(connection: duckdb.DuckDBPyConnection, path: Path) -> Path:
    """Write the report of results and return its path; every number comes from the database."""
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    partial.write_text(_page(connection), encoding="utf-8")
    partial.replace(path)
    return path


def shown(path: Path) -> tuple[str, ...]:
    """Return the digests of the snapshot that a report shows, see `database.snapshot`; () for no report."""
    try:
        with path.open(encoding="utf-8") as file:
            head = file.read(1000)
    except OSError:
        return ()
    found = re.search('name="railvib-snapshot" content="([0-9a-f]+) ([0-9a-f]+)"', head)
    return found.groups() if found else ()


def _page(connection: duckdb.DuckDBPyConnection) -> str:
    row = connection.execute("SELECT study FROM runs ORDER BY sequence DESC LIMIT 1").fetchone()
    study = html.escape(str(row[0] if row else ""))
    snapshot = " ".join(database.snapshot(connection))
    sentences = "".join(f"<p>{html.escape(sentence)}</p>\n" for sentence in summary.summary(connection))
    tables = "".join(f"<div class='scroll'>{table.html()}</div>\n" for table in summary.tables(connection))
    provenance = "".join(f"<div class='scroll'>{table.html()}</div>\n" for table in _provenance(connection))
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="railvib-snapshot" content="{snapshot}">
<title>Ground vibration: {study}</title>
<link rel="icon" href="data:,">
<style>{_STYLE}</style>
</head>
<body>
<h1>Ground vibration: {study}</h1>
<p class="note">Levels in one-third octaves: dB re 1e-9 m/s for velocity, dB re 1 N for wheel-rail force.
Errors are approach minus reference.</p>
<h2>Summary</h2>
{sentences}
<h2>Errors and costs</h2>
{tables}
<h2>Provenance</h2>
{provenance}
</body>
</html>
"""


def _provenance(connection: duckdb.DuckDBPyConnection) -> list[Table]:
    """Return the runs that the results come from, and what their names stand for."""
    runs = connection.execute(
        "SELECT run_id, started, finished, exit_status, host, host_class, threads, model_version, versions "
        "FROM runs ORDER BY sequence"
    ).fetchall()
    rows = tuple(
        (
            str(run[0]),
            *("–" if value is None else str(value) for value in run[1:8]),
            ", ".join(f"{name} {version}" for name, version in (json.loads(run[8] or "null") or {}).items()),
        )
        for run in runs
    )
    layers = connection.execute(
        "SELECT soil, layer, thickness_m, shear_speed_m_s, dilatational_speed_m_s, density_kg_m3, "
        "loss_factor FROM soil_layers "
        "ORDER BY soil_id, layer"
    ).fetchall()
    counts = connection.execute(
        "SELECT (SELECT count(*) FROM cases), (SELECT count(*) FROM bands), (SELECT count(*) FROM psd), "
        "(SELECT count(*) FROM failures)"
    ).fetchone()
    return [
        Table(
            "Runs",
            (
                "run",
                "started (UTC)",
                "finished (UTC)",
                "exit",
                "host",
                "kind of host",
                "threads",
                "model",
                "versions",
            ),
            rows,
            words=9,
        ),
        Table(
            "Rows of the database",
            ("cases", "one-third octaves", "narrow-band lines", "failures"),
            (tuple(f"{count:,}" for count in counts or ()),),
            words=0,
        ),
        Table(
            "Soils",
            (
                "soil",
                "layer",
                "thickness [m]",
                "shear speed [m/s]",
                "dilatational speed [m/s]",
                "density [kg/m³]",
                "loss factor",
            ),
            tuple(
                (
                    str(soil),
                    str(layer),
                    "half-space" if thickness is None else number(thickness),
                    *map(number, values),
                )
                for soil, layer, thickness, *values in layers
            ),
            words=1,
        ),
    ]
