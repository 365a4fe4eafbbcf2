"""A run directory as the engine leaves it, with invented numbers whose levels and errors are known by hand.

The tests of `queries` read it as well.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sweep.storage import group_writer, records

APPROACHES = ("moving-roughness", "moving-roughness-uncorrelated", "full")
BANDS = 10.0 ** (np.arange(0, 21) / 10.0)
RECEIVERS = (
    ("axle-1", math.nan),
    ("axle-2", math.nan),
    ("rail", math.nan),
    ("ground", 0.0),
    ("ground", 8.0),
    ("ground", 32.0),
)
ERROR_DB = {"moving-roughness": 1.0, "moving-roughness-uncorrelated": -3.0, "full": 0.0}
COSTS = {
    "fit": 1.0,
    "transfer": 4.0,
    "receptance": 0.5,
    "moving-roughness": 0.25,
    "moving-roughness-uncorrelated": 0.25,
    "full": 2.0,
}

LAYER = {
    "shear_speed_m_s": 250.0,
    "dilatational_speed_m_s": 1470.0,
    "density_kg_m3": 1945.0,
    "loss_factor": 0.05,
}
VEHICLE = {
    "car_mass_kg": 40e3,
    "car_pitch_inertia_kg_m2": 2e6,
    "bogie_mass_kg": 5e3,
    "wheelset_mass_kg": 1800.0,
    "axle_spacing_m": 2.7,
    "bogie_spacing_m": 19.0,
    "length_m": 26.6,
    "axle_load_n": 140.1e3,
}
TRACK = {
    "form": "ballasted",
    "rail_bending_stiffness_n_m2": 12.8e6,
    "contact_width_m": 3.2,
    "sleeper_mass_kg_m": 542.0,
    "layers": [{"stiffness_n_m2": 4.64e9, "mass_kg_m": 1740.0, "loss_factor": 0.04}],
}


def _array(*dims: str, unit: str = "1") -> Any:
    return dataclasses.field(metadata={"dims": dims, "unit": unit, "description": "invented"})


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spectra:
    """The arrays of a spectra unit as the contract has them."""

    frequency: NDArray[Any] = _array("frequency", unit="Hz")
    band: NDArray[Any] = _array("band", unit="Hz")
    psd: NDArray[Any] = _array("series", "frequency")
    mean_square: NDArray[Any] = _array("series", "band")
    extrapolated_share: NDArray[Any] = _array("band")
    offset_m: NDArray[Any] = _array("series", unit="m")
    contribution: tuple[str, ...]
    quantity: tuple[str, ...]
    receiver: tuple[str, ...]
    averaging: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class Receptance:
    """The arrays of a receptance unit as the contract has them."""

    frequency: NDArray[Any] = _array("frequency", unit="Hz")
    distance: NDArray[Any] = _array("distance", unit="m")
    receptance: NDArray[Any] = _array("frequency", "distance", unit="m/N")
    inside: NDArray[Any] | None = dataclasses.field(
        default=None, metadata={"dims": ("frequency",), "unit": "", "description": "invented"}
    )


def _is_axle(receiver: tuple[str, float]) -> bool:
    return receiver[0].startswith("axle")


def mean_square(soil: int, error_db: float, receiver: int, force: bool = False) -> NDArray[Any]:
    """Return mean squares of 60 dB + 10 dB per soil − 5 dB per receiver − 0.1 dB per Hz, plus the error."""
    unit = 1.0 if force else 1e-18
    return np.asarray(unit * 10.0 ** ((60.0 + 10.0 * soil - 5.0 * receiver - 0.1 * BANDS + error_db) / 10.0))


@dataclasses.dataclass(frozen=True)
class Run:
    """What one invented run computes, and what goes wrong in it.

    Attributes
    ----------
    soils, speeds, approaches, vehicles
        Axes of the study, speeds in km/h, and the vehicles of its train.
    lost
        Approaches whose spectra fail.
    lines, narrow_band
        Lines of a spectrum, and which of them the study wants in the database.
    aliases
        Second names of things, by the first ones.
    zero_band
        Whether the lowest band of all spectra is zero.
    """

    soils: tuple[str, ...] = ("horstwalde", "greby")
    speeds: tuple[float, ...] = (150.0,)
    approaches: tuple[str, ...] = APPROACHES
    run_id: str = "run-1"
    started: str = "2026-03-01T08:00:00+00:00"
    lost: tuple[str, ...] = ()
    lines: int = 200
    narrow_band: Any = "all"
    host_class: str = "x86_64-2"
    name: str = "paper"
    zero_band: bool = False
    title: str | None = None
    aliases: Mapping[str, str] = dataclasses.field(default_factory=dict)
    vehicles: Sequence[Mapping[str, float]] = (VEHICLE,) * 4

    def names(self, name: str) -> list[str]:
        """Return the names of a thing."""
        return [name, *([self.aliases[name]] if name in self.aliases else [])]


class Study:
    """Writes runs of one study into a directory."""

    def __init__(self, directory: Path, receivers: Sequence[tuple[str, float]] = RECEIVERS) -> None:
        self.directory = directory
        self.receivers = receivers

    def write(self, **settings: Any) -> Path:
        """Write one `Run` of these settings; return the directory."""
        run = Run(**settings)
        cases = [self._case(run, number, speed) for number in range(len(run.soils)) for speed in run.speeds]
        records.Run.publish(self.directory, _manifest(run, cases))
        return self.directory

    def _case(self, run: Run, soil: int, speed: float) -> dict[str, Any]:
        """Write the units of a case, and return what the manifest holds of it."""
        for stage in ("fit", "transfer"):
            self._commit(run, stage, f"{stage}-{soil}", Receptance(*_receptance(soil, 0.0, 4)))
        case = {
            "case_id": f"case-{soil}-{speed:g}",
            "soil": run.soils[soil],
            "track": "ballasted-paper",
            "train": "grona-taget",
            "unevenness": "fra-hamid-yang-3",
            "speed_kmh": speed,
            "units": {approach: self._units(run, soil, speed, approach) for approach in run.approaches},
        }
        return {**case, "labels": _labels(run, case)}

    def _units(self, run: Run, soil: int, speed: float, approach: str) -> list[dict[str, str]]:
        """Write the units of one approach; return them with those that all approaches share."""
        load_speed = speed if approach == "full" else 0.0
        receptance = f"receptance-{soil}-{load_speed:g}"
        result: Any = Receptance(*_receptance(soil, load_speed, 100))
        self._commit(run, "receptance", receptance, result, {"speed": load_speed / 3.6})
        spectra = f"spectra-{soil}-{speed:g}-{approach}"
        if approach in run.lost:
            records.fail(self.directory, _failure(spectra, run.run_id))
        else:
            result = self._spectra(soil, approach, run.lines, run.zero_band)
            self._commit(run, "spectra", spectra, result, cost=COSTS[approach])
        return [
            *({"unit_id": f"{stage}-{soil}", "scope": "ground"} for stage in ("fit", "transfer")),
            {"unit_id": receptance, "scope": "speed" if load_speed else "ground"},
            {"unit_id": spectra, "scope": "case"},
        ]

    def _spectra(self, soil: int, approach: str, lines: int, zero_band: bool) -> Spectra:
        frequency = np.linspace(0.9, 112.0, lines)
        series = [
            (contribution, number)
            for contribution in ("dynamic", "total")
            for number in range(len(self.receivers))
        ]
        squares = np.array(
            [
                mean_square(soil, ERROR_DB[approach], number, _is_axle(self.receivers[number]))
                for _, number in series
            ]
        )
        if zero_band:
            squares[:, 0] = 0.0
        ripple = 1.0 + 0.8 * np.sin(2 * np.pi * frequency / 1.57) * (approach == "full")
        psd = np.array([np.interp(frequency, BANDS, row) / frequency * ripple for row in squares])
        receivers = [self.receivers[number] for _, number in series]
        return Spectra(
            frequency=frequency,
            band=BANDS,
            psd=psd,
            mean_square=squares,
            extrapolated_share=np.linspace(0.0, 1.0, BANDS.size),
            offset_m=np.array([offset for _, offset in receivers]),
            contribution=tuple(contribution for contribution, _ in series),
            quantity=tuple(
                "wheel_rail_force" if _is_axle(receiver) else "velocity" for receiver in receivers
            ),
            receiver=tuple(name for name, _ in receivers),
            averaging=("line",) * len(series),
        )

    def _commit(
        self,
        run: Run,
        stage: str,
        unit_id: str,
        result: Any,
        inputs: Mapping[str, Any] = MappingProxyType({}),
        cost: float | None = None,
    ) -> None:
        if records.find(self.directory, stage, unit_id):
            return
        written = group_writer.write(self.directory, f"{stage}/{unit_id}", result, {})
        cost = COSTS[stage] if cost is None else cost
        records.commit(
            self.directory,
            {
                "schema": 1,
                "unit_id": unit_id,
                "kind": stage,
                "model_version": "1",
                "inputs": dict(inputs),
                "group": written.group,
                "arrays": written.arrays,
                "status": "done",
                "worker": "worker-0",
                "host": "here",
                "host_class": run.host_class,
                "attempt": 1,
                "started": "2026-03-01T08:00:00+00:00",
                "finished": "2026-03-01T08:00:01+00:00",
                "run_id": run.run_id,
                "costs": [
                    {
                        "stage": stage,
                        "wall_s": 2 * cost,
                        "cpu_s": cost,
                        "evaluations": int(1000 * cost),
                        "kernel_calls": 3,
                        "peak_rss_bytes": 10**8,
                        "bytes_written": written.bytes_written,
                    }
                ],
            },
        )


def _failure(unit_id: str, run_id: str) -> dict[str, Any]:
    return {
        "schema": 1,
        "unit_id": unit_id,
        "kind": "spectra",
        "run_id": run_id,
        "attempt": 2,
        "worker": "worker-0",
        "host": "here",
        "status": "failed",
        "traceback": "Traceback (most recent call last):\n  ...\nArithmeticError: no <b>solution</b>\n",
        "started": "2026-03-01T08:00:00+00:00",
        "finished": "2026-03-01T08:00:01+00:00",
    }


def _manifest(run: Run, cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    wavelengths = 10.0 ** (np.arange(-4, 17) / 10.0)
    return {
        "schema": 1,
        "run_id": run.run_id,
        "study": {
            "study": {"name": run.name, **({"title": run.title} if run.title else {})},
            "output": {"narrow_band": run.narrow_band},
        },
        "study_name": run.name,
        "versions": {"numpy": "2.4"},
        "model_version": "1",
        "host": "here",
        "host_class": run.host_class,
        "threads": 1,
        "started": run.started,
        "finished": run.started,
        "exit_status": 1 if run.lost else 0,
        "cases": cases,
        "reference": "full",
        "parameters": {
            kind: {label: parameters for name, parameters in named.items() for label in run.names(name)}
            for kind, named in _parameters(run.soils, run.vehicles).items()
        },
        "axles": {name: _axles(run.vehicles) for name in run.names("grona-taget")},
        "unevenness_bands": {
            "fra-hamid-yang-3": [
                {
                    "wavelength_m": float(wavelength),
                    "mean_square_m2": 1e-7 * float(wavelength) ** 2,
                    "extrapolated_share": float(wavelength < 1.524),
                }
                for wavelength in wavelengths
            ]
        },
    }


def _parameters(soils: Sequence[str], vehicles: Sequence[Mapping[str, float]]) -> dict[str, dict[str, Any]]:
    """Return what the names of the study stand for."""
    soil = {
        name: {
            "layers": [{**LAYER, "thickness_m": 2.0}, {**LAYER, "shear_speed_m_s": 310.0 + number}],
        }
        for number, name in enumerate(soils)
    }
    return {
        "soil": soil,
        "track": {"ballasted-paper": TRACK},
        "train": {"grona-taget": {"vehicles": list(vehicles)}},
        "unevenness": {"fra-hamid-yang-3": {"form": "fra-hamid-yang", "track_class": 3}},
    }


def _labels(run: Run, case: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return every combination of the names of a case."""
    kinds = ("soil", "track", "train", "unevenness")
    return [
        {**dict(zip(kinds, names, strict=True)), "speed_kmh": case["speed_kmh"]}
        for names in product(*(run.names(case[kind]) for kind in kinds))
    ]


