"""TOML files as plain tables, with helpful errors for invalid ones."""

import codecs
import re
import tomllib
from pathlib import Path
from typing import Any

from railvib.errors import InputError

LARGEST_FILE = 16 * 2**20
"""Largest file in bytes; a study of 100,000 speeds takes 1 MB."""

ENCODINGS = {
    codecs.BOM_UTF32_LE: "UTF-32",
    codecs.BOM_UTF32_BE: "UTF-32",
    codecs.BOM_UTF16_LE: "UTF-16",
    codecs.BOM_UTF16_BE: "UTF-16",
}
"""Encodings by byte order mark; a longer mark stands before the shorter one that it starts with."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a file in UTF-8, with or without a byte order mark.

    Raises
    ------
    InputError
        If it cannot be read, or is not valid; the message says what to do about a wrong encoding or a decimal
        comma.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(content) > LARGEST_FILE:
        raise InputError(f"{path}: has more than {LARGEST_FILE} bytes; must have at most so many")
    text = _decode(content, path)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: is not valid TOML: {error}{_remedy(text, str(error))}") from None
    except RecursionError:
        raise InputError(f"{path}: is not valid: its lists or tables are nested too deeply") from None
    except ValueError as error:  # such as an integer of thousands of digits, or a date that does not exist
        raise InputError(f"{path}: is not valid TOML: {error}") from None


def _decode(content: bytes, path: Path) -> str:
    """Return the text of a file."""
    remedy = "save the file as UTF-8"
    for mark, encoding in ENCODINGS.items():
        if content.startswith(mark):
            raise InputError(f"{path}: is in {encoding}, must be in UTF-8: {remedy}")
    if b"\0" in content:
        raise InputError(f"{path}: holds zero bytes, as text in UTF-16 does; must be in UTF-8: {remedy}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = content[error.start : error.start + 1]
        raise InputError(
            f"{path}: line {line} holds the byte 0x{byte.hex()}, which is no UTF-8; in Latin-1 it is "
            f"{byte.decode('latin-1')!r}: {remedy}"
        ) from None


def _remedy(text: str, fault: str) -> str:
    """Return what to do about a decimal comma in the line of a fault."""
    place = re.search(r"at line (\d+)", fault)
    line = text.splitlines()[int(place[1]) - 1] if place else ""
    comma = re.search(r"=\s*[-+]?(\d+),(\d+)", line)
    return f"; the decimal sign is a point: write {comma[1]}.{comma[2]}" if comma else ""
