"""Sizes of a benchmark: how much is measured."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """Samples and cases of every section.

    Attributes
    ----------
    name
        Name on the command line.
    samples
        Repetitions of a timed call.
    wavenumbers
        Number of wavenumbers of the kernel's benchmark.
    bands
        Numbers n of the one-third octaves 10^(n/10) Hz at which transfer functions are compared.
    textbook_s
        Seconds for the rows of one textbook table; the other rows are extrapolated.
    runs
        Repetitions of the study's warm run.
    bands_hz
        Lowest and highest midband of the studies, Hz.
    offsets_m
        Offsets of the studies, m.
    growth
        Per axis the values at which growth is measured.
    rounds
        How often both ends of an axis are run, in turn: a single run depends on the load of the machine.
    """

    name: str
    samples: int
    wavenumbers: int
    bands: tuple[int, ...]
    textbook_s: float
    runs: int
    bands_hz: tuple[float, float]
    offsets_m: tuple[float, ...]
    growth: dict[str, tuple[float, ...]]
    rounds: int


FULL = Size(
    name="full",
    samples=9,
    wavenumbers=20_000,
    bands=tuple(range(21)),
    textbook_s=0.3,
    runs=5,
    bands_hz=(1.0, 100.0),
    offsets_m=(0.0, 8.0, 32.0, 100.0),
    growth={
        "wavenumbers": (350, 700, 1400, 2800),
        "frequencies": (12.5, 25.0, 50.0, 100.0, 200.0),
        "offsets": (4, 12, 36, 100),
        "layers": (2, 4, 8, 16),
        "vehicles": (1, 2, 4, 8),
        "trains": (1, 2, 4),
        "soils": (1, 2, 4),
        "speeds": (1, 5, 20),
        "workers": (1, 2),
    },
    rounds=5,
)
QUICK = Size(
    name="quick",
    samples=3,
    wavenumbers=5_000,
    bands=(0, 10, 20),
    textbook_s=0.05,
    runs=1,
    bands_hz=(8.0, 16.0),
    offsets_m=(8.0, 32.0),
    growth={
        "wavenumbers": (350, 1400),
        "frequencies": (12.5, 25.0),
        "offsets": (4, 32),
        "layers": (2, 8),
        "soils": (1, 2),
        "speeds": (1, 4),
        "workers": (1, 2),
    },
    rounds=1,
)
SIZES = {size.name: size for size in (FULL, QUICK)}
