"""The files of a figure: the picture, with its caption in the metadata, and the caption beside it."""

from pathlib import Path
from typing import Any

from queries.figures.drawing import Drawing

_FIELDS = {"png": "Description", "svg": "Description", "pdf": "Subject"}
"""Metadata field of the caption, by file format."""
_LEFT_OUT = {"png": "Software", "svg": "Date", "pdf": "CreationDate"}
"""Metadata field that would make files of equal figures differ, by file format."""


def write(drawing: Drawing, folder: Path, kind: str) -> None:
    """Draw a figure into a file of a kind, png, svg or pdf, and write its caption beside it."""
    from queries.figures import appearance

    metadata = {"Title": drawing.name, _FIELDS[kind]: drawing.caption, _LEFT_OUT[kind]: None}
    # Stronger compression of a PNG takes twice the time to save a tenth of its size.
    options: dict[str, Any] = {"pil_kwargs": {"compress_level": 1}} if kind == "png" else {}
    figure = drawing.draw()
    if drawing.note:
        appearance.annotate(figure, drawing.note)
    file = folder / f"{drawing.name}.{kind}"
    partial = file.with_name(f"{file.name}.partial")
    try:
        figure.savefig(partial, format=kind, metadata=metadata, **options)
        partial.replace(file)
    finally:
        partial.unlink(missing_ok=True)
    appearance.take_back(figure)
    file.with_suffix(".txt").write_text(f"{drawing.caption}\n", encoding="utf-8")
