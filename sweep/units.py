"""What railvib computes, as units of work: per kind its inputs, what it needs, and what computes it.

Everything a result depends on is in a unit's inputs, so that the computing below starts from them alone. What
a unit needs follows from its inputs as well: from the frequencies of a study to the canonical blocks that
cover them.
"""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from railvib import library
from railvib.errors import InputError, PlausibilityWarning
from railvib.fe_be.boundary_elements import receiver_flexibility, strip_flexibility
from railvib.forces.moving_transfer import MovingTransfer, moving_transfer
from railvib.forces.receptance import Receptances, highest_tabulated_frequency, tabulated_receptances
from railvib.forces.wheel_rail import axle_distances
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import third_octaves
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from railvib.plausibility import check_damping, check_speed
from railvib.psd.full_model import RECEIVERS_AT_ONCE
from railvib.psd.line_integrals import LineIntegrals, line_integrals
from railvib.psd.quasi_static import QuasiStatic, highest_left, quasi_static_spectra
from railvib.psd.spectra import LINES_AT_ONCE, Spectra, highest_excitation, line_step, lines, spectra
from railvib.psd.train_average import TrainIntegrals, train_integrals
from railvib.soil.tensor_fit import fit_tensor
from railvib.transfer.intensity import squares
from railvib.transfer.table import TransferBlock, TransferFunction
from railvib.transfer.tabulate import (
    MOST_LEVELS,
    VALUES_AT_ONCE,
    distance_class,
    largest_wavenumber,
    transfer_blocks_by_class,
)
from sweep import identity
from sweep.identity import Canonical
from sweep.kinds import AccuracyWarning, Inputs, Kind, Load, Unit
from sweep.study import Case, Resolved
from sweep.workers import compiling

RAIL = "rail"
STANDING = 0.0
REMEMBERED = 4096
"""Units that planning keeps at hand, as many cases share them."""
FE_BE_BYTES = 128 * 2**20
"""75 MB were measured with eight strips and three rows of elements."""
PANELS_PER_RAD_M = 3.0
"""Of the full model's excitation: 1 to 3 were found, fewest on damped soil."""
SURVIVING = 8.0
"""Wavelengths times loss factor after which tables grow no more with distance: e^{−8π} is left of a wave."""
FLOAT, COMPLEX = 8, 16
"""Bytes of a number."""


def spectra_unit(resolved: Resolved, case: Case, approach: str) -> Unit:
    """Return the unit of one case by one approach."""
    study = resolved.study
    return Unit.of(
        "spectra",
        approach=approach,
        ground=resolved.canonical["soil"][case.soil],
        track=resolved.canonical["track"][case.track],
        train=resolved.canonical["train"][case.train],
        unevenness=resolved.canonical["unevenness"][case.unevenness],
        speed=case.speed_kmh / KMH,
        band=third_octaves.midbands(study.frequency.minimum_hz, study.frequency.maximum_hz).tolist(),
        receivers=([RAIL] if study.receivers.rail else []) + sorted(set(study.receivers.offsets_m)),
        # A full pass-by is one thing: only the moving roughness can be averaged over the train as well.
        averaging=["line"] if approach == "full" else sorted(set(study.approaches.averaging)),
        tolerance=study.accuracy.tolerance,
        **({"cross_section": study.cross_section} if approach == "fe-be" else {}),
    )


class _Model(NamedTuple):
    """What the transfer functions of a unit follow from; with a cross-section by the FE/BE model."""

    ground: Canonical
    track: Canonical
    tolerance: float
    cross_section: Canonical | None

    @property
    def inputs(self) -> dict[str, Any]:
        """The inputs of a unit of this model."""
        return {name: value for name, value in self._asdict().items() if value is not None}


def _model(inputs: Inputs) -> _Model:
    return _Model(inputs["ground"], inputs["track"], inputs["tolerance"], inputs.get("cross_section"))


