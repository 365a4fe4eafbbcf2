"""The ground's compliance that a track feels: on the centre line, or on average over the contact width."""

import numpy as np

from railvib.parameters.track import Track
from railvib.soil.rational_fit import RationalFit
from railvib.soil.strip import strip_compliance, strip_mean


def compliance_under_track(fit: RationalFit, wavenumber: np.ndarray, track: Track) -> np.ndarray:
    """Return the displacement that a track follows, per unit force per length on the ground.

    Parameters
    ----------
    fit
        The rational form of Q33 at one frequency.
    wavenumber
        β along the track, (n,), rad/m.
    track
        The track; its contact width and coupling count.

    Returns
    -------
    ndarray of complex, shape (n,)
        m²/N.
    """
    if track.follows_mean:
        return strip_mean(fit, wavenumber, track.half_width)
    return np.asarray(strip_compliance(fit, wavenumber, track.half_width, np.array([0.0]))[0])
