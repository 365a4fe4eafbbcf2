"""A figure's file holds its caption, and another one beside it does."""

import re
import zlib

import pytest
from PIL import Image

from queries.figures import catalogue
from queries.figures.write import write


@pytest.fixture
def drawing(results):
    drawing = next(drawing for drawing in catalogue.drawings(results) if "ground" in drawing.name)
    return drawing.leaving_out("Half of it.")


def test_the_caption_says_what_is_shown_and_what_is_left_out(drawing):
    assert drawing.caption == (
        "Ground velocity in one-third octaves at each distance from the track, horstwalde, greby: "
        "grona-taget on ballasted-paper, fra-hamid-yang-3, 150 km/h. Half of it."
    )


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_caption_lies_beside_the_figure_and_in_its_metadata(drawing, tmp_path, kind):
    write(drawing, tmp_path, kind)
    assert {path.name for path in tmp_path.iterdir()} == {f"figure-10-ground.{kind}", "figure-10-ground.txt"}
    assert (tmp_path / "figure-10-ground.txt").read_text() == f"{drawing.caption}\n"
    file = tmp_path / f"figure-10-ground.{kind}"
    if kind == "png":
        assert Image.open(file).text["Description"] == drawing.caption
    elif kind == "svg":
        assert drawing.caption in re.sub(r"\s+", " ", file.read_text())
    else:
        streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", file.read_bytes(), re.DOTALL)
        whole = file.read_bytes() + b"".join(_decompressed(stream) for stream in streams)
        assert drawing.caption.encode() in whole


def _decompressed(stream):
    try:
        return zlib.decompress(stream)
    except zlib.error:
        return b""


def test_what_is_left_out_is_written_on_the_figure(drawing, tmp_path, monkeypatch):
    texts = []
    monkeypatch.setattr("queries.figures.appearance.annotate", lambda figure, note: texts.append(note))
    write(drawing, tmp_path, "png")
    assert texts == ["Half of it."]