@lru_cache(REMEMBERED)
def _transfer_units(model: _Model, receiver: str | float, which: range) -> tuple[Unit, ...]:
    """Return the units of one receiver's transfer function over some blocks."""
    return tuple(
        Unit.of("transfer", block=block, receiver=receiver, **model.inputs)
        for block in reversed(which)  # the highest first: it takes longest
    )


@lru_cache(REMEMBERED)
def _receptance_unit(model: _Model, train: Canonical, speed: float, which: range) -> Unit:
    """Return the unit of the rail's receptances at a speed over some blocks, for the axles of a train."""
    return Unit.of(
        "receptance",
        speed=speed,
        distances=train_axles(train).distances,
        blocks=tuple(which),
        **model.inputs,
    )


@lru_cache(REMEMBERED)
def _moving_unit(model: _Model, speed: float, which: range) -> Unit:
    """Return the unit of the rail's transfer function for loads at a speed, over some blocks."""
    return Unit.of("moving_transfer", speed=speed, blocks=tuple(which), **model.inputs)


def _quasi_static_unit(inputs: Inputs) -> Unit:
    """Return the unit of the response to the axle loads of a case, which its approaches share."""
    axles = train_axles(inputs["train"])
    return Unit.of(
        "quasi_static",
        receivers=inputs["receivers"],
        band=inputs["band"],
        step=line_step(axles.train_length, inputs["speed"]),
        speed=inputs["speed"],
        train_length=axles.train_length,
        axle_position=axles.position,
        axle_load=axles.load,
        **_model(inputs).inputs,
    )


@lru_cache(REMEMBERED)
def _line_integral_unit(model: _Model, train: Canonical, receiver: str | float, which: range) -> Unit:
    """Return the unit of one receiver's line integrals over some blocks, for the axles of a train."""
    return Unit.of(
        "line_integrals",
        receiver=receiver,
        distances=tuple(each for each in train_axles(train).distances if each >= 0.0),
        blocks=tuple(which),
        **model.inputs,
    )


def _train_integral_unit(inputs: Inputs, receiver: str | float) -> Unit:
    """Return the unit of one receiver's integrals over the train on the narrow-band lines of a case."""
    axles = train_axles(inputs["train"])
    return Unit.of(
        "train_integrals",
        receiver=receiver,
        band=inputs["band"],
        step=line_step(axles.train_length, inputs["speed"]),
        axle_position=axles.position,
        **_model(inputs).inputs,
    )


class _Axles(NamedTuple):
    """What the units of a train depend on: lengths in m, positions from the last axle, loads in N."""

    train_length: float
    position: tuple[float, ...]
    load: tuple[float, ...]
    distances: tuple[float, ...]


@lru_cache(REMEMBERED)
def train_axles(train: Canonical) -> _Axles:
    """Return what the units of a train depend on."""
    made = Train(**train)
    position = np.round(made.axle_positions - made.axle_positions[0], 9)
    return _Axles(
        made.length,
        tuple(position.tolist()),
        tuple(made.axle_loads.tolist()),
        tuple(axle_distances(made).tolist()),
    )


@lru_cache(REMEMBERED)
def covering(band: tuple[float, ...]) -> range:
    """Return the blocks that cover one-third octaves; lines just beyond the last edge lie in its halo."""
    lower, upper = third_octaves.edges(band)
    return blocks.covering(float(lower[0]), float(upper[-1]))


def _transfer(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, TransferBlock]]:
    first = units[0].inputs
    ground, track, block = Ground(**first["ground"]), Track(**first["track"]), int(first["block"])
    asked = {unit.inputs["receiver"]: unit for unit in units}
    if "cross_section" in first:
        from railvib.fe_be.model import FeBeModel  # brings a finite-element library

        warm_up_fe_be()
        model = FeBeModel(ground, track, CrossSection(**first["cross_section"]), block)
    else:
        model = None
    for made in transfer_blocks_by_class(ground, track, block, asked, first["tolerance"], evaluation=model):
        for table in made.values():
            shortfall = table.shortfall(first["tolerance"])
            if shortfall:
                warnings.warn(shortfall, AccuracyWarning, stacklevel=1)
        yield {asked[receiver]: table for receiver, table in made.items()}


