"""The database follows from records and store alone, and is published in one step."""

import json
import os
import signal
import subprocess
import sys

import duckdb
import numpy as np
import pytest

from benchmarks.runs.invented import BANDS, LAYER, Receptance
from queries.database import DATABASE, ResultsError, connect, ingest, schema
from queries.database.arrays import wanted
from sweep.storage import group_writer, records, store

VIEWS = ("psd", "levels", "accuracy", "costs", "missing")


def rows(directory):
    """Return all rows of all tables and views, sorted, numbers of spectra left out."""
    with connect(directory) as connection:
        names = [name for (name,) in connection.execute("SELECT table_name FROM duckdb_tables()").fetchall()]
        names = [name for name in names if name not in ("series", "psd_lines")]
        return {
            name: sorted(map(str, connection.execute(f"FROM {name}").fetchall())) for name in (*names, *VIEWS)
        }


def group(directory, unit_id):
    return records.find(directory, unit_id.partition("-")[0], unit_id)["group"]


def count(directory, table):
    with connect(directory) as connection:
        return connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]


def test_every_case_band_and_line_arrives(study):
    directory = study.write(lines=50)
    assert ingest(directory).changed
    assert count(directory, "cases") == 2
    assert count(directory, "bands") == 2 * 3 * 12 * BANDS.size
    assert count(directory, "psd") == 2 * 3 * 12 * 50
    assert count(directory, "receptances") == 2 * 2 * 100
    assert count(directory, "unevenness_bands") == 21


def test_spectra_arrive_as_they_are_stored(study):
    directory = study.write(lines=50)
    ingest(directory)
    arrays, attributes = store.read_result(directory, {"group": group(directory, "spectra-1-150-full")})
    place = attributes["receiver"].index("rail")
    with connect(directory) as connection:
        found = connection.execute(
            "SELECT frequency_hz, value FROM psd WHERE case_id = 'case-1-150' AND approach = 'full' "
            "AND receiver = 'rail' AND contribution = 'dynamic' ORDER BY frequency_hz"
        ).fetchnumpy()
        bands = connection.execute(
            "SELECT band_hz, mean_square, extrapolated_share FROM bands WHERE case_id = 'case-1-150' "
            "AND approach = 'full' AND receiver = 'rail' AND contribution = 'dynamic' ORDER BY band_hz"
        ).fetchnumpy()
    np.testing.assert_array_equal(found["frequency_hz"], arrays["frequency"])
    np.testing.assert_array_equal(found["value"], arrays["psd"][place])
    np.testing.assert_array_equal(bands["band_hz"], arrays["band"])
    np.testing.assert_array_equal(bands["mean_square"], arrays["mean_square"][place])
    np.testing.assert_array_equal(bands["extrapolated_share"], arrays["extrapolated_share"])


def test_receptances_are_those_under_the_load(study):
    directory = study.write()
    ingest(directory)
    arrays, _ = store.read_result(directory, {"group": group(directory, "receptance-1-150")})
    with connect(directory) as connection:
        found = connection.execute(
            "SELECT frequency_hz, receptance_re, receptance_im, distance_m FROM receptances "
            "WHERE soil = 'greby' AND speed_kmh = 150 ORDER BY frequency_hz"
        ).fetchnumpy()
    np.testing.assert_array_equal(
        found["receptance_re"] + 1j * found["receptance_im"], arrays["receptance"][:, 1]
    )
    assert set(found["distance_m"]) == {0.0}


def overlapping():
    """Return frequencies of three blocks of half a decade, each with a halo of four beyond its edges."""
    blocks = [10.0 ** (0.05 + np.arange(25 * block - 4, 25 * block + 30) / 50) for block in range(3)]
    inside = [(np.arange(34) >= 4) & (np.arange(34) < 29) for _ in blocks]
    return np.concatenate(blocks), np.concatenate(inside)


@pytest.mark.parametrize("halos_are_known", [True, False])
def test_frequencies_of_blocks_that_overlap_arrive_once(study, halos_are_known):
    frequency, inside = overlapping()
    directory = study.write(soils=("clay",), lines=10)
    record = records.find(directory, "receptance", "receptance-0-0")
    receptance = np.stack([frequency * (1e-9 + 1e-10j)] * 3, axis=1)
    table = Receptance(frequency, np.array([-2.7, 0.0, 2.7]), receptance, inside if halos_are_known else None)
    written = group_writer.write(directory, "receptance/again", table, {})
    records.withdraw(directory, "receptance", "receptance-0-0")
    records.commit(directory, record | written.group_fields())
    ingest(directory)
    with connect(directory) as connection:
        found = connection.execute(
            "SELECT frequency_hz, receptance_re FROM receptances WHERE speed_kmh = 0 ORDER BY frequency_hz"
        ).fetchnumpy()
    whole = np.unique(frequency[inside] if halos_are_known else frequency)
    np.testing.assert_allclose(found["frequency_hz"], whole)
    np.testing.assert_allclose(found["receptance_re"], whole * 1e-9)
    if halos_are_known:
        np.testing.assert_allclose(whole, 10.0 ** (0.05 + np.arange(75) / 50))


