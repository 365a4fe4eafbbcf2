"""Laws 1 and 2: what holds exactly between the forms of moving roughness, and between it and the full
model.
"""

import numpy as np
import pytest

from railvib.forces.receptance import tabulate_receptances
from railvib.forces.wheel_rail import axle_phases, force_matrices
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from railvib.psd.excitation import excitation, resolve
from railvib.psd.full_model import passage_spectra
from railvib.psd.line_integrals import direct_line_integrals, line_integrals
from railvib.psd.lines import lines
from railvib.psd.moving_roughness import axle_pairs, axle_spans, products
from railvib.psd.moving_roughness_spectra import moving_roughness_spectra
from railvib.psd.quasi_static import quasi_static_spectra
from railvib.psd.spectra import Passage

SPEED = 150.0 / KMH
NEAR = Receiver(8.0)
ROUGH = Unevenness(form="fra-hamid-yang", line_class=3)
RECEIVERS = (RAIL, *map(Receiver, (0.0, 8.0, 32.0)))
BLOCKS = range(-3, 4)
"""Tabulated up to 112 Hz; receptances of moving loads up to a third of that, for they need more than their
own frequency.
"""


def line_products(transfer, axle_position, f, force):
    """Return ∫ u_p* u_q dx over the whole line, of several sets of forces (lines, axles, sets)."""
    d = axle_spans(axle_position)
    integral = direct_line_integrals({"here": transfer}, d, f)["here"]
    return products(axle_pairs(integral, d, axle_position), force)


@pytest.fixture(scope="module")
def soft():
    """A soft, well damped half-space: one fit serves all its frequencies."""
    return Ground(
        layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.1)]
    )


@pytest.fixture(scope="module")
def functions(soft, track, tables):
    return tables(soft, track, BLOCKS, RECEIVERS, 1e-5)


@pytest.fixture(scope="module")
def standing(functions, track, train):
    return tabulate_receptances(functions[RAIL], track, 0.0, train.axle_distances, range(-3, 3))


def test_no_receiver_depends_on_the_others(functions, train):
    """Computed together or alone, to the last bit: results are kept by receiver, in any company."""
    f = np.array([2.5, 9.0, 21.0])
    d = axle_spans(train.axle_positions)
    together = direct_line_integrals(functions, d, f)
    tabulated = line_integrals(functions, d, range(1, 3), 1e-5)
    for each in RECEIVERS:
        only = {each: functions[each]}
        np.testing.assert_array_equal(together[each], direct_line_integrals(only, d, f)[each])
        alone = line_integrals(only, d, range(1, 3), 1e-5)[each]
        np.testing.assert_array_equal(tabulated[each].integral, alone.integral)
        np.testing.assert_array_equal(tabulated[each].grid.level, alone.grid.level)


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_tabulated_line_integrals_are_those_computed_at_the_lines(receiver, functions, train):
    """Interpolated between the frequencies of a table, at every axle distance; the tolerance is 1e-4."""
    d, f = axle_spans(train.axle_positions), np.linspace(1.13, 35.4, 301)
    only = {receiver: functions[receiver]}
    tabulated = line_integrals(only, d, range(3))[receiver]
    direct = direct_line_integrals(only, d, f)[receiver]
    assert np.all(np.abs(tabulated.at(f) - direct) < 3e-5 * direct[:, :1])
    assert np.all(tabulated.interpolation_error <= 1e-5)


def test_by_axle_equals_all_together(functions, standing, train, soft, track):
    """Law 1: Eq. 27 with its cross terms is Eq. 23, to rounding."""
    midband = third_octaves.midbands(2.0, 25.0)
    d = axle_spans(train.axle_positions)
    integrals = line_integrals(functions, d, range(3))
    passage = Passage(train, ROUGH, SPEED, tuple(midband.tolist()))
    still = quasi_static_spectra(
        soft, track, functions, train.axle_positions, train.axle_loads, train.length, SPEED, passage.frequency
    )
    made = {
        approach: moving_roughness_spectra(approach, passage, standing, still, integrals, {})
        for approach in ("moving-roughness", "moving-roughness-by-axle", "moving-roughness-uncorrelated")
    }
    together, by_axle, uncorrelated = made.values()
    np.testing.assert_allclose(by_axle.psd, together.psd, rtol=1e-10)
    np.testing.assert_allclose(by_axle.mean_square, together.mean_square, rtol=1e-10)
    dynamic = together.contribution == "dynamic"
    assert not np.allclose(uncorrelated.psd[dynamic], together.psd[dynamic], rtol=0.1)