def _receptance_needs(inputs: Inputs) -> tuple[Unit, ...]:
    which = _between(inputs["blocks"])
    if "cross_section" in inputs:  # loads stand, and a table's halo reaches as far as the receptances'
        return _transfer_units(_model(inputs), RAIL, which)
    track = Track(**inputs["track"])
    highest = highest_tabulated_frequency(track, blocks.reach(which[-1]), inputs["speed"])
    return _transfer_units(_model(inputs), RAIL, blocks.up_to(highest))


def _receptance(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, Receptances]]:
    for unit in units:
        inputs = unit.inputs
        track = Track(**inputs["track"])
        yield {
            unit: tabulated_receptances(
                TransferFunction([load(need) for need in _receptance_needs(inputs)], track),
                track,
                inputs["speed"],
                inputs["distances"],
                _between(inputs["blocks"]),
                inputs["tolerance"],
            )
        }


def _between(which: Sequence[int]) -> range:
    """Return blocks that follow one another as the range that they were, before they became canonical."""
    return range(int(which[0]), int(which[-1]) + 1)


def _moving_transfer(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, MovingTransfer]]:
    for unit in units:
        inputs = unit.inputs
        needs = [load(need) for need in _receptance_needs(inputs)]
        rail = TransferFunction(needs, Track(**inputs["track"]))
        yield {unit: moving_transfer(rail, inputs["speed"], _between(inputs["blocks"]))}


def _receiver_units(inputs: Inputs, receiver: str | float) -> tuple[Unit, ...]:
    """Return the units of one receiver's transfer function that cover a unit's one-third octaves."""
    return _transfer_units(_model(inputs), receiver, covering(inputs["band"]))


def _transfer_function(inputs: Inputs, receiver: str | float, load: Load) -> TransferFunction:
    """Return one receiver's transfer function over a unit's one-third octaves."""
    table = [load(need) for need in _receiver_units(inputs, receiver)]
    return TransferFunction(table, Track(**inputs["track"]))


class _Receivers(Mapping[str | float, TransferFunction]):
    """The transfer functions of some receivers from their units, loaded each time that one is asked for.

    Tables of a hundred receivers take more memory than a worker has: whoever goes through them one by one
    holds one at a time, beside what the worker keeps at hand.
    """

    def __init__(self, tables: Mapping[str | float, Sequence[Unit]], track: Canonical, load: Load) -> None:
        self._tables = tables
        self._track = Track(**track)
        self._load = load

    def __getitem__(self, receiver: str | float) -> TransferFunction:
        return TransferFunction([self._load(unit) for unit in self._tables[receiver]], self._track)

    def __iter__(self) -> Iterator[str | float]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)


def _integral_needs(inputs: Inputs) -> tuple[Unit, ...]:
    return _receiver_units(inputs, inputs["receiver"])


def _quasi_static_tables(inputs: Inputs) -> dict[str | float, tuple[Unit, ...]]:
    """Return the units of every receiver's transfer function as far up as something is left of it."""
    ground, track = Ground(**inputs["ground"]), Track(**inputs["track"])
    lower, upper = third_octaves.edges(inputs["band"])
    tables = {}
    for receiver in inputs["receivers"]:
        highest = highest_left(ground, track, receiver, inputs["speed"])
        # One block at least: a transfer function without any knows not even that it is zero.
        which = blocks.covering(float(lower[0]), float(min(upper[-1], max(highest, upper[0]))))
        tables[receiver] = _transfer_units(_model(inputs), receiver, which)
    return tables


def _quasi_static_needs(inputs: Inputs) -> list[Unit]:
    return [unit for units in _quasi_static_tables(inputs).values() for unit in units]


def _line_integral_needs(inputs: Inputs) -> tuple[Unit, ...]:
    return _transfer_units(_model(inputs), inputs["receiver"], _between(inputs["blocks"]))


