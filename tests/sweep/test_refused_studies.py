"""Studies that are refused: one line, exit code 2, nothing written; those that are unusual: a warning."""

import os

import pytest

from tests.sweep.small import STUDY, invoke

LAYERS = "layers = [{ thickness_m = 1e-6, shear_speed_m_s = 100, dilatational_speed_m_s = 200, "
SOIL = LAYERS + "density_kg_m3 = 1800, loss_factor = 0.1 }]"
TRAIN = 'vehicle = "regina"'


def written(text, encoding="utf-8"):
    return text.encode(encoding)


def with_(old, new):
    assert old in STUDY
    return written(STUDY.replace(old, new))


@pytest.mark.parametrize("command", ["plan", "run"])
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (with_('"small"', '".."'), "study.name = '..': must not end with a dot"),
        (with_('"small"', '"CON"'), "study.name = 'CON': is the name of a device"),
        (with_('"small"', f'"{"n" * 300}"'), "has 300 bytes; must have at most 100"),
        (with_('"small"', '"Line 4"'), "any text may be the title beside it"),
        (
            with_("[30]", "[3e8]"),
            "sweep.speed_kmh[0] = 300000000.0 km/h: should be less than or equal to 1000",
        ),
        (
            with_("[30]", "[1e-3]"),
            "sweep.speed_kmh[0] = 0.001 km/h: should be greater than or equal to 1 km/h",
        ),
        (
            with_("[30]", "{ start = 1, stop = 2, step = 1e-300 }"),
            "sweep.speed_kmh.step = 1e-300: makes 1e+300",
        ),
        (with_("[30]", f"[{10**400}]"), "sweep.speed_kmh[0] = 1000"),
        (with_("[30]", "[" * 50 + "]" * 50), "sweep.speed_kmh"),
        (with_("[30]", "[" * 90_000 + "]" * 90_000), "lists or tables are nested too deeply"),
        (with_("[30]", f"[{'30,' * 100_001}]"), "must have at most 100000 values"),
        (
            with_("offsets_m = [8]", "offsets_m = [1e5]"),
            "receivers.offsets_m[0] = 100000.0 m: should be less",
        ),
        (
            with_("offsets_m = [8]", "offsets_m = [true]"),
            "receivers.offsets_m[0] = True: should be a valid number",
        ),
        (
            with_(TRAIN, f"{TRAIN}\nnumber = {10**6}"),
            "train.single.number = 1000000: must be a whole number from",
        ),
        (with_(TRAIN, f"{TRAIN}\nnumber = {10**18}"), "train.single.number = 1000000000000000000: must be"),
        (with_('["horstwalde"]', f'["{"s" * 250}"]'), "has 250 bytes; must have at most 100"),
        (
            with_("[accuracy]", '[levels]\nmetrics = ["kb"]\n[accuracy]'),
            "levels.metrics[0] = 'kb': should be 'kb-f-max'",
        ),
        (
            with_("[accuracy]", '[levels]\nmetrics = ["ppv"]\nquantiles = [1.0]\n[accuracy]'),
            "levels.quantiles[0] = 1.0: should be less than 1",
        ),
        (
            with_("[accuracy]", '[levels]\nmetrics = ["ppv"]\npassages = 15\n[accuracy]'),
            "levels.passages = 15: must be 0, for closed forms, or from 16 to 65536",
        ),
        (
            with_("[accuracy]", f"[soil.mine]\n{SOIL}\n[accuracy]"),
            "thickness_m = 1e-06 m: should be greater",
        ),
        (with_("tolerance = 1e-3", f'tolerance = "{"t" * 10**6}"'), "should be a valid number"),
        (with_("tolerance", "t" * 10**6), "unknown key; known are tolerance"),
        (with_("tolerance = 1e-3", "tolerance = 0,001"), "the decimal sign is a point: write 0.001"),
        (with_("tolerance = 1e-3", 'tolerance = "\\u001b[31mred"'), r"accuracy.tolerance = '\x1b[31mred'"),
        (written(STUDY, "utf-16"), "is in UTF-16, must be in UTF-8: save the file as UTF-8"),
        (written(STUDY.replace("small", "Gröna"), "latin-1"), "in Latin-1 it is 'ö': save the file as UTF-8"),
    ],
    ids=lambda value: None if isinstance(value, bytes) else value[:40],
)
def test_a_refusal_is_one_line_and_writes_nothing(tmp_path, monkeypatch, command, content, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_bytes(content)
    result = invoke(command, "study.toml", *(["--workers", 0] if command == "run" else []))
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert result.stderr.startswith("Error: ")
    assert result.stderr.count("\n") == 1
    assert len(result.stderr) < 600
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_more_cases_than_can_be_planned_are_refused_before_they_are_enumerated(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    speeds = "{ start = 10, stop = 1000, number = 99999 }"
    soils = STUDY.replace('["horstwalde"]', '["horstwalde", "greby", "mine"]').replace("[30]", speeds)
    half_space = SOIL.replace("thickness_m = 1e-6, ", "")
    (tmp_path / "study.toml").write_text(f"{soils}\n[soil.mine]\n{half_space}\n", encoding="utf-8")
    result = invoke("plan", "study.toml")
    assert result.exit_code == 2, result.output
    planning, refusal = result.stderr.splitlines()
    assert planning == "planning 299997 cases, some 3.6e+02 s"
    assert refusal.startswith(
        "Error: sweep.speed_kmh: 99999 values make 299997 cases; must be at most 200000"
    )


def test_what_is_unusual_is_a_warning_of_the_plan(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = STUDY.replace('name = "small"', 'name = "small"\ntitle = "A slow train – for once"')
    (tmp_path / "study.toml").write_text("\ufeff" + study.replace("[30]", "[5]"), encoding="utf-8")
    result = invoke("plan", "study.toml")
    assert result.exit_code == 0, result.output
    assert "warning: sweep.speed_kmh = 5 km/h: trains run at 10 km/h or more" in result.stderr
    assert result.stdout.startswith("title       A slow train – for once\nstudy       small, to ")


@pytest.mark.parametrize("command", ["plan", "run"])
@pytest.mark.parametrize("name", ["why?", "back\\slash", os.fsdecode(b"no\xfftext")])
def test_a_place_where_no_database_can_be_opened_is_refused_before_anything_runs(
    tmp_path, monkeypatch, command, name
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    result = invoke(command, "study.toml", "--out", os.path.join(name, "out"))
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith("Error: --out = ")
    assert "must be in UTF-8 and without ? and \\" in result.stderr
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]
