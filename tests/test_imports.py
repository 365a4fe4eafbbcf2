"""Imports go one way: between the packages, between the rooms of each, and never in a circle."""

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
OUTSIDE = {"benchmarks", "tests"}
"""Packages that none of the three imports."""
LAYERS = {
    "railvib": (
        {"cost", "errors", "signals"},
        {"numerics"},
        {"levels", "parameters"},
        {"library", "soil"},
        {"transfer"},
        {"fe_be", "forces", "plausibility"},
        {"psd"},
        {"passage"},
        {"stages"},
        {"prediction"},
    ),
    "sweep": (
        {"hooks", "host", "identity"},
        {"study", "unit"},
        {"cautions", "description", "plan", "processes", "storage", "wanted"},
        {"running"},
        {"progress", "request", "workers"},
        {"forecast", "manifest", "status"},
        {"run"},
        {"driver"},
    ),
    "queries": (
        {"statements"},
        {"database"},
        {"answers", "refusal"},
        {"figures"},
        {"report"},
        {"publication"},
        {"publisher"},
    ),
}
"""Rooms and single modules of a package: each imports from layers above its own only."""
PROGRAM = {"__init__", "__main__", "cli"}
"""Modules that import from all layers."""
PHYSICS = {"soil", "transfer", "fe_be", "forces", "psd", "passage", "prediction"}
"""Rooms of railvib that sweep does not see; it goes by the stages."""
NEAR_KERNELS = {Path("sweep/forecast/pilot.py"), Path("sweep/processes/compiling.py")}
"""Modules that measure a kernel, or prepare its cache."""
OPEN_TO_QUERIES = ("sweep.storage.store", "sweep.storage.records")


def imports(path):
    """Yield the full names of what a module imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def package_imports(package):
    """Yield the path of each module of a package below the root, and the full name of each of its imports."""
    for path in sorted((ROOT / package).rglob("*.py")):
        for name in imports(path):
            yield path.relative_to(ROOT), name


@pytest.mark.parametrize("package", FORBIDDEN)
def test_no_package_imports_what_stands_above_it(package):
    forbidden = FORBIDDEN[package] | OUTSIDE
    assert [
        f"{path}: {name}" for path, name in package_imports(package) if name.partition(".")[0] in forbidden
    ] == []


def test_nobody_imports_tests():
    assert [
        f"{path}: {name}" for path, name in package_imports("benchmarks") if name.partition(".")[0] == "tests"
    ] == []


@pytest.mark.parametrize("package", LAYERS)
def test_rooms_import_from_the_layers_above_them(package):
    layers = {room: number for number, rooms in enumerate(LAYERS[package]) for room in rooms}
    wrong = []
    for path, name in package_imports(package):
        room, (first, *inner) = Path(path.parts[1]).stem, name.split(".")
        if first != package or inner[:1] in ([], [room]) or room in PROGRAM or inner == ["MODEL_VERSION"]:
            continue
        if layers[inner[0]] >= layers[room]:
            wrong.append(f"{path}: {name}")
    assert wrong == []


@pytest.mark.parametrize("package", LAYERS)
def test_every_room_has_a_layer(package):
    rooms = {
        path.stem
        for path in (ROOT / package).iterdir()
        if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert rooms == PROGRAM & rooms | set().union(*LAYERS[package])


def test_sweep_goes_by_the_stages():
    assert [
        f"{path}: {name}"
        for path, name in package_imports("sweep")
        if name.startswith(tuple(f"railvib.{room}." for room in PHYSICS)) and path not in NEAR_KERNELS
    ] == []


def test_queries_reads_the_engine_through_store_and_records_only():
    assert [
        f"{path}: {name}"
        for path, name in package_imports("queries")
        if name.partition(".")[0] == "sweep" and not name.startswith(OPEN_TO_QUERIES)
    ] == []


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
        ("sweep.driver", {"numba", "dask", "zarr", "duckdb", "pandas", "matplotlib", "xarray"}),
        ("railvib.stages", {"numba", "dask", "zarr", "duckdb", "pandas", "matplotlib", "xarray"}),
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