def test_an_offset_that_does_not_exist_is_null(results):
    found = results.execute("SELECT DISTINCT receiver, offset_m FROM bands ORDER BY ALL").fetchall()
    assert found == [
        ("axle-1", None),
        ("axle-2", None),
        ("ground", 0.0),
        ("ground", 8.0),
        ("ground", 32.0),
        ("rail", None),
    ]


def test_a_second_ingest_does_nothing(study, monkeypatch):
    directory = study.write()
    ingest(directory)
    before = (directory / DATABASE).stat()
    monkeypatch.setattr(records, "commits", lambda *_: pytest.fail("read the records"))
    assert not ingest(directory).changed
    after = (directory / DATABASE).stat()
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_rebuilding_gives_the_same_rows(study):
    directory = study.write()
    ingest(directory)
    before = rows(directory)
    assert ingest(directory, rebuild=True).changed
    assert rows(directory) == before


@pytest.mark.parametrize(
    "again",
    [
        {},
        {"speeds": (150.0, 200.0)},
        {"soils": ("horstwalde",)},
        {"narrow_band": "none"},
        {"approaches": ("moving-roughness", "full")},
    ],
)
def test_a_second_run_added_to_the_snapshot_gives_the_rows_of_a_rebuild(study, again):
    ingest(study.write(lines=10))
    directory = study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", **{"lines": 10, **again})
    assert ingest(directory).changed
    added = rows(directory)
    ingest(directory, rebuild=True)
    assert rows(directory) == added
    assert count(directory, "runs") == 2


def test_a_run_that_adds_nothing_reads_no_array(study, monkeypatch):
    ingest(study.write())
    directory = study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00")
    monkeypatch.setattr(store, "read_result", lambda *_: pytest.fail("read an array"))
    assert ingest(directory).changed


def test_a_soil_that_changed_its_meaning_has_a_row_for_each(study):
    ingest(study.write(soils=("greby",)))
    manifest = records.Run.load(study.directory)
    manifest |= {"run_id": "run-2", "started": "2026-03-02T08:00:00+00:00"}
    manifest["parameters"]["soil"]["greby"]["layers"][0]["density_kg_m3"] = 2000.0
    manifest["cases"][0]["case_id"] = "another-case"
    records.Run.publish(study.directory, manifest)
    ingest(study.directory)
    with connect(study.directory) as connection:
        found = connection.execute(
            "SELECT case_id, density_kg_m3 FROM cases JOIN soil_layers USING (soil_id) WHERE layer = 1 "
            "ORDER BY ALL"
        ).fetchall()
    assert found == [("another-case", 2000.0), ("case-0-150", LAYER["density_kg_m3"])]


@pytest.mark.parametrize("damage", ["missing chunk", "torn metadata"])
def test_a_damaged_group_is_a_failure_and_the_rest_is_there(study, damage):
    directory = study.write()
    place = directory / store.STORE / group(directory, "spectra-0-150-full")
    if damage == "missing chunk":
        next((place / "mean_square").glob("c.*")).unlink()
    else:
        (place / "zarr.json").write_text("torn")
    done = ingest(directory)
    assert done.unreadable == ((directory, "spectra-0-150-full"),)
    with connect(directory) as connection:
        assert connection.execute("SELECT unit_id, kind FROM failures").fetchall() == [
            ("spectra-0-150-full", "spectra")
        ]
        assert connection.execute("SELECT DISTINCT soil FROM accuracy").fetchall() == [("greby",)]
        assert connection.execute("SELECT unit_id FROM missing").fetchall() == [("spectra-0-150-full",)]


def test_an_unfinished_run_is_read(study):
    study.write()
    manifest = records.Run.load(study.directory) | {"finished": None, "exit_status": None}
    records.Run.publish(study.directory, manifest)
    ingest(study.directory)
    with connect(study.directory) as connection:
        assert connection.execute("SELECT finished, exit_status FROM runs").fetchall() == [(None, None)]


def test_a_broken_database_is_made_anew(study):
    directory = study.write()
    ingest(directory)
    before = rows(directory)
    (directory / DATABASE).write_bytes(b"nothing of a database" * 1000)
    assert ingest(directory).changed
    assert rows(directory) == before


