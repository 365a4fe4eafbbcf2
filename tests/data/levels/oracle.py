"""Writes the columns of this folder that are computed, beside those that standards print.

Run from the top of the repository: ``python -m tests.data.levels.oracle``.

Nothing of railvib is used. A filter is the sum of its poles' responses, each of which is exact in time for
input that is linear between samples; railvib multiplies spectra instead. What is printed stands in the files
and is left as it is: ISO 8041-1:2017 annex B and table 8, DIN 45669-1:2010 table 9 and, as corrected in 2012,
table 8, DIN 4150-2:1999 examples C.8 and D.1. din_examples.csv holds printed numbers only, with their source.
"""

import csv
import math
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

FOLDER = Path(__file__).parent
TABLE_3 = {
    "Wb": (0.4, 100.0, 16.0, 0.55, (2.5, 0.9, 4.0, 0.95), 1.024),
    "Wd": (0.4, 100.0, 2.0, 0.63, None, 1.0),
    "Wk": (0.4, 100.0, 12.5, 0.63, (2.37, 0.91, 3.35, 0.91), 1.0),
    "Wm": (10.0**-0.1, 100.0, 1.0 / (2.0 * math.pi * 0.028), 0.5, None, 1.0),
}
"""f₁, f₂, f₃ = f₄, Q₄, f₅, Q₅, f₆, Q₆ and K of ISO 8041-1:2017."""


class Filter:
    """Zeros and poles in Hz, and the gain."""

    def __init__(self, zeros=(), poles=(), gain=1.0):
        self.zeros, self.poles, self.gain = np.array(zeros, complex), np.array(poles, complex), gain

    def __mul__(self, other):
        zeros, poles = list(np.append(self.zeros, other.zeros)), list(np.append(self.poles, other.poles))
        for zero in tuple(zeros):  # Wm: the transition's zero is one of its two equal poles
            match = [pole for pole in poles if abs(pole - zero) < 1e-6]
            if match:
                zeros.remove(zero)
                poles.remove(match[0])
        return Filter(zeros, poles, self.gain * other.gain)

    def at(self, frequency):
        s = 1j * np.atleast_1d(frequency)[:, None]
        return self.gain * np.prod(s - self.zeros, axis=1) / np.prod(s - self.poles, axis=1)

    def __call__(self, signal, step):
        out = np.zeros(signal.size, complex)
        for i, pole in enumerate(self.poles):
            residue = self.gain * np.prod(pole - self.zeros) / np.prod(pole - np.delete(self.poles, i))
            x = 2.0 * math.pi * pole * step
            decay, mean = np.exp(x), np.expm1(x) / x
            weights = np.array([mean - 1.0, decay - mean]) / pole
            out += residue * lfilter(weights, [1.0, -decay], signal.astype(complex))
        return out.real


def pair(frequency, quality):
    return np.roots([1.0, frequency / quality, frequency**2])


def band(low, high):
    poles = [*pair(low, math.sqrt(0.5)), *pair(high, math.sqrt(0.5))]
    return Filter([0.0, 0.0], poles, high**2)


def iso_8041(name):
    f1, f2, f4, q4, step, gain = TABLE_3[name]
    made = band(f1, f2) * Filter([-f4], pair(f4, q4), gain * f4)
    if step is not None:
        f5, q5, f6, q6 = step
        made = made * Filter(pair(f5, q5), pair(f6, q6))
    return made


CORNER = Filter([0.0], [-5.6])
KB = {"KB_1_80": band(0.8, 100.0) * CORNER, "KB_4_315": band(3.2, 393.75) * CORNER, "KB_bare": CORNER}


def running(square, step, time_constant):
    decay = math.exp(-step / time_constant)
    return lfilter([1.0 - decay], [1.0, -decay], square)


def weightings(rows):
    for row in rows:
        f = 10.0 ** (int(row["n"]) / 10.0)
        row["frequency_hz"] = f"{f:.10g}"
        for name in TABLE_3:
            value = complex(iso_8041(name).at(f)[0])
            row[name] = f"{abs(value):.10g}"
            row[f"{name}_phase_deg"] = f"{math.degrees(math.atan2(value.imag, value.real)):.10g}"
        for name, made in KB.items():
            row[name] = f"{abs(complex(made.at(f)[0])):.10g}"
        row["Wm_velocity"] = f"{abs(complex(iso_8041('Wm').at(f)[0])) * 2.0 * math.pi * f * 0.028:.10g}"


