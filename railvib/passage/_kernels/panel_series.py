"""Values of panel polynomials at many wavenumbers that ascend."""

from railvib.numerics.jit import fused_kernel
from railvib.numerics.wavenumber_panels import ORDER


@fused_kernel
def evaluate_series(edge, series, kappa, out):
    """Write polynomials over panels of |κ| to `out` (lines, points); 0 beyond the last panel.

    Parameters
    ----------
    edge
        The panels' edges, (lines, panels + 1), rad/m, ascending from 0.
    series
        Coefficients of powers of x from −1 to 1 over each panel, complex (lines, panels, order).
    kappa
        Wavenumbers, (lines, points), rad/m, ascending.
    out
        Complex, (lines, points).
    """
    lines, points = kappa.shape
    panels = edge.shape[1] - 1
    for i in range(lines):
        p = 0
        for k in range(points):
            beta = abs(kappa[i, k])
            if beta >= edge[i, panels]:
                out[i, k] = 0.0
                continue
            while p > 0 and beta < edge[i, p]:
                p -= 1
            while p < panels - 1 and beta >= edge[i, p + 1]:
                p += 1
            x = (2.0 * beta - edge[i, p] - edge[i, p + 1]) / (edge[i, p + 1] - edge[i, p])
            real = series[i, p, ORDER - 1].real
            imag = series[i, p, ORDER - 1].imag
            for n in range(ORDER - 2, -1, -1):
                real = real * x + series[i, p, n].real
                imag = imag * x + series[i, p, n].imag
            out[i, k] = complex(real, imag)
