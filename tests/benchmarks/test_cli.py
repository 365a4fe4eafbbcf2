"""The program runs at a tiny size, and writes a document and the database."""

import json
from dataclasses import replace

from click.testing import CliRunner

from benchmarks import sizes
from benchmarks.cli import benchmark
from benchmarks.sections import transfer

TINY = {"samples": 1, "wavenumbers": 256, "bands": (20,), "textbook_s": 0.0}


def test_a_tiny_size_is_measured(tmp_path, monkeypatch):
    monkeypatch.setitem(sizes.SIZES, "quick", replace(sizes.QUICK, **TINY))
    arguments = ["--size", "quick", "--only", "transfer,kernel", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(benchmark, arguments)
    assert result.exit_code == 0, result.output
    (file,) = (tmp_path / "out").glob("benchmark-*.json")
    document = json.loads(file.read_text(encoding="utf-8"))
    figures = document["figures"]
    assert {figure["section"] for figure in figures} == {"kernel", "transfer"}
    errors = [figure for figure in figures if figure["quantity"].startswith("error")]
    assert len(errors) == 3 * len(transfer.SOILS)
    assert all(figure["holds"] for figure in errors)
    assert {"railvib", "numba"} <= document["versions"].keys()
    assert (tmp_path / "out" / "benchmarks.duckdb").is_file()


def test_an_unknown_section_is_refused():
    result = CliRunner().invoke(benchmark, ["--only", "kernel,coffee"])
    assert result.exit_code == 2
    assert "'coffee'" in result.output
    assert "kernel, transfer, study, growth" in result.output
