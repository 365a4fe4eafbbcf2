import re
import tomllib

import numpy as np

import railvib
from railvib.numerics import third_octaves
from railvib.parameters.units import KMH
from railvib.psd.spectra import Spectra
from railvib.stages import STAGES, stage_of
from sweep import cautions, study
from sweep.storage import records, store
from sweep.unit import unit_of
from sweep.wanted import spectra_unit, wanted_units
from tests.sweep.small import STUDY


def wanted(**sections):
    """Return the units of the small study by approach, with some keys changed."""
    data = tomllib.loads(STUDY)
    for name, values in sections.items():
        data.setdefault(name, {}).update(values)
    resolved = study.resolve(data)
    return {
        (case.speed_kmh, approach): spectra_unit(resolved, case, approach)
        for case in resolved.cases()
        for approach in resolved.study.approaches.compare
    }


def ids(unit, stage):
    """Return the ids of all units of a stage that a unit rests on."""
    found = {unit.id} if unit.stage_name == stage else set()
    return found.union(*(ids(need, stage) for need in unit.needs()))


def test_stored_spectra_are_those_of_predict(computed):
    (case,) = study.load(computed / "small.toml").cases()
    resolved = study.load(computed / "small.toml")
    predicted = railvib.predict(
        *(resolved.objects[kind][getattr(case, kind)] for kind in ("soil", "track", "train", "unevenness")),
        case.speed_kmh / KMH,
        offsets=[8.0],
        approaches=("moving-roughness", "full"),
        minimum_frequency=4.0,
        maximum_frequency=8.0,
        tolerance=1e-3,
    )
    for record in records.commits(computed / "out", "spectra"):
        made = store.read(computed / "out", record["group"], Spectra, record["arrays"])
        np.testing.assert_allclose(made.band, third_octaves.midbands(4.0, 8.0))
        for receiver, offset in (("rail", np.nan), ("ground", 8.0)):
            (row,) = np.flatnonzero(
                (made.receiver == receiver) & (made.contribution == "total") & (made.averaging == "line")
            )
            assert made.offset_m[row] == offset or np.isnan(offset)
            here = predicted.velocity_mean_square.sel(
                approach=record["inputs"]["approach"], contribution="total"
            )
            values = here.isel(receiver=0 if receiver == "rail" else 1).values
            np.testing.assert_allclose(made.mean_square[row], values, rtol=1e-6)


def test_another_speed_shares_the_ground():
    both = wanted(sweep={"speed_kmh": [30, 32]})
    for approach in ("moving-roughness", "full"):
        slow, fast = both[30.0, approach], both[32.0, approach]
        assert slow.id != fast.id
        assert ids(slow, "transfer") == ids(fast, "transfer")
        assert ids(slow, "line_integrals") == ids(fast, "line_integrals")
    slow, fast = both[30.0, "moving-roughness"], both[32.0, "moving-roughness"]
    assert ids(slow, "receptance") == ids(fast, "receptance")
    for stage in ("receptance", "moving_transfer"):
        assert not ids(both[30.0, "full"], stage) & ids(both[32.0, "full"], stage)
    assert not ids(slow, "moving_transfer")


def test_another_receiver_leaves_the_others():
    few, more = wanted(), wanted(receivers={"offsets_m": [8, 16]})
    for key in few:
        assert ids(few[key], "transfer") < ids(more[key], "transfer")
        assert ids(few[key], "receptance") == ids(more[key], "receptance")


def test_the_order_of_receivers_and_averages_changes_nothing():
    one = wanted(receivers={"offsets_m": [8, 16]}, approaches={"averaging": ["line", "train"]})
    other = wanted(receivers={"offsets_m": [16.0, 8.0, 8.0]}, approaches={"averaging": ["train", "line"]})
    assert one == other


def test_levels_are_wanted_beside_the_spectra_which_stay_as_they_are():
    data = tomllib.loads(STUDY)
    plain = study.resolve(data)
    asked = study.resolve({**data, "levels": {"metrics": ["ppv", "kb-f-max", "ppv"], "passages": 16}})
    (case,) = plain.cases()
    for approach in ("moving-roughness", "full"):
        (spectra,) = wanted_units(plain, case, approach)
        same, levels = wanted_units(asked, case, approach)
        assert same == spectra
        assert levels.stage_name == "passage_levels"
        assert list(levels.inputs["metrics"]) == ["ppv", "kb-f-max"]
        # They rest on tables and receptances that the spectra need as well, and on nothing else.
        for stage in ("transfer", "receptance"):
            assert ids(levels, stage) == ids(spectra, stage)


