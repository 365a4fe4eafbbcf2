"""Fourier integrals over the panels of many frequencies."""

import numpy as np

from railvib.numerics._kernels.panels import fourier_integrals
from railvib.numerics.jit import kernel
from railvib.numerics.wavenumber_panels import ORDER


@kernel
def integrate_panels(first, order, centre, half, value, distance, cosine, sine):
    """Add the cosine and sine integrals of every frequency's panels, (frequencies, 2, distances) each.

    Panels are in the order of their frequencies, those of frequency i from `first[i]` on. Only `value`,
    (panels, 2·order), real and imaginary parts in turn, is not: `order` holds the row of each panel.
    """
    frequencies = first.shape[0] - 1
    most = 0
    for i in range(frequencies):
        most = max(most, first[i + 1] - first[i])
    parts = np.empty((2, most, ORDER))
    for i in range(frequencies):
        for p in range(first[i], first[i + 1]):
            for j in range(ORDER):
                parts[0, p - first[i], j] = value[order[p], 2 * j]
                parts[1, p - first[i], j] = value[order[p], 2 * j + 1]
        panels = slice(first[i], first[i + 1])
        fourier_integrals(centre[panels], half[panels], parts, distance, cosine[i], sine[i])
