"""Soft layered ground and receivers on it, for tests of transfer functions."""

import numpy as np

from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.soil.quadrature import strip_compliance_by_quadrature, strip_mean_by_quadrature
from railvib.transfer.track_response import track_response

SOFT = Ground(
    layers=[
        Layer(shear_speed=110.0, dilatational_speed=300.0, density=1700.0, loss_factor=0.08, thickness=3.0),
        Layer(shear_speed=220.0, dilatational_speed=500.0, density=1900.0, loss_factor=0.06),
    ]
)
RECEIVERS = (RAIL, *map(Receiver, (0.0, 5.0, 20.0, 1.0)))
"""The last one beside the centre line, under the track."""


def direct(track, receiver, frequency, beta):
    y = receiver.offset or 0.0
    c = strip_compliance_by_quadrature(SOFT, track.half_width, beta, [0.0, y], frequency, 1e-8)
    under = c[0]
    if track.follows_mean:
        under = strip_mean_by_quadrature(SOFT, track.half_width, beta, frequency, 1e-8)
    rail, force = track_response(track, beta, 2.0 * np.pi * frequency, under)
    return complex(rail if receiver.on_rail else force * c[1])
