"""The speed of the wave that track and ground carry together."""

import numpy as np

from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil.rational_fit import fit_flexibility
from railvib.transfer.compliance_under_track import compliance_under_track
from railvib.transfer.track_response import track_response


def critical_speed(ground: Ground, track: Track, maximum_frequency: float = 100.0) -> float:
    """Return the lowest phase speed of the wave that track and ground carry together, m/s.

    A load that moves faster outruns that wave. It is found from the peaks of |H̃_R(β, ω)| over wavenumber, at
    frequencies from 1 Hz up to `maximum_frequency`; infinite where there is no peak.
    """
    slowest = np.inf
    start = None
    for frequency in np.geomspace(1.0, max(maximum_frequency, 2.0), 30):
        omega = 2.0 * np.pi * frequency
        fit = fit_flexibility(ground, float(frequency), 1e-6, start)
        start = fit.start
        speed = np.linspace(3.0, 0.3, 400) * ground.slowest_speed
        compliance = compliance_under_track(fit, omega / speed, track)
        rail, _force = track_response(track, omega / speed, omega, compliance)
        size = np.abs(rail)
        peak = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
        if peak.size:
            slowest = min(slowest, float(speed[peak[size[peak].argmax()]]))
    return float(slowest)
