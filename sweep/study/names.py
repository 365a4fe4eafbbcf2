"""Rules for names, which become parts of file and folder names on any system."""

import re
from typing import Annotated

from pydantic import AfterValidator, Strict

LONGEST = 100
"""Largest length in bytes; a file name may have 255, and holds more than one such name."""

DEVICES = {
    "con",
    "prn",
    "aux",
    "nul",
    *(f"{port}{number}" for port in ("com", "lpt") for number in range(10)),
}
"""Names that Windows reserves for devices, with any extension."""


def check_name(name: str) -> str:
    """Return a name that can stand in the name of a file.

    Raises
    ------
    ValueError
        If it cannot.
    """
    if not re.fullmatch(r"[\w.+-]+", name):
        raise ValueError("may consist of letters, digits and _ . + - only")
    if len(name.encode()) > LONGEST:
        raise ValueError(f"has {len(name.encode())} bytes; must have at most {LONGEST}")
    if name.endswith("."):
        raise ValueError("must not end with a dot: as the name of a folder it means another one")
    if name.partition(".")[0].lower() in DEVICES:
        raise ValueError("is the name of a device on Windows")
    return name


Name = Annotated[str, Strict(), AfterValidator(check_name)]
