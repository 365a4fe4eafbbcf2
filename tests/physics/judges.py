"""Slow, plain and independent computations that judge the package's: nothing here uses its fits or tables."""

import math
from collections.abc import Sequence
from decimal import Decimal, localcontext

import numba
import numpy as np
from scipy.special import iti0k0

from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import Track
from railvib.soil._kernels.layers import surface_flexibility
from railvib.transfer.track_response import track_response
from tests.physics.long_arithmetic import Long, solve

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803")


def random_ground(rng: np.random.Generator, most_layers: int = 5, base: str = "half-space") -> Ground:
    """Return a ground with inversions and crusts: cs 80-600 m/s, cp/cs 1.5-8, loss factors 0.01-0.2."""
    count = int(rng.integers(1, most_layers + 1))
    layers = []
    for number in range(count):
        shear = float(np.exp(rng.uniform(np.log(80.0), np.log(600.0))))
        layers.append(
            Layer(
                shear_speed=shear,
                dilatational_speed=shear * float(np.exp(rng.uniform(np.log(1.5), np.log(8.0)))),
                density=float(rng.uniform(1500.0, 2200.0)),
                loss_factor=float(np.exp(rng.uniform(np.log(0.01), np.log(0.2)))),
                thickness=(
                    None
                    if base == "half-space" and number == count - 1
                    else float(np.exp(rng.uniform(np.log(0.3), np.log(15.0))))
                ),
            )
        )
    return Ground(layers=layers, base=base)


def flexibility_by_global_matrix(
    ground: Ground, wavenumber: complex, frequency: float, digits: int = 60
) -> complex:
    """Return Q33 from `psv_by_global_matrix`."""
    return complex(psv_by_global_matrix(ground, wavenumber, frequency, digits, ["z"])[1, 0])


def psv_by_global_matrix(
    ground: Ground, wavenumber: complex, frequency: float, digits: int = 60, loads: Sequence[str] = ("x", "z")
) -> np.ndarray:
    """Return displacements u_x, u_z (rows) per surface stress along x and z (columns), m/Pa, from the
    potentials of all layers and all conditions between them, solved as one system in long arithmetic.

    Displacements u_x = ik φ − ψ', u_z = φ' + ik ψ, z downward; φ and ψ are sums of one wave from each side
    of a layer.
    """
    with localcontext() as context:
        context.prec = digits
        k = Long(complex(wavenumber))
        ik = Long(1j) * k
        omega2 = Long((2 * PI * Decimal(frequency)) ** 2)
        media = []
        for layer in ground.layers:
            loss = Long(Decimal(1), Decimal(layer.loss_factor))
            cs2 = loss * Decimal(layer.shear_speed) ** 2
            cp2 = loss * Decimal(layer.dilatational_speed) ** 2
            p, s = (k * k - omega2 / cp2).sqrt(), (k * k - omega2 / cs2).sqrt()
            density = Decimal(layer.density)
            lame = (cp2 - cs2 * 2) * density * omega2 / cp2  # λ k_p²
            media.append(
                (p, s, cs2 * density, lame, None if layer.thickness is None else Decimal(layer.thickness))
            )

        def state(medium: tuple, depth: Decimal) -> list[tuple[Long, ...]]:
            """Columns: P and S from above, P and S from below; each u_x, u_z, τ_xz, σ_zz at a depth in the
            layer.
            """
            p, s, shear, lame, thickness = medium
            columns = []
            for sign in (-1,) if thickness is None else (-1, 1):
                travelled = depth if sign == -1 else thickness - depth
                phi, psi = (p * -travelled).exp(), (s * -travelled).exp()
                phi_slope, psi_slope = p * phi * sign, s * psi * sign
                columns.append(
                    (ik * phi, phi_slope, shear * ik * phi_slope * 2, (shear * p * p * 2 - lame) * phi)
                )
                columns.append(
                    (-psi_slope, ik * psi, -shear * (s * s + k * k) * psi, shear * ik * psi_slope * 2)
                )
            return columns

        # Stresses are divided by a common scale, or the pivots of the elimination would be poor.
        scale = Long(abs(media[0][2]) * max(abs(k), Decimal("1e-6")))
        units = (Long(1), Long(1), scale, scale)
        size = sum(2 if medium[4] is None else 4 for medium in media)
        surface = state(media[0], Decimal(0))
        matrix = [[Long(0)] * size for _ in range(size)]
        for column, values in enumerate(surface):
            matrix[0][column], matrix[1][column] = values[2] / scale, values[3] / scale
        row, first = 2, 0
        for above, below in zip(media, [*media[1:], None], strict=True):
            if above[4] is None:
                break
            own = state(above, above[4])
            other = [] if below is None else state(below, Decimal(0))
            conditions = 2 if below is None else 4  # on a rigid base the displacements vanish
            for i in range(conditions):
                for column, values in enumerate(own):
                    matrix[row + i][first + column] = values[i] / units[i]
                for column, values in enumerate(other):
                    matrix[row + i][first + 4 + column] = -values[i] / units[i]
            row, first = row + conditions, first + 4
        flexibility = np.empty((2, len(loads)), complex)
        for place, load in enumerate(loads):
            right = [Long(0)] * size
            right["xz".index(load)] = -Long(1) / scale
            amplitude = solve(matrix, right)
            for i in range(2):
                flexibility[i, place] = complex(
                    sum((values[i] * amplitude[column] for column, values in enumerate(surface)), Long(0))
                )
        return flexibility