def _line_integrals(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, LineIntegrals]]:
    first = units[0].inputs
    track = Track(**first["track"])
    classes: dict[float, dict[str | float, Unit]] = {}
    for unit in units:
        receiver = unit.inputs["receiver"]
        classes.setdefault(distance_class(receiver), {})[receiver] = unit
    for asked in classes.values():  # receivers of one class share their nodes, and so their costs
        for i in range(0, len(asked), RECEIVERS_AT_ONCE):
            receivers = {
                each: TransferFunction([load(need) for need in _line_integral_needs(unit.inputs)], track)
                for each, unit in list(asked.items())[i : i + RECEIVERS_AT_ONCE]
            }
            made = line_integrals(
                receivers, first["distances"], _between(first["blocks"]), first["tolerance"]
            )
            yield {asked[receiver]: table for receiver, table in made.items()}


def _quasi_static(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, QuasiStatic]]:
    for unit in units:
        inputs = unit.inputs
        f = narrow_lines(inputs)
        made = quasi_static_spectra(
            _Receivers(_quasi_static_tables(inputs), inputs["track"], load),
            np.asarray(inputs["axle_position"]),
            np.asarray(inputs["axle_load"]),
            inputs["train_length"],
            inputs["speed"],
            f,
        )
        yield {unit: QuasiStatic(f, np.array([made[each] for each in inputs["receivers"]]))}


def _train_integrals(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, TrainIntegrals]]:
    warm_up_train_average()
    for unit in units:
        inputs = unit.inputs
        receiver = _transfer_function(inputs, inputs["receiver"], load)
        yield {unit: train_integrals(receiver, np.asarray(inputs["axle_position"]), narrow_lines(inputs))}


def narrow_lines(inputs: Inputs) -> NDArray[np.float64]:
    """Return the narrow-band lines of a unit that states their step."""
    return lines(np.asarray(inputs["band"]), inputs["step"])


def excited_up_to(inputs: Inputs) -> float:
    """Return the highest frequency of excitation that a full model counts, Hz."""
    return highest_excitation(
        np.asarray(inputs["band"]), largest_wavenumber(Track(**inputs["track"])), inputs["speed"]
    )


def _spectra_rail(inputs: Inputs) -> Unit:
    """Return the receptances that an approach rests on: moving for the full model, else standing."""
    if inputs["approach"] == "full":
        speed, which = inputs["speed"], blocks.up_to(excited_up_to(inputs))
    else:
        speed, which = STANDING, covering(inputs["band"])
    return _receptance_unit(_model(inputs), inputs["train"], speed, which)


def _line_integrals_of(inputs: Inputs, receiver: str | float) -> Unit:
    """Return the line integrals of one receiver that a case by the moving roughness rests on."""
    return _line_integral_unit(_model(inputs), inputs["train"], receiver, covering(inputs["band"]))


def _spectra_needs(inputs: Inputs) -> list[Unit]:
    needs = [_spectra_rail(inputs), _quasi_static_unit(inputs)]
    if inputs["approach"] == "full":  # the transfer function behind its receptances, which a run shows
        needs.append(_moving_unit(_model(inputs), inputs["speed"], blocks.up_to(excited_up_to(inputs))))
        for receiver in inputs["receivers"]:
            needs += _receiver_units(inputs, receiver)
    else:
        needs += [_line_integrals_of(inputs, receiver) for receiver in inputs["receivers"]]
    if "train" in inputs["averaging"]:
        needs += [_train_integral_unit(inputs, receiver) for receiver in inputs["receivers"]]
    return needs


def _spectra(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, Spectra]]:
    for unit in units:
        inputs = unit.inputs
        full = inputs["approach"] == "full"
        receivers = inputs["receivers"]
        still = load(_quasi_static_unit(inputs)).psd
        yield {
            unit: spectra(
                inputs["approach"],
                Train(**inputs["train"]),
                Unevenness(**inputs["unevenness"]),
                inputs["speed"],
                np.asarray(inputs["band"]),
                load(_spectra_rail(inputs)),
                dict(zip(receivers, still, strict=True)),
                _Receivers({each: _receiver_units(inputs, each) for each in receivers}, inputs["track"], load)
                if full
                else None,
                None if full else {each: load(_line_integrals_of(inputs, each)) for each in receivers},
                excited_up_to(inputs) if full else None,
                {each: load(_train_integral_unit(inputs, each)) for each in receivers}
                if "train" in inputs["averaging"]
                else None,
                inputs["tolerance"],
            )
        }


