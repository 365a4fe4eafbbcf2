"""The moving roughness averaged over the length of the train (Eq. 26), as the paper prints it.

    S̄ = (1/L) ∫_{α_1}^{α_M} S dx

The integral spans the axles and is divided by the length of the train. It needs the response along the line
between the axles, at every distance from every axle: H(x, f) is computed on an equidistant grid of x and
interpolated.
"""

from dataclasses import dataclass, field

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.jit import kernel
from railvib.numerics.wavenumber_panels import ORDER, fourier_integrals, lagrange_weights
from railvib.transfer.nodes import TOP
from railvib.transfer.transfer_function import TransferFunction

_COARSEST_STEP = 0.25
_STEPS_PER_WAVELENGTH = 7.0
_POINTS_PER_WAVELENGTH = 5.0
_FEWEST_POINTS = 10


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
    which = blocks.assigned(f, receiver.blocks)
    with cost.stage("train integrals") as spent:
        for block in np.unique(which):
            table = receiver.blocks[int(block)]
            here = which == block
            wavelength = TOP / (float(f[here].max()) * table.nodes.top_slowness)
            x, weight = _points(axle_position, wavelength)
            step = min(_COARSEST_STEP, wavelength / _STEPS_PER_WAVELENGTH)
            grid = step * np.arange(int(np.ceil(np.ptp(axle_position) / step)) + 5)
            _beta, transfer = receiver.at(int(block), f[here])
            integral[here] = _products(
                table.nodes.panel_edges(f[here]),
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
    from scipy.special import roots_legendre  # slow to import, and seldom needed

    points, weights = [], []
    for low, high in zip(axle_position[:-1], axle_position[1:], strict=True):
        node, weight = roots_legendre(
            int(np.ceil((high - low) / wavelength * _POINTS_PER_WAVELENGTH)) + _FEWEST_POINTS
        )
        points.append(0.5 * (low + high) + 0.5 * (high - low) * node)
        weights.append(0.5 * (high - low) * weight)
    return np.concatenate(points), np.concatenate(weights)


@kernel
def _products(edge, transfer, grid, at, weight):
    """Return Σ_x w H*(x − α_l) H(x − α_m), (lines, axles, axles); `at` is |x − α| in steps of the grid."""
    lines = edge.shape[0]
    axles = at.shape[1]
    out = np.empty((lines, axles, axles), np.complex128)
    response = np.empty((at.shape[0], axles), np.complex128)
    lagrange = np.empty(8)
    sine = np.empty((2, grid.shape[0]))
    cosine = np.empty((2, grid.shape[0]))
    for i in range(lines):
        half = 0.5 * (edge[i, 1:] - edge[i, :-1])
        centre = 0.5 * (edge[i, 1:] + edge[i, :-1])
        cosine[:] = 0.0
        fourier_integrals(centre, half, transfer[i], grid, cosine, sine)
        line = (cosine[0] + 1j * cosine[1]) / np.pi
        for j in range(at.shape[0]):
            for axle in range(axles):
                first = min(max(int(at[j, axle]) - 3, 0), grid.shape[0] - 8)
                lagrange_weights(at[j, axle] - first, lagrange)
                value = 0j
                for m in range(8):
                    value += lagrange[m] * line[first + m]
                response[j, axle] = value
        for one in range(axles):
            for other in range(axles):
                total = 0j
                for j in range(at.shape[0]):
                    total += weight[j] * np.conj(response[j, one]) * response[j, other]
                out[i, one, other] = total
    return out
