import pytest

from benchmarks.runs.invented import LAYER, TRACK, VEHICLE
from queries.database import definitions

TRAIN = {"vehicles": [VEHICLE, {**VEHICLE, "axle_load_n": 1.0}]}


def manifest(**more):
    parameters = {
        "soil": {"soft": {"layers": [{**LAYER, "thickness_m": 2.0}, LAYER]}},
        "track": {"slab": {**TRACK, "mat": {"stiffness_n_m2": 1e7}}},
        "train": {"short": TRAIN},
        "unevenness": {"rough": {"form": "fra-hamid-yang", "track_class": 3}},
    }
    return {"parameters": parameters, **more}


def test_a_name_with_another_definition_is_another_thing():
    one = definitions.identity("soft", {"layers": [1, 2]})
    assert one == definitions.identity("soft", {"layers": [1, 2]})
    assert one != definitions.identity("soft", {"layers": [2, 1]})
    assert one != definitions.identity("hard", {"layers": [1, 2]})


def test_every_row_has_the_columns_that_tell_it_from_others():
    rows = definitions.rows(manifest())
    for table, key in definitions.TABLES.items():
        keys = [tuple(row[name] for name in key) for row in rows[table]]
        assert len(set(keys)) == len(keys) > 0, table


def test_layers_count_from_the_surface_and_a_mat_lies_above_them():
    rows = definitions.rows(manifest(rayleigh_speeds_m_s={"soft": [100.0, 200.0]}))
    layers = [
        (row["layer"], row.get("thickness_m"), row["rayleigh_speed_m_s"]) for row in rows["soil_layers"]
    ]
    assert layers == [(1, 2.0, 100.0), (2, None, 200.0)]
    assert [row["layer"] for row in rows["track_layers"]] == [0, 1]
    assert rows["soils"][0]["base"] == "half-space"


def test_a_train_without_axles_in_its_manifest_has_them_from_its_vehicles():
    """Older manifests do not say where axles are."""
    rows = definitions.rows(manifest())
    assert [row["receiver"] for row in rows["axles"]] == [f"axle-{number}" for number in range(1, 9)]
    assert [row["axle_load_n"] for row in rows["axles"]] == [VEHICLE["axle_load_n"]] * 4 + [1.0] * 4
    assert rows["trains"][0]["length_m"] == pytest.approx(2 * VEHICLE["length_m"])
