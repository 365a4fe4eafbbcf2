"""Eq. 26: the response averaged over the train, against the response along the line by an inverse
transform.
"""

import numpy as np
import pytest

from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.vehicle import Train
from railvib.psd.line_integrals import direct_line_integrals
from railvib.psd.moving_roughness import axle_pairs, axle_spans, products
from railvib.psd.train_average import train_integrals

SOFT = Ground(layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.1)])
RECEIVERS = (RAIL, *map(Receiver, (0.0, 8.0, 32.0)))
FREQUENCY = np.array([1.7, 9.0, 28.0])


@pytest.fixture(scope="module")
def functions(track, tables):
    return tables(SOFT, track, range(-1, 3), RECEIVERS, 1e-5)


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_integral_over_the_train(receiver, functions, vehicle):
    train = Train(vehicles=[vehicle, vehicle])
    alpha = train.axle_positions
    force = np.random.default_rng(8).normal(size=(8, 2)) @ np.array([1.0, 1j])
    mean = products(
        train_integrals(functions[receiver], alpha, FREQUENCY).integral, np.tile(force, (3, 1))[..., None]
    )
    for row, frequency in enumerate(FREQUENCY):
        length, count = 3000.0, 2**17
        beta = 2.0 * np.pi / length * np.arange(-count // 2, count // 2)
        transfer = functions[receiver].along(np.full(count, frequency), beta)
        spectrum = transfer * (np.exp(-1j * beta[:, None] * alpha) @ force)
        u = np.fft.ifft(np.fft.ifftshift(spectrum)) * count / length
        x = length / count * np.arange(count)
        # The rail's kinks under the axles limit both; trapezoids between the first and the last axle, ends in
        # part.
        inside = np.linspace(alpha[0], alpha[-1], 40001)
        squared = np.interp(inside, x, np.abs(u) ** 2)
        expected = np.trapezoid(squared, inside)
        assert mean[row, 0, 0].real == pytest.approx(expected, rel=2e-4)
        assert abs(mean[row, 0, 0].imag) < 1e-9 * expected


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_less_than_over_the_line(receiver, functions, vehicle):
    train = Train(vehicles=[vehicle])
    force = np.tile(np.array([1.0, -0.5, 1j, 0.3]), (3, 1))[..., None]
    over_train = products(
        train_integrals(functions[receiver], train.axle_positions, FREQUENCY).integral, force
    )
    d = axle_spans(train.axle_positions)
    integral = direct_line_integrals({receiver: functions[receiver]}, d, FREQUENCY)[receiver]
    over_line = products(axle_pairs(integral, d, train.axle_positions), force)
    assert np.all(over_train[:, 0, 0].real > 0.0)
    assert np.all(over_train[:, 0, 0].real < over_line[:, 0, 0].real)
