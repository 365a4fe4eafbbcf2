"""The response to a load that moves steadily, at wavenumbers beyond those of the tables.

There the rail on its pads carries all but a two-thousandth of the load alone (`railvib.transfer.nodes`), and
the track is many wavelengths wide. The ground under it then follows the stress above it place by place:

    C(β, y) = Q33(β, ω)/2b        for |y| < b, half of that at |y| = b, and 0 beyond,

which is exact but for e^{−β(b − |y|)}.
"""

import numpy as np

from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.soil.flexibility import ground_flexibility
from railvib.transfer.track_response import track_response


def steady_response(
    ground: Ground, track: Track, receiver: Receiver, frequency: np.ndarray, wavenumber: np.ndarray
) -> np.ndarray:
    """Return H̃ of the rail, or of the ground under the track, at large wavenumbers.

    Parameters
    ----------
    ground, track, receiver
        The ground, the track on it, and the receiver.
    frequency, wavenumber
        Hz and rad/m, (n,); no wave of the ground is as slow as 2πf/β.

    Returns
    -------
    ndarray of complex, shape (n,)
        m²/N.
    """
    compliance = ground_flexibility(ground, wavenumber, frequency) / (2.0 * track.half_width)
    rail, force = track_response(track, wavenumber, 2.0 * np.pi * frequency, compliance)
    if receiver.on_rail:
        return rail
    share = 0.5 * (1.0 + np.sign(track.half_width - (receiver.offset or 0.0)))
    return np.asarray(share * force * compliance)