def sawtooth(cycles, samples, duration):
    """Return a burst of ISO 8041-1:2017 table 6 and figure 3, and its step in s.

    Samples lie half a step beside zeros and falls, so that a fall between two of them is where it belongs.
    """
    step = 2.0 * math.pi / 100.0 / samples
    passed = (np.arange(round(duration / step)) + 0.5) / samples
    return np.where(passed < cycles, 2.0 * np.mod(passed + 0.5, 1.0) - 1.0, 0.0), step


def bursts(rows):
    bursts_in_a_minute = 6
    for row in rows:
        name = row["weighting"]
        made = band(0.4, 100.0) if name == "band" else iso_8041(name)
        signal, step = sawtooth(int(row["cycles"]), 1500, 10.0)
        a = made(signal, step)
        energy = np.cumsum(a**2) * step
        window = round(1.0 / step)
        row["oracle"] = {
            "rms": math.sqrt(bursts_in_a_minute * energy[-1] / 60.0),
            "VDV": (bursts_in_a_minute * np.sum(a**4) * step) ** 0.25,
            "MTVV_linear": math.sqrt(np.max(energy[window:] - energy[:-window])),
            "MTVV_exponential": math.sqrt(running(a**2, step, 1.0).max()),
        }[row["quantity"]]
        row["oracle"] = f"{row['oracle']:.6g}"


def kb_f(signal, step):
    return np.sqrt(running(KB["KB_1_80"](signal, step) ** 2, step, 0.125))


def din(rows):
    step = 1.0 / 80_000.0
    t = np.arange(round(8.0 / step)) * step
    late = t >= 4.0
    continuous = kb_f(np.sin(2.0 * math.pi * 80.0 * t), step)[late].mean()
    first, second = np.array([0.92, 0.6, 0.9]), np.array([0.2, 0.24])
    examples = {
        "4150-2 C.8 class 1 KB_FTm": np.mean(first**2),
        "4150-2 C.8 class 2 KB_FTm": np.mean(second**2),
        "4150-2 C.8 KB_FTr": (288 * np.mean(first**2) + 192 * np.mean(second**2)) / 1920,
        "4150-2 C.8 20 Takte KB_FTm": (np.sum(first**2) + np.sum(second**2)) / 20,
        "4150-2 D.1 7 trains/h at 0.2": 7 * 16 * 0.2**2 / 1920,
    }
    for row in rows:
        if row["case"] == "sine":
            shown = kb_f(np.sin(2.0 * math.pi * float(row["argument"]) * t), step)[late]
            value = shown.max() if row["quantity"] == "KB_Fmax" else shown.mean()
        elif row["case"] == "burst_80Hz":
            gate = np.mod(t, 1.0) < float(row["argument"]) / 1e3
            shown = kb_f(np.sin(2.0 * math.pi * 80.0 * t) * gate, step)[late]
            value = 100.0 * shown.max() / continuous
        else:
            value = math.sqrt(examples[row["case"]])
        row["oracle"] = f"{value:.6g}"


def units_and_lines(rows):
    micro_inch, force_density = 2.54e-8, 4.4482216152605 / math.sqrt(0.3048)
    lengths = {"h = 2.5 m": 2.5, "h = 5 m": 5.0, "h = 10 m": 10.0, "h = 25 m": 25.0}
    values = [
        20.0 * math.log10(micro_inch / 1e-9),
        20.0 * math.log10(5e-8 / 1e-9),
        20.0 * math.log10(micro_inch / 5e-8),
        force_density,
        20.0 * math.log10(force_density),
        20.0 * math.log10(micro_inch / 1e-9 / force_density),
        20.0 * math.log10(micro_inch / 1e-9 / 4.4482216152605),
        10.0 * math.log10(2.0 / 20.0 * math.atan(50.0 / 20.0)),
    ]
    for spacing in lengths.values():
        x = np.arange(-50.0, 50.0 + 0.5 * spacing, spacing)
        energy = 1.0 / (x**2 + 400.0)
        values.append(10.0 * math.log10(spacing * (energy.sum() - 0.5 * (energy[0] + energy[-1]))))
    values.append(10.0 * math.log10(math.pi / 20.0))
    for row, value in zip(rows, values, strict=True):
        row["value"] = f"{value:.10g}"


if __name__ == "__main__":
    files = {
        "weightings": weightings,
        "iso8041_bursts": bursts,
        "din": din,
        "units_and_lines": units_and_lines,
    }
    for name, write in files.items():
        path = FOLDER / f"{name}.csv"
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        write(rows)
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