def _together(*names: str) -> Callable[[Inputs], str]:
    """Return the function that puts units into one task which agree in the inputs of these names."""
    return lambda inputs: identity.digest({name: inputs[name] for name in names if name in inputs})


def _label(inputs: Inputs) -> str:
    """Return what tells a unit's receiver from others."""
    receiver = inputs["receiver"]
    return RAIL if receiver == RAIL else repr(float(receiver)).removesuffix(".0")


def waves_between(inputs: Inputs) -> float:
    """Return how many wavelengths lie between track and receiver at a block's highest frequency, at most.

    No more than leave something of a wave in the layer that damps least.
    """
    distance = 0.0 if inputs["receiver"] == RAIL else inputs["receiver"]
    highest = float(blocks.edges(int(inputs["block"]))[1])
    slowest, surviving = _slowest_and_surviving(inputs["ground"])
    return min(distance * highest / slowest, surviving)


@lru_cache(REMEMBERED)
def _slowest_and_surviving(ground: Canonical) -> tuple[float, float]:
    """Return the speed of a ground's slowest wave, and the wavelengths after which nothing is left of it."""
    made = Ground(**ground)
    return made.slowest_speed, SURVIVING / max(min(layer.loss_factor for layer in made.layers), 1e-3)


def _transfer_rows(inputs: Inputs) -> int:
    """Estimate the frequencies of a table: the level that so many waves take."""
    waves = waves_between(inputs)
    level = min(max(math.ceil(math.log2(max(waves, 1.0) / 4.0)), 0), MOST_LEVELS)
    return int(blocks.indices(int(inputs["block"]), level).size)


def _transfer_bytes(inputs: Inputs) -> int:
    """Estimate a table: frequencies by nodes."""
    nodes = 400 + 10 * waves_between(inputs)
    return int(_transfer_rows(inputs) * nodes * (COMPLEX + FLOAT))


def _transfer_memory(inputs: Inputs) -> int:
    """Estimate what tabulating takes; the FE/BE model holds its bed and the matrices of many wavenumbers."""
    return 4 * _transfer_bytes(inputs) + (FE_BE_BYTES if "cross_section" in inputs else 0)


def _receptance_bytes(inputs: Inputs) -> int:
    rows = sum(blocks.indices(block, 1).size for block in _between(inputs["blocks"]))
    return rows * len(inputs["distances"]) * COMPLEX


def _moving_bytes(inputs: Inputs) -> int:
    return len(inputs["blocks"]) * blocks.STEPS * 2 * 200 * (COMPLEX + FLOAT)


def _line_integral_bytes(inputs: Inputs) -> int:
    rows = sum(_transfer_rows({**inputs, "block": block}) for block in inputs["blocks"])
    return rows * len(inputs["distances"]) * FLOAT


def _line_integral_memory(inputs: Inputs) -> int:
    tables = sum(_transfer_bytes({**inputs, "block": block}) for block in inputs["blocks"])
    return 2 * tables + 4 * _line_integral_bytes(inputs)


def _quasi_static_bytes(inputs: Inputs) -> int:
    return narrow_lines(inputs).size * (1 + len(inputs["receivers"])) * FLOAT


def _train_integral_bytes(inputs: Inputs) -> int:
    return narrow_lines(inputs).size * len(inputs["axle_position"]) ** 2 * COMPLEX


def _spectra_bytes(inputs: Inputs) -> int:
    axles = train_axles(inputs["train"])
    series = len(axles.position) + 3 * len(inputs["receivers"]) * len(inputs["averaging"])
    return series * (line_count(inputs) + len(inputs["band"])) * FLOAT