def test_uncorrelated_is_the_mean_over_random_delays(functions, standing, train):
    """Eq. 28 is what Eq. 23 gives on average if each axle's unevenness has a phase of its own."""
    f = np.array([9.0, 21.0])
    matrices = force_matrices(train, standing, f)
    expected = np.einsum("fpp->f", line_products(functions[NEAR], train.axle_positions, f, matrices)).real
    rng = np.random.default_rng(4)
    # Random signs make the cross terms vanish on average; Hadamard signs make them vanish exactly.
    signs = np.array([[1.0]])
    while signs.shape[0] < 16:
        signs = np.block([[signs, signs], [signs, -signs]])
    phase = np.exp(2j * np.pi * rng.random(16))
    force = np.einsum("flp,sp->fls", matrices, signs * phase)
    mean = np.einsum("fss->f", line_products(functions[NEAR], train.axle_positions, f, force)).real / 16.0
    np.testing.assert_allclose(mean, expected, rtol=1e-12)


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_line_integral_is_the_mean_over_positions(receiver, functions, train):
    """Parseval: ∫ |u(x)|² dx of the summed response in space, by the inverse transform, against the line
    products.
    """
    f = np.array([7.0, 23.0])
    force = np.random.default_rng(5).normal(size=(2, 16, 2)) @ np.array([1.0, 1j])
    product = line_products(functions[receiver], train.axle_positions, f, force[..., None])
    for row, frequency in enumerate(f):
        step, count = 2.0 * np.pi / 4000.0, 2**16  # 4 km of line
        beta = step * np.arange(-count // 2, count // 2)
        transfer = functions[receiver].along(np.full(count, frequency), beta)
        spectrum = transfer * (np.exp(-1j * beta[:, None] * train.axle_positions) @ force[row])
        u = np.fft.ifft(spectrum) * count * step / (2.0 * np.pi)
        total = (np.abs(u) ** 2).sum() * 4000.0 / count
        # What of the rail lies beyond the table's end counts 1e-8; its largest β is within the samples.
        assert product[row, 0, 0].real == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_frozen_full_model_is_moving_roughness(receiver, functions, train):
    """Law 2: forces and unevenness frozen at +f, over −∞ < β < ∞: full = line-averaged moving roughness, to
    1e-6.

    The response is a Hermitian form whose matrix M(α_l − α_m) is real, so that of complex forces is that of
    their real and of their imaginary part; each of them, being real, equals its own conjugate at −β, as the
    package's excitation has it.
    """
    f = np.array([1.5, 6.3, 14.0, 31.0])
    alpha = train.axle_positions
    force = np.random.default_rng(6).normal(size=(16, 2)) @ np.array([1.0, 1j])
    largest = max(block.nodes.largest for block in functions[receiver].blocks.values())
    reach = largest + 2.0 * np.pi * f[-1] / SPEED
    full = np.zeros(f.size)
    for part in (force.real, force.imag):
        excited = resolve(
            lambda beta, part=part: part * np.exp(-1j * beta[:, None] * alpha), reach, alpha, tolerance=1e-6
        )
        full += passage_spectra({receiver: functions[receiver]}, excited, train.length, SPEED, f)[receiver]
    # MR: (1/L) ∫|u|²dx S_w 2π/v with S_w = 1.
    moving = (
        line_products(functions[receiver], alpha, f, np.tile(force, (f.size, 1))[..., None])[:, 0, 0].real
        / train.length
        * 2.0
        * np.pi
        / SPEED
    )
    np.testing.assert_allclose(full, moving, rtol=1e-6)


class TestSlowTrain:
    """Law 2, second half: as v → 0 the two approaches meet, line by line for one axle, in bands only for a
    train.
    """

    MASS, CONTACT = 1800.0, 2.925e9

    def force(self, receptance, f):
        """Return the force of one unsprung mass per unit unevenness."""
        return -1.0 / (receptance + 1.0 / self.CONTACT - 1.0 / (self.MASS * (2.0 * np.pi * f) ** 2))

    def one_axle(self, functions, track, receiver, speed, f):
        """Return the full model's and the moving roughness' PSD times the length they are averaged over."""
        reach = f.max() + 14.0
        moving = tabulate_receptances(functions[RAIL], track, speed, [0.0], range(-3, 3))
        standing = tabulate_receptances(functions[RAIL], track, 0.0, [0.0], range(-3, 3))

        def amplitude(beta):
            own = np.maximum(beta * speed / (2.0 * np.pi), 0.01)
            unevenness = np.sqrt(ROUGH.psd(2.0 * np.pi * own / speed))
            return (self.force(moving.at(own)[:, 0], own) * unevenness)[:, None]

        excited = resolve(amplitude, reach * 2.0 * np.pi / speed, np.array([0.0]))
        full = passage_spectra({receiver: functions[receiver]}, excited, 1.0, speed, f)[receiver]
        force = self.force(standing.at(f)[:, 0], f)[:, None, None]
        mean = line_products(functions[receiver], np.array([0.0]), f, force)[:, 0, 0].real
        return full, mean * ROUGH.psd(2.0 * np.pi * f / speed) * 2.0 * np.pi / speed

    @pytest.mark.parametrize("receiver", [RAIL, Receiver(8.0)])
    def test_one_axle_line_by_line(self, receiver, functions, track):
        f = np.array([5.0, 11.0, 19.0])
        errors = []
        for speed in (2.0, 0.5):
            full, moving = self.one_axle(functions, track, receiver, speed, f)
            errors.append(np.abs(full / moving - 1.0).max())
        assert errors[1] < 0.01
        assert errors[1] < 0.1 * errors[0]  # of second order: faster and slower shifts balance

    def test_train_in_bands_only(self, functions, track, vehicle):
        train = Train(vehicles=[vehicle])
        speed, midband = 0.5, np.array([10.0])
        d = train.axle_distances
        moving = tabulate_receptances(functions[RAIL], track, speed, d, range(-3, 3))
        standing = tabulate_receptances(functions[RAIL], track, 0.0, d, range(-3, 3))
        on_lines = lines(tuple(midband), train, speed)
        f = on_lines.frequency
        excited = excitation(train, moving, ROUGH, speed, 25.0)
        full = passage_spectra({NEAR: functions[NEAR]}, excited, train.length, speed, f)[Receiver(8.0)]
        force = np.einsum("flp,fp->fl", force_matrices(train, standing, f), axle_phases(train, f, speed))[
            ..., None
        ]
        mean = line_products(functions[NEAR], train.axle_positions, f, force)[:, 0, 0].real
        rough = mean / train.length * ROUGH.psd(2.0 * np.pi * f / speed) * 2.0 * np.pi / speed
        by_band = on_lines.mean_squares(np.array([full, rough]))[:, 0]
        assert abs(10.0 * np.log10(by_band[0] / by_band[1])) < 0.1
        # Line by line the comb remains, however slow the train is.
        assert np.std(10.0 * np.log10(full / rough)) > 2.0