def _axles(vehicles: Sequence[Mapping[str, float]]) -> list[dict[str, Any]]:
    """Return the axles as the engine does, the leading one first."""
    axles: list[dict[str, Any]] = []
    front = 0.0
    for number, vehicle in enumerate(vehicles, 1):
        for bogie in (-1, 1):
            for axle in (-1, 1):
                place = front + vehicle["length_m"] / 2
                place += bogie * vehicle["bogie_spacing_m"] / 2 + axle * vehicle["axle_spacing_m"] / 2
                axles.append(
                    {"vehicle": number, "behind_first_axle_m": place, "axle_load_n": vehicle["axle_load_n"]}
                )
        front += vehicle["length_m"]
    first = axles[0]["behind_first_axle_m"]
    return [
        {**axle, "receiver": f"axle-{number}", "behind_first_axle_m": axle["behind_first_axle_m"] - first}
        for number, axle in enumerate(axles, 1)
    ]


def _receptance(soil: int, speed_kmh: float, size: int) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return a resonator's receptance at distances of -2.7, 0 and 2.7 m."""
    frequency = np.geomspace(1.0, 100.0, size)
    peak = 11.0 - speed_kmh / 75.0
    form = 5e-9 / (1.0 - (frequency / peak) ** 2 * soil + 0.4j)
    return frequency, np.array([-2.7, 0.0, 2.7]), np.stack([form * 0.5, form, form * 0.5], axis=1)