def line_count(inputs: Inputs) -> int:
    """Return how many narrow-band lines the spectra of a case have."""
    step = line_step(train_axles(inputs["train"]).train_length, inputs["speed"])
    return int(lines(np.asarray(inputs["band"]), step).size)


def excitation_count(inputs: Inputs) -> int:
    """Return at how many wavenumbers the full model needs forces, about: some panels per rad/m."""
    largest = 2.0 * math.pi * excited_up_to(inputs) / inputs["speed"]
    return int(math.ceil(PANELS_PER_RAD_M * largest)) * ORDER


def matrices_memory(inputs: Inputs) -> int:
    """Estimate what the matrices of axles take at the lines that are computed together."""
    axles = len(train_axles(inputs["train"]).position)
    return 6 * LINES_AT_ONCE * axles**2 * COMPLEX


def _tables_memory(inputs: Inputs) -> int:
    """Estimate what the tables of the receivers held together take, and what is derived from them."""
    of_receivers = sorted(
        sum(_transfer_bytes(unit.inputs) for unit in _receiver_units(inputs, receiver))
        for receiver in inputs["receivers"]
    )
    return 2 * sum(of_receivers[-RECEIVERS_AT_ONCE:])


def _spectra_memory(inputs: Inputs) -> int:
    """Estimate what the tables of receivers and the matrices of all lines take."""
    return (_tables_memory(inputs) if inputs["approach"] == "full" else 0) + matrices_memory(inputs)


KINDS: dict[str, Kind] = {
    "transfer": Kind(
        result=TransferBlock,
        scope=lambda inputs: "ground",
        needs=lambda inputs: (),
        together=_together(*_Model._fields, "block"),
        compute=_transfer,
        size=_transfer_bytes,
        memory=_transfer_memory,
        at_once=VALUES_AT_ONCE,
        label=lambda inputs: None if inputs["receiver"] == RAIL else _label(inputs),
    ),
    "receptance": Kind(
        result=Receptances,
        scope=lambda inputs: "speed" if inputs["speed"] else "ground",
        needs=_receptance_needs,
        together=identity.digest,
        compute=_receptance,
        size=_receptance_bytes,
        memory=lambda inputs: 8 * _receptance_bytes(inputs),
    ),
    "moving_transfer": Kind(
        result=MovingTransfer,
        scope=lambda inputs: "speed",
        needs=_receptance_needs,
        together=identity.digest,
        compute=_moving_transfer,
        size=_moving_bytes,
        memory=lambda inputs: 4 * _moving_bytes(inputs),
    ),
    "line_integrals": Kind(
        result=LineIntegrals,
        scope=lambda inputs: "ground",
        needs=_line_integral_needs,
        together=_together(*_Model._fields, "distances", "blocks"),
        compute=_line_integrals,
        size=_line_integral_bytes,
        memory=_line_integral_memory,
        at_once=RECEIVERS_AT_ONCE,
        label=_label,
    ),
    "quasi_static": Kind(
        result=QuasiStatic,
        scope=lambda inputs: "speed",
        needs=_quasi_static_needs,
        together=identity.digest,
        compute=_quasi_static,
        size=_quasi_static_bytes,
        memory=_tables_memory,
    ),
    "train_integrals": Kind(
        result=TrainIntegrals,
        scope=lambda inputs: "ground",
        needs=_integral_needs,
        together=_together(*_Model._fields, "receiver", "axle_position", "step", "band"),
        compute=_train_integrals,
        size=_train_integral_bytes,
        memory=lambda inputs: 2 * _train_integral_bytes(inputs),
    ),
    "spectra": Kind(
        result=Spectra,
        scope=lambda inputs: "case",
        needs=_spectra_needs,
        together=identity.digest,
        compute=_spectra,
        size=_spectra_bytes,
        memory=_spectra_memory,
    ),
}


