"""Law 3: whole passages computed in time, from moving loads, against the spectra; random profiles and
constant axle loads.

The oracle works in the frame that moves with the train, as the package's full model does not: for each
harmonic of the unevenness, the displacement around the train is the inverse transform over wavenumber of
H̃_G(β, y, ω − βv), and a fixed point sees it pass by. The half-space scales with frequency, so that one
rational fit gives its compliance at each ω − βv.
"""

import numba
import numpy as np
import pytest

from railvib.forces.receptance import tabulate_receptances
from railvib.forces.wheel_rail import axle_phases, force_matrices
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.parameters.wheel_roughness import WheelRoughness
from railvib.psd.excitation import excitation, wheel_excitations
from railvib.psd.full_model import passage_spectra
from railvib.psd.quasi_static import quasi_static_spectra
from railvib.soil._kernels.strip import strip_compliances
from railvib.soil.rational_fit import fit_flexibility
from railvib.transfer.track_response import track_response

SPEED = 40.0
OFFSET = 8.0
RECEIVER = Receiver(OFFSET)
WINDOW = 1200.0
"""Length of line in one record, m; the train passes its middle."""
POINTS = 8192
"""β up to 21 rad/m, receiving frequencies up to 136 Hz."""
ROUGH = Unevenness(form="sncf-good")
"""Smooth, and nearly level at long wavelengths, so that what lies beyond the harmonics does not count from
8 to 40 Hz.
"""
EDGES = np.linspace(0.3, 9.3, 361)
"""Limits of the harmonics' shares of the unevenness, rad/m."""
FREQUENCY_STEP = SPEED / WINDOW


@pytest.fixture(scope="module")
def soft():
    return Ground(
        layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.25)]
    )


@pytest.fixture(scope="module")
def single(vehicle):
    return Train(vehicles=[vehicle])


@pytest.fixture(scope="module")
def functions(soft, track, tables):
    return tables(soft, track, range(-3, 5), (RAIL, RECEIVER), 1e-5)


@numba.njit
def _compliances(beta, seen, pole, residue, constant, at, b, offset, compliances):
    out = np.empty((2, beta.size), np.complex128)
    for i in range(beta.size):
        ratio = abs(seen[i]) / at
        real, imag = compliances(
            beta[i : i + 1], pole * ratio**2, residue * ratio, constant / ratio, b, np.array([0.0, offset])
        )
        for row in range(2):
            out[row, i] = complex(real[row, 0], imag[row, 0] if seen[i] > 0.0 else -imag[row, 0])
    return out


class Oracle:
    """Displacement of a fixed point while harmonic loads pass by."""

    def __init__(self, ground, track):
        self.track = track
        fit = fit_flexibility(ground, 20.0, 1e-9)
        self.fit = (fit.pole, fit.residue, fit.constant, 2.0 * np.pi * 20.0)
        self.beta = 2.0 * np.pi / WINDOW * np.fft.fftfreq(POINTS, 1.0 / POINTS)
        self.time = WINDOW / SPEED * np.arange(POINTS) / POINTS

    def displacement(self, omega, force, position):
        """Return the analytic u(t) of loads P_l e^{iωt} at α_l + vt − WINDOW/2, seen from x = 0."""
        seen = omega - self.beta * SPEED
        seen = np.where(
            seen == 0.0, 1e-6, seen
        )  # β = 0 under a constant load: without limit, and left out below
        pole, residue, constant, at = self.fit
        centre, beside = _compliances(
            np.abs(self.beta),
            seen,
            pole,
            residue,
            constant,
            at,
            self.track.half_width,
            OFFSET,
            strip_compliances,
        )
        _rail, pressed = track_response(self.track, self.beta, seen, centre)
        # In the moving frame the point is at d = −vt + WINDOW/2: u = (1/2π) ∫ H̃ Σ P e^{iβ(d − α)} dβ.
        shift = np.exp(1j * self.beta * (WINDOW / 2.0))
        spectrum = pressed * beside * shift * (np.exp(-1j * self.beta[:, None] * position) @ force)
        spectrum[seen == 1e-6] = 0.0
        field = np.fft.fft(spectrum) / WINDOW  # Σ_β … e^{−iβvt} Δβ/2π
        return field * np.exp(1j * omega * self.time)


def spectrum_of(u):
    """Return U(f) = ∫ u e^{−2πift} dt at multiples of FREQUENCY_STEP, ascending from −."""
    return np.fft.fft(u, axis=-1) * (WINDOW / SPEED / POINTS)


