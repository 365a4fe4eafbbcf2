"""Reads the reference numbers of this folder."""

import csv
from functools import cache
from pathlib import Path

import numpy as np


@cache
def rows(name):
    """Return the rows of a file by column, as text."""
    with Path(__file__).with_name(f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def band_limit_of_iso_8041(frequency):
    """Return the band limitation that Wb, Wd and Wk share, 0.4 to 100 Hz."""
    s = 1j * np.asarray(frequency)
    high = s * s / (s * s + np.sqrt(2.0) * 0.4 * s + 0.16)
    return high * 1e4 / (s * s + np.sqrt(2.0) * 100.0 * s + 1e4)