def check_plausibility(resolved: Resolved) -> None:
    """Refuse soils without damping.

    Raises
    ------
    InputError
        Naming the soil and the layer.
    """
    for name, ground in resolved.objects["soil"].items():
        assert isinstance(ground, Ground)
        try:
            check_damping(ground)
        except InputError as error:
            raise InputError(f"soil.{name}.{error}") from None


def cautions(resolved: Resolved) -> list[str]:
    """Return where the fastest train outruns waves in ground and track; this takes compiled kernels."""
    fastest = max(resolved.study.sweep.speed_kmh) / KMH
    found = []
    for name, ground in resolved.objects["soil"].items():
        assert isinstance(ground, Ground)
        for other, track in resolved.objects["track"].items():
            assert isinstance(track, Track)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", PlausibilityWarning)
                check_speed(ground, track, fastest)
            found += [f"{name}, {other}: {each.message}" for each in caught]
    return found


def unevenness_bands(resolved: Resolved) -> dict[str, list[dict[str, float]]]:
    """Return the one-third octaves over wavelength of every unevenness, as far as the study excites them."""
    study = resolved.study
    speeds = [speed / KMH for speed in study.sweep.speed_kmh]
    shortest, longest = min(speeds) / study.frequency.maximum_hz, max(speeds) / study.frequency.minimum_hz
    return {
        name: [
            {
                "wavelength_m": float(wavelength),
                "mean_square_m2": float(mean_square),
                "extrapolated_share": float(share),
            }
            for wavelength, mean_square, share in zip(
                *unevenness.third_octaves(shortest, longest), strict=True
            )
        ]
        for name, unevenness in resolved.objects["unevenness"].items()
        if isinstance(unevenness, Unevenness)
    }


def rayleigh_speeds(resolved: Resolved) -> dict[str, list[float]]:
    """Return the Rayleigh speed of each layer's material by soil, m/s; the results know no physics."""
    return {
        name: [layer.rayleigh_speed for layer in ground.layers]
        for name, ground in resolved.objects["soil"].items()
        if isinstance(ground, Ground)
    }


@cache
def warm_up() -> None:
    """Compile every kernel, or load it where that has been done: a small case, kept nowhere."""
    results: dict[Unit, Any] = {}

    def load(unit: Unit) -> Any:
        if unit not in results:
            results.update(next(KINDS[unit.kind].compute([unit], load)))
        return results[unit]

    for approach in ("moving-roughness", "full"):
        load(
            Unit.of(
                "spectra",
                approach=approach,
                ground=library.load("soil", "horstwalde"),
                track=library.load("track", "ballasted-paper"),
                train=Train(vehicles=(library.load("vehicle", "regina"),)),
                unevenness=library.load("unevenness", "german-low"),
                speed=1.0,
                band=[0.1],
                receivers=[RAIL, 8.0],
                averaging=["line"],
                tolerance=1e-2,
            )
        )
    # What a table's squares take where they need more frequencies than the table has, as these do not.
    for unit in [each for each in results if each.kind == "transfer"]:
        table = replace(results[unit], square_level=results[unit].level + 1)
        squares(TransferFunction([table], Track(**unit.inputs["track"])), table.block)


@cache
def warm_up_train_average() -> None:
    """Compile the kernel of averages over the train, or load it: for studies that ask for them."""
    ground, track = library.load("soil", "horstwalde"), library.load("track", "ballasted-paper")
    with compiling.alone():
        (made,) = transfer_blocks_by_class(ground, track, 0, [RAIL], 1e-2)
        train_integrals(TransferFunction(made.values(), track), np.array([0.0, 2.0]), np.array([2.0]))


@cache
def warm_up_fe_be() -> None:
    """Compile the kernels of the FE/BE model, or load them: for studies that ask for it."""
    strip = np.array([0.0, 1.0])
    with compiling.alone():
        fit = fit_tensor(library.load("soil", "horstwalde"), 1.0, 0.0, 1e-2)
        strip_flexibility(strip, fit.pole, fit.residue, fit.constant, strip)
        receiver_flexibility(strip, fit.pole, fit.residue, fit.constant, strip, strip)