def test_the_full_model_has_no_average_over_the_train():
    plain, averaged = wanted(), wanted(approaches={"averaging": ["line", "train"]})
    assert plain[30.0, "full"] == averaged[30.0, "full"]
    assert plain[30.0, "moving-roughness"] != averaged[30.0, "moving-roughness"]
    assert len(ids(averaged[30.0, "moving-roughness"], "train_integrals")) == 2


def test_the_response_to_axle_loads_needs_tables_only_where_something_is_left():
    """At 30 km/h nothing is left at 100 m above 1.7 Hz, and at 8 m above 26 Hz.

    On the rail the response above 26 Hz is known in closed form.
    """
    band = {"minimum_hz": 1.25, "maximum_hz": 80}
    unit = wanted(receivers={"offsets_m": [8, 100]}, frequency=band)[30.0, "full"]
    (still,) = [need for need in unit.needs() if need.stage_name == "quasi_static"]
    found = {}
    for need in still.needs():
        found.setdefault(need.inputs["receiver"], set()).add(need.inputs["block"])
    assert found == {"rail": {0, 1, 2}, 8.0: {0, 1, 2}, 100.0: {0}}


def test_a_receiver_where_nothing_is_left_needs_one_table_all_the_same():
    """At 400 m nothing is left from the lowest band on, which begins at the edge of a block."""
    band = {"minimum_hz": 12.5, "maximum_hz": 16}
    unit = wanted(receivers={"offsets_m": [400]}, frequency=band)[30.0, "full"]
    (still,) = [need for need in unit.needs() if need.stage_name == "quasi_static"]
    needs = [need for need in still.needs()]
    assert [need.inputs["block"] for need in needs if need.inputs["receiver"] == 400.0] == [2]


def test_the_tolerance_enters_every_unit():
    one, other = wanted(), wanted(accuracy={"tolerance": 2e-3})
    for key in one:
        for stage in {stage.name for stage in STAGES.values()}:
            assert not ids(one[key], stage) & ids(other[key], stage)


def test_scopes():
    unit = wanted()[30.0, "full"]
    scopes = {need.stage_name: need.scope for need in unit.needs()}
    assert scopes == {
        "receptance": "speed",
        "moving_transfer": "speed",
        "quasi_static": "speed",
        "transfer": "ground",
    }


def test_estimates_are_near_what_is_stored(computed):
    estimated = stored = 0
    for record in records.commits(computed / "out"):
        unit = unit_of(stage_of(record["kind"], record["inputs"]))
        assert unit.id == record["unit_id"]
        estimated += unit.stage.nbytes()
        stored += sum(cost["bytes_written"] for cost in record["costs"])
    assert stored / 3.0 < estimated < 3.0 * stored


def test_contact_that_is_not_passive_is_told():
    data = tomllib.loads(STUDY)
    data["sweep"]["soil"] = ["horstwalde"]
    data["frequency"]["maximum_hz"] = 315.0
    messages = [text for text in cautions.cautions(study.resolve(data)) if "not passive" in text]
    assert len(messages) == 1
    assert re.match("horstwalde, ballasted-paper: .* at 248 to 309 Hz", messages[0])


def test_extrapolated_unevenness_is_told():
    data = tomllib.loads(STUDY)
    data["frequency"] |= {"minimum_hz": 1.0, "maximum_hz": 100.0}
    data["sweep"]["speed_kmh"] = [80, 150, 100]
    (message,) = cautions.cautions(study.resolve(data))
    # 80 km/h over 3 m is 7.4 Hz; 150 km/h over 150 m is 0.28 Hz.
    assert re.match(r"german-low: 12 of 21 bands \(8 to 100 Hz\) .*, 3 to 150 m, at 80 or 150 km/h", message)


def test_a_train_faster_than_the_waves_is_told():
    data = tomllib.loads(STUDY)
    data["sweep"]["soil"] = ["greby"]
    data["sweep"]["speed_kmh"] = [100, 600]
    data["frequency"]["maximum_hz"] = 80.0
    *waves, unevenness = cautions.cautions(study.resolve(data))
    assert "extrapolated" in unevenness
    assert waves
    for wave in waves:
        assert re.match("greby, ballasted-paper: .*600 km/h.*exceeds", wave)
