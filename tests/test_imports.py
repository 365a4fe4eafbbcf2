"""The packages' imports follow the way of the data: railvib knows nothing of sweep, nor sweep of queries."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FORBIDDEN = {
    "railvib": {"sweep", "queries", "dask", "distributed", "zarr", "duckdb", "matplotlib", "pandas"},
    "sweep": {"queries", "duckdb", "matplotlib", "pandas"},
    "queries": {"railvib", "dask", "distributed", "scipy", "numba"},
}
OPEN_TO_QUERIES = ("sweep.storage.store", "sweep.storage.records")


def imports(path):
    """Yield the full names of what a module imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("package", FORBIDDEN)
def test_no_package_imports_what_stands_above_it(package):
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / package).rglob("*.py")
        for name in imports(path)
        if name.partition(".")[0] in FORBIDDEN[package]
    }
    assert found == set()


def test_queries_reads_the_engine_through_store_and_records_only():
    found = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in (ROOT / "queries").rglob("*.py")
        for name in imports(path)
        if name.partition(".")[0] == "sweep" and not name.startswith(OPEN_TO_QUERIES)
    }
    assert found == set()


def test_no_modules_import_each_other_in_a_circle():
    """Neither at module level, nor inside functions, nor for types alone."""
    modules = {}
    for package in FORBIDDEN:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            modules[".".join(parts).removesuffix(".__init__")] = path
    graph = {module: {owner(name, modules) for name in imports(path)} for module, path in modules.items()}
    graph = {module: needed - {None, module} for module, needed in graph.items()}
    assert len(graph["sweep.cli"]) > 5
    graphlib.TopologicalSorter(graph).prepare()  # raises CycleError with the modules of a circle


def owner(name, modules):
    """Return the module of the three packages in which an imported name lies, or None."""
    return next((each for each in (name, name.rpartition(".")[0]) if each in modules), None)


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("railvib.cli", {"numba", "scipy", "dask", "zarr", "duckdb", "pandas", "matplotlib", "xarray"}),
        ("sweep.cli", {"numba", "scipy", "dask", "zarr", "duckdb", "pandas", "matplotlib", "xarray"}),
        ("sweep.study", {"dask", "distributed", "zarr", "pandas", "xarray"}),
        ("sweep.storage.records", {"dask", "distributed", "zarr", "pandas", "xarray", "numba"}),
    ],
)
def test_a_module_stays_light(module, heavy):
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert heavy.isdisjoint(loaded.stdout.split())
