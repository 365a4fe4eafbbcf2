"""Every module has a test: one of its own at the same place below tests, or one that is named here.

A room's compiled code is tested with the module that calls it: `railvib/soil/_kernels/strip.py` by
`tests/railvib/soil/test_strip.py`.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LAWS = "physics/test_laws_of_both_approaches.py"
PASSAGE = "physics/test_random_passage.py"
COVERED = {
    "railvib/cli.py": "railvib/library/test_command.py",
    "railvib/errors.py": "railvib/test_plausibility.py",
    "railvib/signals.py": "sweep/test_signals.py",
    "railvib/fe_be/_kernels/boundary_elements.py": "physics/test_strips.py",
    "railvib/forces/_kernels/axle_system.py": "railvib/forces/test_wheel_rail.py",
    "railvib/forces/_kernels/rail_integrals.py": "railvib/forces/test_receptance.py",
    "railvib/forces/moving_transfer.py": "railvib/forces/test_receptance.py",
    "railvib/forces/rail_integrals.py": "railvib/forces/test_receptance.py",
    "railvib/forces/smooth_receptance.py": "railvib/forces/test_receptance.py",
    "railvib/numerics/_kernels/lagrange.py": "railvib/numerics/test_wavenumber_panels.py",
    "railvib/numerics/_kernels/panels.py": "railvib/numerics/test_wavenumber_panels.py",
    "railvib/parameters/approach.py": "railvib/stages/test_graph.py",
    "railvib/parameters/composite_vehicle.py": "railvib/parameters/test_rake.py",
    "railvib/parameters/metric.py": "railvib/passage/test_metrics.py",
    "railvib/parameters/speed.py": "railvib/test_plausibility.py",
    "railvib/passage/_kernels/panel_series.py": PASSAGE,
    "railvib/passage/amplitudes.py": PASSAGE,
    "railvib/passage/closed_levels.py": "railvib/passage/test_closed_forms.py",
    "railvib/passage/ensemble.py": PASSAGE,
    "railvib/passage/excitation.py": PASSAGE,
    "railvib/passage/full_model.py": PASSAGE,
    "railvib/passage/grid.py": PASSAGE,
    "railvib/passage/moments.py": PASSAGE,
    "railvib/passage/moving_roughness.py": PASSAGE,
    "railvib/passage/passage_levels.py": "railvib/stages/test_passage_levels.py",
    "railvib/passage/quasi_static.py": PASSAGE,
    "railvib/psd/_kernels/averages.py": "railvib/psd/test_train_average.py",
    "railvib/psd/_kernels/moments.py": "railvib/psd/test_excitation.py",
    "railvib/psd/full_model.py": LAWS,
    "railvib/psd/full_model_spectra.py": LAWS,
    "railvib/psd/line_integrals.py": "railvib/psd/test_train_average.py",
    "railvib/psd/moving_roughness.py": LAWS,
    "railvib/psd/moving_roughness_spectra.py": LAWS,
    "railvib/psd/quasi_static.py": "physics/test_passage_in_time.py",
    "railvib/psd/spectra.py": LAWS,
    "railvib/soil/_kernels/layers.py": "railvib/soil/test_flexibility.py",
    "railvib/soil/_kernels/rayleigh.py": "railvib/soil/test_surface_waves.py",
    "railvib/soil/flexibility_tensor.py": "physics/test_flexibility_tensor.py",
    "railvib/stages/case_spectra.py": "railvib/stages/test_graph.py",
    "railvib/stages/fe_be_table.py": "sweep/test_fe_be.py",
    "railvib/stages/full_model.py": "railvib/stages/test_graph.py",
    "railvib/stages/line_integrals.py": "railvib/stages/test_graph.py",
    "railvib/stages/model_stage.py": "railvib/stages/test_graph.py",
    "railvib/stages/moving_roughness.py": "railvib/stages/test_graph.py",
    "railvib/stages/moving_transfer.py": "railvib/stages/test_graph.py",
    "railvib/stages/passage_dataset.py": "railvib/test_prediction.py",
    "railvib/stages/quasi_static.py": "railvib/stages/test_graph.py",
    "railvib/stages/receptances.py": "railvib/stages/test_graph.py",
    "railvib/stages/stage.py": "railvib/stages/test_graph.py",
    "railvib/stages/tables.py": "railvib/stages/test_graph.py",
    "railvib/stages/train_integrals.py": "railvib/stages/test_graph.py",
    "railvib/stages/transfer_table.py": "railvib/stages/test_graph.py",
    "railvib/stages/warm_up.py": "sweep/forecast/test_estimate.py",
    "railvib/transfer/_kernels/interpolation.py": "railvib/transfer/test_transfer_function.py",
    "railvib/transfer/_kernels/track.py": "consistency/test_rail_on_springs.py",
    "railvib/transfer/_kernels/waves.py": "railvib/transfer/test_tabulate.py",
    "railvib/transfer/compliance_under_track.py": "physics/test_coupling.py",
    "railvib/transfer/critical_speed.py": "railvib/soil/test_surface_waves.py",
    "railvib/transfer/interpolate.py": "railvib/transfer/test_transfer_function.py",
    "railvib/transfer/interpolation_error.py": "railvib/transfer/test_tabulate.py",
    "railvib/transfer/samples.py": "railvib/transfer/test_tabulate.py",
    "railvib/transfer/steady_response.py": "physics/test_passage_in_time.py",
    "railvib/transfer/track_response.py": "consistency/test_rail_on_springs.py",
    "sweep/cautions.py": "sweep/test_wanted.py",
    "sweep/driver.py": "sweep/test_cli.py",
    "sweep/forecast/pilot.py": "sweep/forecast/test_estimate.py",
    "sweep/hooks.py": "queries/test_places.py",
    "sweep/host.py": "queries/database/test_sources.py",
    "sweep/manifest.py": "sweep/test_cli.py",
    "sweep/processes/forks.py": "sweep/forecast/test_estimate.py",
    "sweep/processes/parent.py": "sweep/test_crashes.py",
    "sweep/progress.py": "sweep/test_status.py",
    "sweep/request.py": "sweep/test_outside_store.py",
    "sweep/run.py": "sweep/test_cli.py",
    "sweep/running/task.py": "sweep/running/test_scheduler.py",
    "sweep/storage/bucket.py": "sweep/storage/test_location.py",
    "sweep/storage/checksums.py": "sweep/storage/test_store.py",
    "sweep/storage/codec.py": "sweep/storage/test_store.py",
    "sweep/storage/fields.py": "sweep/storage/test_store.py",
    "sweep/storage/forms.py": "sweep/storage/test_records.py",
    "sweep/storage/group.py": "sweep/storage/test_store.py",
    "sweep/storage/group_writer.py": "sweep/storage/test_store.py",
    "sweep/storage/protocol.py": "sweep/storage/test_location.py",
    "sweep/storage/verify.py": "sweep/test_status.py",
    "sweep/workers/allocation.py": "sweep/test_slurm.py",
    "sweep/workers/leftovers.py": "sweep/test_status.py",
    "sweep/workers/dask_cluster.py": "sweep/running/test_scheduler.py",
    "sweep/workers/drain.py": "sweep/workers/test_jobs.py",
    "sweep/workers/launch.py": "sweep/test_running_cluster.py",
    "sweep/workers/preloaded.py": "sweep/test_crashes.py",
    "sweep/workers/reach.py": "sweep/test_running_cluster.py",
    "sweep/workers/server.py": "sweep/test_crashes.py",
    "sweep/workers/tls.py": "sweep/test_running_cluster.py",
    "queries/answers/cases.py": "queries/answers/test_compare.py",
    "queries/answers/comparison.py": "queries/answers/test_compare.py",
    "queries/answers/costs.py": "queries/answers/test_compare.py",
    "queries/answers/errors.py": "queries/answers/test_compare.py",
    "queries/answers/provenance.py": "queries/report/test_report.py",
    "queries/answers/summary.py": "queries/answers/test_compare.py",
    "queries/cli.py": "queries/test_places.py",
    "queries/database/arrays.py": "queries/database/test_ingest.py",
    "queries/database/connection.py": "queries/test_places.py",
    "queries/database/filling.py": "queries/database/test_ingest.py",
    "queries/database/manifests.py": "queries/database/test_labels.py",
    "queries/database/place.py": "queries/test_places.py",
    "queries/database/replacement.py": "queries/test_places.py",
    "queries/database/schema.py": "queries/database/test_migrations.py",
    "queries/database/verification.py": "queries/database/test_ingest.py",
    "queries/figures/appearance.py": "queries/figures/test_figures.py",
    "queries/figures/catalogue.py": "queries/figures/test_figures.py",
    "queries/figures/drawing.py": "queries/figures/test_figures.py",
    "queries/figures/error_plots.py": "queries/figures/test_figures.py",
    "queries/figures/lines.py": "queries/figures/test_figures.py",
    "queries/figures/track_plots.py": "queries/figures/test_figures.py",
    "queries/publication.py": "queries/test_places.py",
    "queries/publisher.py": "queries/figures/test_processes.py",
    "queries/refusal.py": "queries/test_places.py",
    "queries/report/data.py": "queries/report/test_report.py",
    "queries/report/write.py": "queries/report/test_report.py",
}
"""Modules without a test of their own, with the file of the law or the test that covers them."""


def modules():
    """Return the modules of the three packages, by their paths below the root."""
    paths = (path for package in ("railvib", "sweep", "queries") for path in (ROOT / package).rglob("*.py"))
    return {str(path.relative_to(ROOT)) for path in paths if not path.name.startswith("__")}


def mirror(module):
    """Return the path below tests of a module's own test."""
    path = Path(module.replace("/_kernels/", "/"))
    return path.with_name(f"test_{path.stem}.py")


@pytest.mark.parametrize("module", sorted(modules()))
def test_a_module_has_a_test(module):
    tests = ROOT / "tests"
    assert (tests / mirror(module)).is_file() or (tests / COVERED.get(module, "none")).is_file()


def test_no_module_is_listed_that_is_gone():
    assert COVERED.keys() <= modules()
