"""Section 5: what each extra costs beside the same without it: coupling, vehicles by parts, rough wheels."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.figures import Figure, time_call
from benchmarks.sizes import Size
from railvib import library
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train, Vehicle
from railvib.parameters.wheel_roughness import WheelRoughness
from railvib.stages.graph import case_spectra, evaluate
from railvib.transfer.tabulate import transfer_blocks

SECTION = "extras"
SOIL = "greby"
BLOCK = 2
"""Half a decade from 11 to 35 Hz."""
RECEIVERS = RAIL, Receiver(8.0), Receiver(32.0)
FREQUENCIES = 1000
SPEED_KMH = 150.0
BAND = tuple(10.0 ** (number / 10.0) for number in range(10, 15))
ORDERS = WheelRoughness(form="orders", order_level=(26.0, 20.0, 16.5, 14.0, 12.0, 10.5))


def measure(size: Size) -> Iterator[Figure]:
    """Yield CPU times with and without each extra, and their ratios."""
    yield from _coupling(size)
    yield from _vehicles(size)
    yield from _wheels(size)


def _coupling(size: Size) -> Iterator[Figure]:
    """Yield times of the tables of half a decade for both couplings."""
    ground = library.load("soil", SOIL)
    seconds = {}
    for name in ("ballasted-paper", "ballasted-mean"):
        track = library.load("track", name)
        timing = time_call(partial(transfer_blocks, ground, track, BLOCK, RECEIVERS), size.samples)
        seconds[name] = timing.cpu
        yield Figure(SECTION, "tables of half a decade", name, "cpu", "s", timing.cpu_s)
    ratio = seconds["ballasted-mean"] / seconds["ballasted-paper"]
    yield Figure(SECTION, "tables of half a decade", "coupling", "mean over centre", "1", (ratio,))


def _vehicles(size: Size) -> Iterator[Figure]:
    """Yield times per frequency of the receptances of vehicles in closed form and by parts."""
    omega = 2.0 * np.pi * np.geomspace(1.0, 100.0, FREQUENCIES)
    for name in ("regina", "freight-y25-loaded", "eurostar-half"):
        kind: Any = "train" if name == "eurostar-half" else "vehicle"
        thing = library.load(kind, name)
        train = thing if isinstance(thing, Train) else Train(vehicles=(thing,))
        block = train.blocks[-1]
        timing = time_call(partial(block.flexibilities, omega), size.samples)
        form = "closed form" if isinstance(block, Vehicle) else f"by parts, {block.axle_count} axles"
        cpu = tuple(time_s / FREQUENCIES for time_s in timing.cpu_s)
        yield Figure(SECTION, "receptances per frequency", f"{name}, {form}", "cpu", "s", cpu)


def _wheels(size: Size) -> Iterator[Figure]:
    """Yield times of the spectra of a case with smooth and with rough wheels, its tables known."""
    smooth = library.load("train", "grona-taget")
    rough = Train(
        vehicles=tuple(vehicle.model_copy(update={"wheel_roughness": ORDERS}) for vehicle in smooth.vehicles)
    )
    for approach in ("moving-roughness", "full"):
        seconds = {}
        for name, train in (("smooth", smooth), ("rough", rough)):
            stage = case_spectra(
                approach,
                ground=library.load("soil", SOIL),
                track=library.load("track", "ballasted-paper"),
                train=train,
                unevenness=library.load("unevenness", "fra-hamid-yang-3"),
                speed=SPEED_KMH / KMH,
                band=BAND,
                receivers=RECEIVERS,
                averaging=("line",),
                tolerance=1e-4,
                cross_section=CrossSection(),
            )
            results = evaluate([stage])
            timing = time_call(partial(stage.compute, results.__getitem__), size.samples)
            seconds[name] = timing.cpu
            yield Figure(SECTION, f"spectra by {approach}", f"{name} wheels", "cpu", "s", timing.cpu_s)
        ratio = seconds["rough"] / seconds["smooth"]
        yield Figure(SECTION, f"spectra by {approach}", "wheels", "rough over smooth", "1", (ratio,))
