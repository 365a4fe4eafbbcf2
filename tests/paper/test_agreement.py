"""The levels of the paper's study are the same from database, store and a single prediction."""

import numpy as np
import pytest

import railvib
from railvib import library
from railvib.numerics import third_octaves
from railvib.parameters.units import KMH
from railvib.psd.lines import Lines
from railvib.stages import stage_of
from sweep.storage import records, store
from sweep.unit import unit_of

SOIL, OFFSET, TOLERANCE = "horstwalde", 8.0, 1e-9
APPROACHES = ("moving-roughness", "moving-roughness-uncorrelated", "full")


@pytest.fixture(scope="module")
def predicted():
    return railvib.predict(
        ground=library.load("soil", SOIL),
        track=library.load("track", "ballasted-paper"),
        train=library.load("train", "grona-taget"),
        unevenness=library.load("unevenness", "fra-hamid-yang-3"),
        speed=150 / KMH,
        offsets=[OFFSET],
    )


def stored(results, run_directory, approach):
    """Return the commit record of a case's spectra."""
    found = results.sql(
        "SELECT DISTINCT unit_id FROM levels JOIN current_units USING (case_id, approach) JOIN units "
        "USING (source, unit_id) WHERE kind = 'spectra' AND soil = $1 AND approach = $2",
        (SOIL, approach),
    )
    (unit_id,) = found.unit_id
    return records.find(run_directory, "spectra", unit_id)


def in_database(results, approach, contribution, receiver, offset):
    found = results.sql(
        "SELECT mean_square FROM levels WHERE soil = $1 AND approach = $2 AND contribution = $3 AND "
        "receiver = $4 AND offset_m IS NOT DISTINCT FROM $5 AND averaging = 'line' ORDER BY band_hz",
        (SOIL, approach, contribution, receiver, offset),
    )
    return found.mean_square.to_numpy()


@pytest.mark.parametrize("approach", APPROACHES)
def test_database_and_prediction_agree(results, predicted, approach):
    for contribution in ("dynamic", "quasi-static", "total"):
        for receiver, offset, name in (("rail", None, "rail"), ("ground", OFFSET, "ground 8 m")):
            expected = predicted.velocity_mean_square.sel(
                approach=approach, contribution=contribution, receiver=name
            )
            found = in_database(results, approach, contribution, receiver, offset)
            np.testing.assert_allclose(found, expected.values, rtol=TOLERANCE)
    for axle in (1, 2, 16):
        expected = predicted.force_mean_square.sel(approach=approach, axle=axle)
        found = in_database(results, approach, "dynamic", f"axle-{axle}", None)
        np.testing.assert_allclose(found, expected.values, rtol=TOLERANCE)


@pytest.mark.parametrize("approach", APPROACHES)
def test_database_and_spectra_computed_again_from_the_store_agree(results, run_directory, approach):
    stage = stage_of("spectra", stored(results, run_directory, approach)["inputs"])

    def load(needed):
        record = records.find(run_directory, needed.name, unit_of(needed).id)
        recorded = {name: record[name] for name in store.GROUP_FIELDS}
        return store.read(run_directory, result_type=needed.result_type(), **recorded)

    again = stage.compute(load)
    assert len(again.receiver) > 20
    for series in range(len(again.receiver)):
        offset = float(again.offset_m[series])
        found = in_database(
            results,
            approach,
            again.contribution[series],
            again.receiver[series],
            None if np.isnan(offset) else offset,
        )
        np.testing.assert_allclose(found, again.mean_square[series], rtol=TOLERANCE)


@pytest.mark.parametrize("approach", APPROACHES)
def test_database_and_stored_lines_summed_into_bands_agree(results, run_directory, approach):
    arrays, attributes = store.read_result(run_directory, stored(results, run_directory, approach))
    place = list(zip(attributes["receiver"], attributes["contribution"], strict=True)).index(
        ("rail", "dynamic")
    )
    lower, upper = third_octaves.edges(arrays["band"])
    edges = [np.abs(arrays["frequency"] - edge).argmin() for edge in (*lower, upper[-1])]
    on_lines = Lines(tuple(arrays["band"]), tuple(np.diff(edges).tolist()))
    np.testing.assert_allclose(on_lines.frequency, arrays["frequency"], rtol=1e-12)
    summed = on_lines.mean_squares(arrays["psd"][place])
    found = in_database(results, approach, "dynamic", "rail", None)
    np.testing.assert_allclose(found, summed, rtol=TOLERANCE)