@pytest.fixture(scope="module")
def passages(soft, track, single, functions):
    """Displacements over time per unit amplitude of each harmonic, (harmonics, times), and the harmonics'
    variances.
    """
    moving = tabulate_receptances(functions[RAIL], track, SPEED, single.axle_distances, range(-3, 4))
    oracle = Oracle(soft, track)
    beta = 0.5 * (EDGES[1:] + EDGES[:-1])
    f = beta * SPEED / (2.0 * np.pi)
    phase = axle_phases(single, f, SPEED)
    force = np.einsum("flp,fp->fl", force_matrices(single, moving, f), phase)
    u = np.array(
        [
            oracle.displacement(2.0 * np.pi * each, p, single.axle_positions)
            for each, p in zip(f, force, strict=True)
        ]
    )
    return u, ROUGH.psd(beta) * np.diff(EDGES), moving


@pytest.fixture(scope="module")
def lines():
    return FREQUENCY_STEP * np.arange(240, 1200, 46)  # 8 to 39 Hz


@pytest.fixture(scope="module")
def predicted(single, functions, passages, lines):
    excited = excitation(single, passages[2], ROUGH, SPEED, 100.0)
    return passage_spectra({RECEIVER: functions[RECEIVER]}, excited, single.length, SPEED, lines)[RECEIVER]


def test_expected_periodogram(passages, predicted, lines, single):
    """The expectation over the profiles, exactly: Σ of the harmonics' own passages, each from its time
    history.
    """
    u, variance, _moving = passages
    row = np.round(lines / FREQUENCY_STEP).astype(int)
    spectrum = spectrum_of(u)
    expected = (
        variance @ (np.abs(spectrum[:, row]) ** 2 + np.abs(spectrum[:, -row]) ** 2) * SPEED / single.length
    )
    # Both are integrals over β of the same function, here by midpoints on 360 harmonics.
    np.testing.assert_allclose(predicted, expected, rtol=1e-4, atol=1e-6 * expected.max())


def test_cut_off_wavelengths(passages, functions, single, lines):
    """Unevenness that ends abruptly, at limits of the harmonics' shares: 0.1 dB wherever there is 1e-3 of
    the largest line.
    """
    u, variance, moving = passages
    first, last = 40, 200  # 1.3 to 5.3 rad/m, 8.3 to 33.7 Hz: inside the lines
    cut = ROUGH.model_copy(
        update={
            "minimum_wavelength": 2.0 * np.pi / EDGES[last],
            "maximum_wavelength": 2.0 * np.pi / EDGES[first],
        }
    )
    excited = excitation(single, moving, cut, SPEED, 100.0)
    psd = passage_spectra({RECEIVER: functions[RECEIVER]}, excited, single.length, SPEED, lines)[RECEIVER]
    row = np.round(lines / FREQUENCY_STEP).astype(int)
    spectrum = spectrum_of(u[first:last])
    expected = variance[first:last] @ (np.abs(spectrum[:, row]) ** 2 + np.abs(spectrum[:, -row]) ** 2)
    expected *= SPEED / single.length
    strong = expected > 1e-3 * expected.max()
    assert np.abs(10.0 * np.log10(psd / expected))[strong].max() < 0.1


def test_monte_carlo(passages, predicted, lines, single):
    """Mean periodograms of 600 random passages: each line within 5 standard errors (5/√600 = 20 %), the
    mean of 21 lines 3.

    At one line |U|² of a random passage is distributed exponentially (the sum of many harmonics), its
    standard deviation equal to its mean. A wrong factor of 2, or a wrong sign of a phase, is 7 to 100 times
    the error of the mean over the lines.
    """
    u, variance, _moving = passages
    rng = np.random.default_rng(11)
    samples = 600
    row = np.round(lines / FREQUENCY_STEP).astype(int)
    periodogram = np.zeros((samples, lines.size))
    for start in range(0, samples, 100):
        # One-sided variance S_w Δβ: w = Re Σ c e^{iβx} with E|c|² = 2 S_w Δβ.
        c = np.sqrt(variance) * (
            rng.normal(size=(100, variance.size)) + 1j * rng.normal(size=(100, variance.size))
        )
        response = (c @ u).real
        periodogram[start : start + 100] = (
            2.0 * np.abs(spectrum_of(response)[:, row]) ** 2 * SPEED / single.length
        )
    ratio = periodogram / predicted
    error = ratio.std(axis=0, ddof=1) / np.sqrt(samples)
    assert np.all(error < 0.08)
    assert np.all(np.abs(ratio.mean(axis=0) - 1.0) < 5.0 * error)
    by_sample = ratio.mean(axis=1)
    assert abs(by_sample.mean() - 1.0) < 3.0 * by_sample.std(ddof=1) / np.sqrt(samples)


def test_mean_square_of_passages(passages, single):
    """Parseval in time: the energy of the histories is the spectrum's, so nothing of the record was lost at
    its ends.
    """
    u, _variance, _moving = passages
    middle = POINTS // 2
    ends = np.abs(u[:, :200]).max(axis=1) + np.abs(u[:, -200:]).max(axis=1)
    assert np.all(ends < 1e-2 * np.abs(u[:, middle - 1500 : middle + 1500]).max(axis=1))


