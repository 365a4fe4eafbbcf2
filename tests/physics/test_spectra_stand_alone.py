"""A band's level follows from the case alone, not from the step of its lines, nor from what else is asked.

Levels are compared where they lie within 200 dB of the largest at their receiver; below, results give none.
Those from the axle loads alone are compared within 80 dB: far from the track they fall below what tables
resolve, 1e-8 of their peak.
"""

from contextlib import contextmanager

import numpy as np
import pytest

from railvib import library
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import CENTRE, RAIL, Receiver
from railvib.parameters.units import GRAVITY, KMH
from railvib.parameters.vehicle import Train
from railvib.psd import lines
from railvib.stages import case_spectra
from railvib.stages.transfer_table import TransferTable

SOFT = Ground(
    layers=[
        Layer(shear_speed=110.0, dilatational_speed=300.0, density=1700.0, loss_factor=0.08, thickness=3.0),
        Layer(shear_speed=220.0, dilatational_speed=500.0, density=1900.0, loss_factor=0.06),
    ]
)
ROUGH = library.load("unevenness", "fra-hamid-yang-3")
RECEIVERS = (RAIL, CENTRE, Receiver(8.0), Receiver(64.0))
APPROACHES = ("moving-roughness", "moving-roughness-uncorrelated", "full")
FLOOR_DB, QUASI_STATIC_FLOOR_DB = 200.0, 80.0


class Memory(dict):
    """Results of stages, each computed when it is first asked for; tables serve many trains and speeds."""

    def load(self, stage):
        if stage not in self:
            self[stage] = stage.compute(self.load)
        return self[stage]

    def discard_all_but_tables(self):
        for stage in [stage for stage in self if not isinstance(stage, TransferTable)]:
            del self[stage]


@pytest.fixture(scope="module")
def memory():
    return Memory()


def levels(memory, track, train, speed, band):
    """Return levels, dB, (approach, series, band), and which of them are above the floor."""
    level, above = [], []
    for approach in APPROACHES:
        stage = case_spectra(
            approach,
            ground=SOFT,
            track=track,
            train=train,
            unevenness=ROUGH,
            speed=speed,
            band=tuple(band),
            receivers=RECEIVERS,
            averaging=("line",),
            tolerance=1e-4,
            cross_section=None,
        )
        result = stage.compute(memory.load)
        with np.errstate(divide="ignore"):
            level.append(10.0 * np.log10(result.mean_square))
        place = np.array([f"{name} {y}" for name, y in zip(result.receiver, result.offset_m, strict=True)])
        largest = np.array([level[-1][place == name].max() for name in place])
        floor = np.where(result.contribution == "quasi-static", QUASI_STATIC_FLOOR_DB, FLOOR_DB)
        above.append(level[-1] > (largest - floor)[:, None])
    return np.array(level), np.array(above)


def largest_difference(level, other, above):
    return np.abs(np.subtract(level, other, where=above, out=np.zeros(above.shape))).max()


def random_train(vehicle, random):
    """Return one to twenty vehicles alike, with masses and suspensions about those of one."""
    spread = {
        "car_mass": 0.6,
        "car_pitch_inertia": 0.6,
        "secondary_stiffness": 1.0,
        "secondary_damping": 1.5,
        "primary_stiffness": 0.7,
        "primary_damping": 1.5,
    }
    changed = {
        name: getattr(vehicle, name) * float(np.exp(random.uniform(-width, width)))
        for name, width in spread.items()
    }
    changed["axle_load"] = vehicle.model_copy(update=changed).total_mass * GRAVITY / 4.0
    return Train(vehicles=[vehicle.model_copy(update=changed)] * int(random.choice([1, 1, 2, 4, 8, 20])))


@pytest.fixture
def halved(monkeypatch):
    """Return a context in which lines are twice as close."""

    @contextmanager
    def context():
        with monkeypatch.context() as patch:
            for name in ("_STEPS_PER_RIPPLE", "_STEPS_PER_MODE", "_FEWEST_INTERVALS"):
                patch.setattr(lines, name, 2 * getattr(lines, name))
            lines.lines.cache_clear()
            yield
        lines.lines.cache_clear()

    return context


@pytest.mark.parametrize(
    "cases", [pytest.param(range(3), id="few"), pytest.param(range(3, 40), id="many", marks=pytest.mark.slow)]
)
def test_half_the_step_moves_no_band(cases, memory, track, vehicle, halved):
    """By more than 0.1 dB: 0.04 dB occurs."""
    band = third_octaves.midbands(1.0, 31.5).tolist()
    for case in cases:
        random = np.random.default_rng([20, case])
        train = random_train(vehicle, random)
        speed = float(np.exp(random.uniform(np.log(20.0), np.log(500.0)))) / KMH
        usual, above = levels(memory, track, train, speed, band)
        count = lines.lines(tuple(band), train, speed).frequency.size
        with halved():
            assert lines.lines(tuple(band), train, speed).frequency.size > 1.9 * count
            finer, _above = levels(memory, track, train, speed, band)
        memory.discard_all_but_tables()
        assert largest_difference(finer, usual, above) < 0.1, f"case {case}"


@pytest.mark.parametrize("kmh", [150.0, 300.0])
def test_bands_do_not_depend_on_the_others(kmh, memory, track, train):
    """To 0.01 dB: 2e-4 dB occurs."""
    band = third_octaves.midbands(1.0, 31.5).tolist()
    every, above = levels(memory, track, train, kmh / KMH, band)
    for bands in (slice(0, 1), slice(0, 4), slice(6, 9), slice(13, 16)):
        some, _above = levels(memory, track, train, kmh / KMH, band[bands])
        assert largest_difference(some, every[..., bands], above[..., bands]) < 0.01


def test_far_and_high_is_not_negative(track, train):
    """Nothing is left there; what interpolation leaves of it may not be refused."""
    memory = Memory()
    stage = case_spectra(
        "full",
        ground=library.load("soil", "greby"),
        track=track,
        train=train,
        unevenness=ROUGH,
        speed=150.0 / KMH,
        band=tuple(third_octaves.midbands(40.0, 80.0).tolist()),
        receivers=(Receiver(500.0),),
        averaging=("line",),
        tolerance=1e-3,
        cross_section=None,
    )
    result = stage.compute(memory.load)
    assert np.all(result.psd >= 0.0)
    assert np.all(result.mean_square[result.quantity == "velocity"] < (1e-9) ** 2)
