"""Moving roughness averaged over the length of the train (Eq. 26), as the paper prints it.

    S̄ = (1/L) ∫_{α_1}^{α_M} S dx

The integral spans the axles and is divided by the length of the train. It needs the response along the line
between the axles, at every distance from every axle: H(x, f) is computed on an equidistant grid of x and
interpolated.
"""

from dataclasses import dataclass, field

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import ORDER
from railvib.psd._kernels.averages import axle_products
from railvib.transfer.nodes import TOP
from railvib.transfer.transfer_function import TransferFunction

_COARSEST_STEP = 0.25
_STEPS_PER_WAVELENGTH = 7.0
"""Coarsest step of the grid, m, and its fewest steps in the shortest wavelength."""
_POINTS_PER_WAVELENGTH = 5.0
_FEWEST_POINTS = 10
"""Points of the quadrature between two axles: per shortest wavelength, and in addition."""


@dataclass(frozen=True)
class TrainIntegrals:
    """∫ H*(x − α_l) H(x − α_m) dx between the first and the last axle, of one receiver."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "narrow-band lines"}
    )
    integral: np.ndarray = field(
        metadata={
            "dims": ("frequency", "axle", "other_axle"),
            "unit": "m3/N2",
            "description": "integral over the train of the responses to two axles, which ascend in x",
        }
    )


def train_integrals(
    receiver: TransferFunction, axle_position: np.ndarray, frequency: np.ndarray
) -> TrainIntegrals:
    """Return the products of the responses to every two axles, integrated over the train.

    Parameters
    ----------
    receiver
        The receiver's tabulated transfer function.
    axle_position
        α ascending, m, (axles,).
    frequency
        Frequencies, Hz, (n,), inside the tables.
    """
    f = np.asarray(frequency, float)
    integral = np.empty((f.size, axle_position.size, axle_position.size), complex)
    blocks.check_coverage(f, receiver.blocks)
    block_of = blocks.nearest_block(f, receiver.blocks)
    with cost.stage("train integrals") as spent:
        for block in np.unique(block_of):
            table = receiver.blocks[int(block)]
            inside = block_of == block
            wavelength = TOP / (float(f[inside].max()) * table.nodes.top_slowness)
            x, weight = _points(axle_position, wavelength)
            step = min(_COARSEST_STEP, wavelength / _STEPS_PER_WAVELENGTH)
            grid = step * np.arange(int(np.ceil(np.ptp(axle_position) / step)) + 5)
            _beta, transfer = receiver.at(int(block), f[inside])
            integral[inside] = axle_products(
                table.nodes.panel_edges(f[inside]),
                np.stack([transfer.real, transfer.imag], axis=1).reshape(transfer.shape[0], 2, -1, ORDER),
                grid,
                np.abs(x[:, None] - axle_position) / step,
                weight,
            )
            spent.evaluations += transfer.size
            spent.kernel_calls += 1
    return TrainIntegrals(f, integral)


def _points(axle_position: np.ndarray, wavelength: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss–Legendre points and weights between the axles, where the response has its kinks."""
    from scipy.special import roots_legendre  # slow to import, and rarely needed

    points, weights = [], []
    for low, high in zip(axle_position[:-1], axle_position[1:], strict=True):
        node, weight = roots_legendre(
            int(np.ceil((high - low) / wavelength * _POINTS_PER_WAVELENGTH)) + _FEWEST_POINTS
        )
        points.append(0.5 * (low + high) + 0.5 * (high - low) * node)
        weights.append(0.5 * (high - low) * weight)
    return np.concatenate(points), np.concatenate(weights)
