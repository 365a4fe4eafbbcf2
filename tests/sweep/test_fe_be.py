"""The approach fe-be in a study: the same tables, units of its own."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import railvib
from railvib import library
from railvib.errors import InputError
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.vehicle import Train
from railvib.psd.spectra import Spectra
from sweep import study
from sweep.storage import records, store
from sweep.wanted import spectra_unit
from tests.sweep.small import STUDY, invoke
from tests.sweep.test_wanted import ids

DEGENERATE = '[cross_section]\nbed = "columns"\ncontact = "smooth"\ndisplacement = "centre"\nelements = 1\n'
BOTH = STUDY.replace('"full"', '"fe-be"') + DEGENERATE


def unit(text, approach):
    resolved = study.resolve(tomllib.loads(text))
    (case,) = resolved.cases()
    return spectra_unit(resolved, case, approach)


def test_degenerate_model_stores_what_moving_roughness_stores(tmp_path, monkeypatch):
    (tmp_path / "both.toml").write_text(BOTH, encoding="utf-8")
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    result = invoke("run", tmp_path / "both.toml", "--out", tmp_path / "out", "--workers", 0)
    assert result.exit_code == 0, result.output
    made = {}
    for record in records.commits(tmp_path / "out", "spectra"):
        made[record["inputs"]["approach"]] = store.read(
            tmp_path / "out", record["group"], Spectra, record["arrays"]
        )
        assert record["costs"]
    assert set(made) == {"moving-roughness", "fe-be"}
    np.testing.assert_array_equal(made["fe-be"].quantity, made["moving-roughness"].quantity)
    np.testing.assert_allclose(made["fe-be"].mean_square, made["moving-roughness"].mean_square, rtol=1e-5)


def test_cross_section_is_identity_of_its_approach_only():
    other = BOTH.replace("[cross_section]", "[cross_section]\nlayer_height_m = 0.5")
    for stage in ("transfer", "receptance", "line_integrals", "spectra"):
        assert not ids(unit(BOTH, "fe-be"), stage) & ids(unit(other, "fe-be"), stage)
        assert not ids(unit(BOTH, "fe-be"), stage) & ids(unit(BOTH, "moving-roughness"), stage)
        assert ids(unit(BOTH, "moving-roughness"), stage) == ids(unit(other, "moving-roughness"), stage)
        assert ids(unit(BOTH, "moving-roughness"), stage) == ids(unit(STUDY, "moving-roughness"), stage)


def test_study_of_the_verification_is_valid():
    resolved = study.load(Path(__file__).parents[2] / "studies" / "verification.toml")
    assert "fe-be" in resolved.study.approaches.compare
    section = resolved.study.cross_section
    assert (section.layer_height, section.poisson_ratio, section.contact) == (0.35, 0.2, "bonded")


def test_document_says_the_cross_section_in_full():
    document = study.resolve(tomllib.loads(BOTH)).document()
    assert document["cross_section"]["layer_height_m"] == 0.35
    assert study.resolve(document).document() == document


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("poisson_ratio = 0.7", "cross_section.poisson_ratio = 0.7"),
        ("height_m = 0.7", "cross_section.height_m: unknown key; did you mean layer_height_m"),
        ('bed = "columns"', "cross_section"),
    ],
)
def test_wrong_cross_section_is_refused(line, message):
    with pytest.raises(InputError, match=message):
        study.resolve(tomllib.loads(STUDY + "[cross_section]\n" + line))


def test_predict_knows_the_approach(horstwalde, track, vehicle):
    """Degenerate, and as it is: what the cross-section changes is small, and there."""

    def level(approach, **choices):
        case = railvib.predict(
            horstwalde,
            track,
            Train(vehicles=(vehicle,)),
            library.load("unevenness", "german-low"),
            80.0,
            approaches=[approach],
            minimum_frequency=31.5,
            maximum_frequency=40.0,
            tolerance=1e-2,
            cross_section=CrossSection(**choices),
        )
        return 10.0 * np.log10(case.velocity_mean_square.sel(contribution="dynamic").values)

    reference = level("moving-roughness")
    degenerate = level("fe-be", bed="columns", contact="smooth", displacement="centre", elements=1)
    np.testing.assert_allclose(degenerate, reference, rtol=0.0, atol=1e-3)
    change = abs(level("fe-be", elements=2, rows=1) - reference)
    assert 0.1 < change.max() < 3.0