def test_constant_axle_loads(soft, track, single, functions):
    """Quasi-static: the spectrum of the time history of the moving axle loads."""
    u = Oracle(soft, track).displacement(0.0, single.axle_loads, single.axle_positions)
    np.testing.assert_allclose(u.imag, 0.0, atol=1e-9 * np.abs(u).max())
    row = np.array(
        [80, 121, 183, 240, 301]
    )  # 2.7 to 10 Hz: beyond, the near field of constant loads has died out
    f = FREQUENCY_STEP * row
    expected = 2.0 * np.abs(spectrum_of(u.real)[row]) ** 2 * SPEED / single.length
    axles = single.axle_positions, single.axle_loads
    psd = quasi_static_spectra(soft, track, functions, *axles, single.length, SPEED, f)[RECEIVER]
    np.testing.assert_allclose(psd, expected, rtol=1e-4)


WHEELS = WheelRoughness(
    form="power-law", amplitude=3e-8, exponent=3.0, circumference=2.0 * np.pi / float(EDGES[20])
)
"""As rough as the rails at some lines; it ends at a limit of the harmonics' shares."""


def at_lines(u, row):
    """Return U at the lines and at their negative frequencies, (harmonics, 2, lines)."""
    spectrum = spectrum_of(u)
    return np.stack([spectrum[:, row], spectrum[:, -row]], axis=1)


@pytest.fixture(scope="module")
def wheel_passages(soft, track, single, passages, lines):
    """Spectra at the lines per unit amplitude of each harmonic of one axle's wheels alone, (axles, harmonics,
    2, lines).
    """
    oracle = Oracle(soft, track)
    row = np.round(lines / FREQUENCY_STEP).astype(int)
    beta = 0.5 * (EDGES[1:] + EDGES[:-1])
    f = beta * SPEED / (2.0 * np.pi)
    forces = force_matrices(single, passages[2], f)
    return np.array(
        [
            at_lines(
                np.array(
                    [
                        oracle.displacement(2.0 * np.pi * each, p, single.axle_positions)
                        for each, p in zip(f, forces[:, :, axle], strict=True)
                    ]
                ),
                row,
            )
            for axle in range(single.axle_count)
        ]
    )


@pytest.fixture(scope="module")
def predicted_wheels(single, functions, passages, lines):
    rough = Train(vehicles=[each.model_copy(update={"wheel_roughness": WHEELS}) for each in single.vehicles])
    excited = wheel_excitations(rough, passages[2], SPEED, 100.0)
    return passage_spectra({RECEIVER: functions[RECEIVER]}, excited, rough.length, SPEED, lines)[RECEIVER]


def wheel_variance():
    return WHEELS.spectrum.psd(0.5 * (EDGES[1:] + EDGES[:-1])) * np.diff(EDGES)


@pytest.mark.slow
def test_expected_periodogram_of_rough_wheels(wheel_passages, predicted_wheels, single):
    """The expectation over the wheels: the sum over axles of the harmonics' own passages. Midpoints on the
    harmonics miss 1e-3 of a power law of exponent 3 where it begins.
    """
    energy = (np.abs(wheel_passages) ** 2).sum(axis=(0, 2))
    expected = wheel_variance() @ energy * SPEED / single.length
    np.testing.assert_allclose(predicted_wheels, expected, rtol=2e-3, atol=1e-6 * expected.max())


@pytest.mark.slow
def test_monte_carlo_of_rails_and_wheels(
    passages, wheel_passages, predicted, predicted_wheels, lines, single
):
    """Random rails, the same under all axles, with random wheels, each on their own: 2000 passages, within
    5 standard errors per line and 3 for the mean of the lines.
    """
    row = np.round(lines / FREQUENCY_STEP).astype(int)
    rails = at_lines(passages[0], row)
    rng = np.random.default_rng(12)
    samples = 2000

    def amplitudes(variance):
        size = samples, variance.size
        return np.sqrt(variance) * (rng.normal(size=size) + 1j * rng.normal(size=size))

    spectrum = np.einsum("sh,hkf->skf", amplitudes(passages[1]), rails)
    for axle in wheel_passages:
        spectrum += np.einsum("sh,hkf->skf", amplitudes(wheel_variance()), axle)
    # Of the real part of the histories.
    periodogram = 0.5 * np.abs(spectrum[:, 0] + spectrum[:, 1].conj()) ** 2 * SPEED / single.length
    assert 0.1 < np.median(predicted_wheels / predicted) < 10.0
    ratio = periodogram / (predicted + predicted_wheels)
    error = ratio.std(axis=0, ddof=1) / np.sqrt(samples)
    assert np.all(np.abs(ratio.mean(axis=0) - 1.0) < 5.0 * error)
    by_sample = ratio.mean(axis=1)
    assert abs(by_sample.mean() - 1.0) < 3.0 * by_sample.std(ddof=1) / np.sqrt(samples)