def test_an_ingest_that_fails_leaves_the_old_snapshot_and_no_litter(study, monkeypatch):
    ingest(study.write())
    before = rows(study.directory)
    study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(200.0,))
    monkeypatch.setattr("queries.database.arrays.wanted", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        ingest(study.directory)
    assert rows(study.directory) == before
    assert list(study.directory.glob("results.duckdb.*")) == []


def test_an_ingest_that_is_killed_leaves_the_old_snapshot(study):
    ingest(study.write())
    before = rows(study.directory)
    study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(200.0,))
    program = (
        "import sys, time\n"
        "from queries.database import arrays, ingest\n"
        "def stop(*_):\n"
        "    print('in the middle', flush=True)\n"
        "    time.sleep(60)\n"
        "arrays.wanted = stop\n"
        "ingest(sys.argv[1])\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(study.directory)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "in the middle\n"
        process.send_signal(signal.SIGKILL)
    left = list(study.directory.glob("results.duckdb.*"))
    assert left != []
    assert rows(study.directory) == before
    for path in left:
        os.utime(path, (0, 0))
    assert ingest(study.directory).changed
    assert list(study.directory.glob("results.duckdb.*")) == []
    assert count(study.directory, "cases") == 4


def test_a_reader_keeps_its_snapshot_and_the_next_one_gets_the_new(study):
    ingest(study.write())
    with connect(study.directory) as early:
        assert early.execute("SELECT count(*) FROM cases").fetchone() == (2,)
        study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(200.0,))
        ingest(study.directory)
        assert early.execute("SELECT count(*) FROM cases").fetchone() == (2,)
        assert count(study.directory, "cases") == 4


def test_names_are_data_only(study):
    soil = "x'; DROP TABLE cases; --"
    directory = study.write(soils=(soil, '"<script>'))
    ingest(directory)
    with connect(directory) as connection:
        assert connection.execute("SELECT soil FROM cases").fetchall() == [(soil,), ('"<script>',)]


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("all", 2 * 3 * 12),
        ("none", 0),
        ([{"approach": "full", "receiver": "rail", "offset_m": None}], 2 * 2),
        ([{"approach": "full", "receiver": "ground", "offset_m": 8}], 2 * 2),
        ([{"approach": "full", "receiver": "ground", "offset_m": None}], 2 * 2 * 3),
        ([], 0),
    ],
)
def test_the_study_says_which_lines_go_in(study, setting, expected):
    directory = study.write(narrow_band=setting, lines=10)
    ingest(directory)
    assert count(directory, "psd") == 10 * expected
    assert count(directory, "bands") == 2 * 3 * 12 * BANDS.size


def test_a_choice_of_lines_does_not_take_a_receiver_without_offset():
    assert not wanted([{"approach": "full", "receiver": None, "offset_m": 8.0}], "full", "rail", float("nan"))


def test_a_directory_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(ResultsError, match="no such directory"):
        ingest(tmp_path / "nowhere")
    with pytest.raises(ResultsError, match="not the output directory of a run"):
        ingest(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_every_table_view_and_column_says_what_it_is(results):
    unsaid = results.execute(
        "SELECT table_name, column_name FROM duckdb_columns() WHERE NOT internal AND comment IS NULL UNION "
        "ALL "
        "SELECT table_name, '' FROM duckdb_tables() WHERE comment IS NULL UNION ALL "
        "SELECT view_name, '' FROM duckdb_views() WHERE NOT internal AND comment IS NULL"
    ).fetchall()
    assert unsaid == []


def test_a_column_whose_name_bears_no_unit_names_it_in_its_comment(results):
    found = results.execute(
        "SELECT comment FROM duckdb_columns() WHERE table_name = 'bands' AND column_name = 'mean_square'"
    ).fetchone()
    assert found == ("Mean square in the band: (m/s)^2 for velocity, N^2 for wheel_rail_force",)


def test_the_file_opens_in_the_oldest_duckdb_that_is_supported(paper):
    with duckdb.connect(":memory:") as connection:
        connection.execute(f"ATTACH '{paper / DATABASE}' AS results (READ_ONLY)")
        (tags,) = connection.execute(
            "SELECT tags FROM duckdb_databases() WHERE database_name = 'results'"
        ).fetchone()
    assert tags["storage_version"].startswith("v1.")


def test_migrations_are_numbered_from_one_without_gaps(results):
    numbers = [version for version, _, _ in schema.migrations()]
    assert numbers == list(range(1, len(numbers) + 1))
    assert results.execute("SELECT version FROM schema_version ORDER BY 1").fetchall() == [
        (n,) for n in numbers
    ]


def test_the_resolved_study_is_readable_json(results):
    (text,) = results.execute("SELECT resolved_study FROM runs").fetchone()
    assert json.loads(text)["study"]["name"] == "paper"
