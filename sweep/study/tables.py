"""Tables before validation: limits on depth and size, and one spelling of every text."""

import unicodedata
from collections.abc import Mapping
from typing import Any

from railvib.errors import InputError
from railvib.parameters.validation import LARGEST_INTEGER, shown

DEEPEST = 16
"""Largest depth of nested tables and lists."""


def plain(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return tables with all texts and keys in Unicode form NFC, so that names that look equal are equal.

    Raises
    ------
    InputError
        If tables are nested too deeply, a key comes twice in different spellings, or an integer is so large
        that it is no float.
    """
    table: dict[str, Any] = _plain(tables, "", 0)
    return table


def _plain(value: Any, path: str, depth: int) -> Any:
    if depth > DEEPEST:
        raise InputError(f"{path}: is nested too deeply; must be at most {DEEPEST} levels down")
    if isinstance(value, str):
        return unicodedata.normalize("NFC", value)
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        raise InputError(f"{path} = {shown(value)}: must be between -2^53 and 2^53")
    if isinstance(value, list | tuple):
        return [_plain(item, f"{path}[{index}]", depth + 1) for index, item in enumerate(value)]
    if not isinstance(value, Mapping):
        return value
    table: dict[str, Any] = {}
    for key, item in value.items():
        name = unicodedata.normalize("NFC", key)
        place = f"{path}.{name}".lstrip(".")
        if name in table:
            raise InputError(f"{place}: is there twice, in two spellings that look the same")
        table[name] = _plain(item, place, depth + 1)
    return table
