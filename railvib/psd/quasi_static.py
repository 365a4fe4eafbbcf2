"""The quasi-static response: the response of a fixed point to the axle loads that move past it.

It depends on neither unevenness nor approach: |S_0(f; 0)|²·2/T, with κ = −2πf/v.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from railvib import cost
from railvib.numerics.vector_math import phasors
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.transfer.steady_response import steady_response
from railvib.transfer.transfer_function import TransferFunction


@dataclass(frozen=True)
class QuasiStatic:
    """PSDs of displacement from the moving axle loads at some receivers, on narrow-band lines."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "narrow-band lines"}
    )
    psd: np.ndarray = field(
        metadata={
            "dims": ("receiver", "frequency"),
            "unit": "m2/Hz",
            "description": "one-sided PSD of displacement",
        }
    )


def quasi_static_spectra(
    ground: Ground,
    track: Track,
    receivers: Mapping[Receiver, TransferFunction],
    axle_position: np.ndarray,
    axle_load: np.ndarray,
    train_length: float,
    speed: float,
    frequency: np.ndarray,
) -> dict[Receiver, np.ndarray]:
    """Return PSDs of displacement at fixed points from the moving axle loads.

    Parameters
    ----------
    ground, track
        The ground and the track on it: beyond the tables their response is known in closed form.
    receivers
        The receivers' tabulated transfer functions, taken one by one.
    axle_position, axle_load
        α, m, and the loads, N, (axles,).
    train_length
        L, m; the passage takes T = L/v.
    speed
        m/s.
    frequency
        Receiving frequencies, Hz, (n,).

    Returns
    -------
    dict of ndarray, shape (n,)
        One-sided PSDs, m²/Hz.
    """
    kappa = 2.0 * np.pi * frequency / speed
    with cost.stage("quasi-static") as spent:
        load = phasors(kappa[:, None] * axle_position) @ axle_load / speed
        psd = {}
        for receiver in receivers:
            response = _responses(ground, track, receiver, receivers[receiver], frequency, kappa)
            psd[receiver] = np.abs(response * load) ** 2 * 2.0 * speed / train_length
        spent.evaluations += frequency.size * len(receivers)
    return psd


def _responses(
    ground: Ground,
    track: Track,
    receiver: Receiver,
    function: TransferFunction,
    frequency: np.ndarray,
    wavenumber: np.ndarray,
) -> np.ndarray:
    """Return H̃ of a receiver, (n,), zero where it is negligible."""
    tabulated = function.covers(frequency, wavenumber)
    response = np.zeros(frequency.size, complex)
    response[tabulated] = function.along(frequency[tabulated], wavenumber[tabulated])
    if receiver.distance(track.half_width) == 0.0:
        beyond = ~tabulated
        response[beyond] = steady_response(ground, track, receiver, frequency[beyond], wavenumber[beyond])
    return response