_NODE, _WEIGHT = np.polynomial.legendre.leggauss(8)


@numba.njit(error_model="numpy")
def _remainders(beta, omega, stack, rigid, b, static, c, largest, smallest, last, growth):
    """Return (1/π) ∫ [Q33 − static/√(γ² + c²)] sin(γb)/(γb) dγ from 0 to `last`, on panels that grow
    geometrically.
    """
    out = np.zeros(beta.shape[0], np.complex128)
    for i in range(beta.shape[0]):
        low = 0.0
        high = smallest[i]
        while low < last[i]:
            half = 0.5 * (high - low)
            for j in range(8):
                gamma = low + half * (1.0 + _NODE[j])
                rho = np.sqrt(beta[i] * beta[i] + gamma * gamma)
                q = surface_flexibility(rho, omega[i], stack, rigid) - static / np.sqrt(
                    gamma * gamma + c[i] * c[i]
                )
                out[i] += half * _WEIGHT[j] * q * np.sin(gamma * b) / (gamma * b)
            low = high
            high += min(growth * low if low < 1.3 * largest[i] else 0.5 * low, 2.0 / b)
    return out / np.pi


def centre_compliances(ground: Ground, half_width: float, beta: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return C(β, 0, ω) from Q33 along the real axis, panels fine against the damped peaks; its static part
    in closed form.

    Nothing is shared with `railvib.soil.quadrature` but Q33. What is cut off far out leaves errors of 1e-6.
    The path must stay on the axis: layers on a rigid base carry backward waves, whose poles lie on the other
    side of it.
    """
    b, beta, w = half_width, np.abs(beta), np.abs(omega)
    top = ground.layers[0]
    static = (1.0 - top.poisson_ratio) / (top.shear_modulus * (1.0 + 1j * top.loss_factor))
    c = np.hypot(beta, 1.0 / b)
    largest = w / min(ground.wave_speeds())
    smallest = 5e-2 * np.clip(w / max(ground.wave_speeds()), 1e-6, 0.5 / b)
    last = np.maximum(max(100.0 / b, 25.0 / (top.thickness or np.inf)), 16.0 * largest)
    growth = 1.3 * min(layer.loss_factor for layer in ground.layers)
    value = _remainders(
        beta, w, ground.stack(), ground.base == "rigid", b, static, c, largest, smallest, last, growth
    )
    value += static * iti0k0(c * b)[1] / (np.pi * b * c)
    return np.where(omega >= 0.0, value, value.conj())


def receptance_by_quadrature(
    ground: Ground,
    track: Track,
    frequency: float,
    distances: np.ndarray,
    speed: float,
    tolerance: float = 3e-4,
) -> np.ndarray:
    """Return σ_R(d, ω; v) by adaptive Gauss panels over β, each value from the ground's direct quadrature.

    The tolerance is that of 8 nodes, whose difference from 13 decides; 13 are used, and are good to 2e-5.
    """
    omega = 2.0 * np.pi * frequency
    d = np.asarray(distances, float)
    far = 100.0
    slow = omega / (0.8 * ground.slowest_speed) + 0.3
    edges = {-far, 0.0, far, *(sign * b for sign in (-1.0, 1.0) for b in (2.0, 5.0, 12.0, 30.0))}
    edges |= {float(b) for b in np.linspace(-2.0 * slow, 2.0 * slow, 17)}
    if speed > 0.0 and omega / speed < far:
        edges |= {omega / speed, *(omega / speed + s for s in (-0.5, -0.1, 0.1, 0.5))}
    rules = [np.polynomial.legendre.leggauss(order) for order in (8, 13)]
    low, high = np.array(sorted(edges))[:-1], np.array(sorted(edges))[1:]
    total = np.zeros(d.size, complex)
    for _ in range(25):
        half = 0.5 * (high - low)[:, None]
        estimates = []
        for node, weight in rules:
            beta = low[:, None] + half * (1.0 + node)
            seen = omega - beta * speed
            compliance = centre_compliances(ground, track.half_width, beta.ravel(), seen.ravel()).reshape(
                beta.shape
            )
            rail, _force = track_response(track, beta, seen, compliance)
            estimates.append(np.einsum("pn,pnd->pd", half * weight * rail, np.exp(1j * beta[..., None] * d)))
        scale = np.abs(total + estimates[1].sum(axis=0)).max()
        error = np.abs(estimates[1] - estimates[0]).max(axis=1)
        good = error <= tolerance * scale * np.maximum(half[:, 0] / far, 0.05)
        total = total + estimates[1][good].sum(axis=0)
        if good.all():
            return total / (2.0 * np.pi)
        middle = 0.5 * (low + high)[~good]
        low, high = np.concatenate([low[~good], middle]), np.concatenate([middle, high[~good]])
    raise ArithmeticError("the judge's quadrature does not converge")


def rayleigh_mode_count(ground: Ground, wavenumber: np.ndarray, frequency: float) -> np.ndarray:
    """Return how many Rayleigh modes of the undamped ground have a frequency below this one, at wavenumbers
    (n,) above those of the base's body waves.

    Wittrick and Williams (1971): the negative eigenvalues of the dynamic stiffness of all interfaces, in
    sublayers so thin that none resonates between fixed faces. Over frequency at one wavenumber it counts each
    mode once; over wavenumber at one frequency a mode with energy going backwards counts −1.
    """
    k = np.asarray(wavenumber, float)
    omega = 2.0 * np.pi * frequency
    above = np.zeros((k.size, 2, 2))
    negative = np.zeros(k.size, int)
    for layer in ground.layers:
        if layer.thickness is None:
            above = above + _psv_stiffness(layer, k, omega, None)
            return negative + (np.linalg.eigvalsh(above) < 0.0).sum(axis=1)
        thin = min(0.4 * np.pi * layer.shear_speed / omega, 2.0 / k.max())
        number = math.ceil(layer.thickness / thin)
        stiffness = _psv_stiffness(layer, k, omega, layer.thickness / number)
        for _ in range(number):
            pivot = above + stiffness[:, :2, :2]
            negative += (np.linalg.eigvalsh(pivot) < 0.0).sum(axis=1)
            coupling = stiffness[:, :2, 2:]
            above = stiffness[:, 2:, 2:] - coupling.swapaxes(1, 2) @ np.linalg.solve(pivot, coupling)
    return negative


def _psv_stiffness(layer: Layer, k: np.ndarray, omega: float, thickness: float | None) -> np.ndarray:
    """Return the real dynamic stiffness of a layer's two faces (n, 4, 4), or of a half-space's surface (n, 2,
    2).
    """
    shear = layer.density * layer.shear_speed**2
    lame = layer.density * layer.dilatational_speed**2 - 2.0 * shear
    displacement, traction = [], []
    for speed in (layer.dilatational_speed, layer.shear_speed):
        root = np.sqrt(k**2 - (omega / speed) ** 2 + 0j)
        for q in (-root,) if thickness is None else (-root, root):
            faces = []
            for depth, outward in ((0.0, -1.0), (thickness, 1.0)):
                if depth is None:
                    continue
                wave = np.exp(q * depth)
                # From the potential of the wave and its derivatives over depth; u_x and τ_xz over −i.
                p = np.array([1.0 + 0.0 * q, q, q * q]) * wave * (speed == layer.dilatational_speed)
                s = np.array([1.0 + 0.0 * q, q, q * q]) * wave * (speed == layer.shear_speed)
                u, w = k * p[0] + s[1], p[1] + k * s[0]
                du, dw = k * p[1] + s[2], p[2] + k * s[1]
                stress = shear * (du + k * w), (lame + 2.0 * shear) * dw - lame * k * u
                faces.append((u, w, outward * stress[0], outward * stress[1]))
            displacement.append([part for face in faces for part in face[:2]])
            traction.append([part for face in faces for part in face[2:]])
    u, t = (np.moveaxis(np.array(each), 2, 0).swapaxes(1, 2) for each in (displacement, traction))
    stiffness = (t @ np.linalg.inv(u)).real
    return np.asarray(0.5 * (stiffness + stiffness.swapaxes(1, 2)))
