"""Finite elements of the bed between sleepers and ground: a cross-section whose fields go with e^{iβx}.

Right half of the section, 0 ≤ y ≤ b, biquadratic elements, displacements û_x = u_x/i, u_y, u_z. With û_x the
matrices are real but for damping, symmetric, and of second degree in β:

    D(β, ω) = K0 + β K1 + β² K2 − ω² M

The top moves as the rigid sleepers do: U along the track, W downwards. On the ground rest strips, one under
each column of elements; f are the forces per length with which they push the ground. What the track and the
ground need of all this is a small symmetric matrix. It is smooth in β and ω, whatever the ground: factorised
at some tens of wavenumbers and a few frequencies, it is interpolated between them.
"""

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad

from railvib import cost
from railvib.numerics.refinement import Panels, halve
from railvib.numerics.wavenumber_panels import BARYCENTRIC, NODE, ORDER, nodes_between, series_tails
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.track import Track

_MOST_HALVINGS = 6
_FEWEST_FREQUENCIES, _MOST_FREQUENCIES = 4, 64


class SolidBed:
    """The assembled cross-section of a track's bed."""

    def __init__(self, track: Track, section: CrossSection, edge: np.ndarray) -> None:
        self.columns = edge.size - 1
        heights = section.layer_height * np.arange(len(track.bed) * section.rows + 1) / section.rows
        mesh = MeshQuad.init_tensor(edge, heights)
        basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=4)
        layer = np.minimum(
            (np.asarray(basis.global_coordinates())[1] / section.layer_height).astype(int), len(track.bed) - 1
        )
        loss = np.array([1.0 + 1j * each.loss_factor for each in track.bed])
        modulus = loss * [section.constrained_modulus(track, each) for each in track.bed]
        nu = section.poisson_ratio
        material = {
            "lame": (modulus * nu / (1.0 - nu))[layer],
            "shear": (modulus * (1.0 - 2.0 * nu) / (2.0 - 2.0 * nu))[layer],
            "density": np.array([section.density(track, each) for each in track.bed])[layer],
        }
        self._stiffness = [
            BilinearForm(form, dtype=complex).assemble(basis, **material)
            for form in (_constant, _linear, _square)
        ]
        self._mass = BilinearForm(_mass, dtype=complex).assemble(basis, **material)
        bottom = float(heights[-1])
        base = np.zeros((3 * self.columns, basis.N))
        centres = mesh.p[:, mesh.facets].mean(axis=1)
        for strip in range(self.columns):
            (facet,) = np.flatnonzero(
                np.isclose(centres[1], bottom) & (centres[0] > edge[strip]) & (centres[0] < edge[strip + 1])
            )
            under = FacetBasis(mesh, basis.elem, facets=np.array([facet]), intorder=4)
            for axis in range(3):
                force = LinearForm(lambda v, w, axis=axis: v[axis]).assemble(under)
                base[axis * self.columns + strip] = force / (edge[strip + 1] - edge[strip])
        top = basis.get_dofs(lambda x: np.isclose(x[1], 0.0))
        middle = basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all("u^2")
        boundary = np.union1d(top.all(), middle)
        self._interior = np.setdiff1d(np.arange(basis.N), boundary)
        self._boundary = boundary
        motions = [np.isin(boundary, top.all(component)) for component in ("u^1", "u^3")]
        self._rigid = np.stack(motions, axis=1) * 1.0
        self._base = base[:, self._interior]

    def condense(self, beta: float, omega: float) -> np.ndarray:
        """Return the bed's small matrix at one wavenumber and frequency, complex (3n + 2, 3n + 2).

        For forces f on the ground and motion q = (U, W) of the top: the base's average displacements are
        T q − F f, the force on the top S q + Tᵀ f; the matrix is [F, T; Tᵀ, S].
        """
        k0, k1, k2 = self._stiffness
        dynamic = (k0 + beta * k1 + beta**2 * k2 - omega**2 * self._mass).tocsr()
        inner = dynamic[self._interior]
        drive = inner[:, self._boundary] @ self._rigid
        right = np.concatenate([self._base.T, -drive], axis=1)
        factors = splu(
            inner[:, self._interior].tocsc(),
            permc_spec="MMD_AT_PLUS_A",  # the matrix is symmetric
            diag_pivot_thresh=0.01,
            options={"SymmetricMode": True},
        )
        solved = factors.solve(right)
        flexibility = self._base @ solved
        n = self._base.shape[0]
        out = np.empty((n + 2, n + 2), complex)
        out[:n] = flexibility
        out[n:, :n] = flexibility[:, n:].T
        outer = dynamic[self._boundary]
        out[n:, n:] = self._rigid.T @ (
            outer[:, self._boundary] @ self._rigid + outer[:, self._interior] @ solved[:, n:]
        )
        return out


class CondensedBed:
    """The condensed form of a bed, interpolated over a range of frequencies and wavenumbers.

    Parameters
    ----------
    bed
        The assembled cross-section.
    frequencies
        Lowest and highest frequency, Hz.
    largest
        Largest wavenumber, rad/m.
    tolerance
        Error allowed, relative to the largest entries of a row and a column.
    """

    def __init__(
        self, bed: SolidBed, frequencies: tuple[float, float], largest: float, tolerance: float = 1e-6
    ) -> None:
        self._squares = (2.0 * np.pi * np.array(frequencies)) ** 2
        with cost.stage("track sections") as spent:
            edges, values = _resolve(bed, float(np.sqrt(self._squares[1])), largest, tolerance)
            spent.kernel_calls += 1
            self.edge = edges
            beta = nodes_between(edges)
            scale = _scale(values)
            count = _FEWEST_FREQUENCIES
            while True:
                x = chebyshev.chebpts1(count)
                omega = np.sqrt(self._squares.mean() + 0.5 * np.ptp(self._squares) * x)
                values = np.array([[bed.condense(b, w) for b in beta] for w in omega])
                spent.kernel_calls += beta.size * count
                coefficient = np.einsum(
                    "kw,wnij->knij", np.linalg.inv(chebyshev.chebvander(x, count - 1)), values
                )
                self.error = float((np.abs(coefficient[-2:]) / scale).max())
                if self.error <= tolerance or count >= _MOST_FREQUENCIES:
                    break
                count *= 2
        self._coefficient = coefficient.reshape(count, edges.size - 1, ORDER, -1)
        self._size = values.shape[-1]

    def at(self, beta: np.ndarray, omega: float) -> np.ndarray:
        """Return the condensed matrices at wavenumbers (n,) and a frequency, complex (n, 3m + 2, 3m + 2)."""
        x = 2.0 * (omega**2 - self._squares.mean()) / np.ptp(self._squares)
        table = np.tensordot(
            chebyshev.chebvander(np.array([x]), len(self._coefficient) - 1)[0], self._coefficient, 1
        )
        panel = np.clip(np.searchsorted(self.edge, beta, side="right") - 1, 0, self.edge.size - 2)
        out = np.empty((beta.size, table.shape[-1]), complex)
        for index in np.unique(panel):
            inside = panel == index
            low, high = self.edge[index : index + 2]
            away = (2.0 * beta[inside] - low - high)[:, None] / (high - low) - NODE
            exact = away == 0.0
            weight = BARYCENTRIC / np.where(exact, 1.0, away)
            hit = exact.any(axis=1)
            weight[hit] = exact[hit]
            out[inside] = (weight / weight.sum(axis=1, keepdims=True)) @ table[index]
        return out.reshape(beta.size, self._size, self._size)


def _scale(values: np.ndarray) -> np.ndarray:
    """Return the size of entries: the geometric mean of the largest diagonal ones in their row and column."""
    diagonal = np.sqrt(np.abs(np.einsum("...ii->...i", values)).reshape(-1, values.shape[-1]).max(axis=0))
    return np.asarray(diagonal[:, None] * diagonal)


def _resolve(bed: SolidBed, omega: float, largest: float, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges of panels over β that resolve one frequency's matrices, and these matrices."""
    resolved: list[tuple[Panels, np.ndarray]] = []

    def check(panels: Panels) -> tuple[np.ndarray, np.ndarray]:
        values = np.array([[bed.condense(b, omega) for b in nodes_between(edge)] for edge in panels.edges])
        size = _scale(np.concatenate([*(value for _panels, value in resolved), values]))
        last = series_tails(values.transpose(0, 2, 3, 1))[..., 0]
        return values, np.asarray((last > tolerance * size).any(axis=(1, 2)))

    for part in halve(Panels.between(np.linspace(0.0, largest, 3)), check, _MOST_HALVINGS):
        resolved.append(part)
    low = np.concatenate([panels.low for panels, _values in resolved])
    values = np.concatenate([values for _panels, values in resolved])
    order = np.argsort(low)
    return np.append(low[order], largest), values[order].reshape(-1, *values.shape[2:])


def _strain(u: Any, beta_free: bool) -> tuple[Any, ...]:
    """Return strains xx, yy, zz, yz, xy/i, xz/i: of the gradient alone, or what goes with β."""
    if beta_free:
        du = u.grad
        return 0.0 * u[0], du[1, 0], du[2, 1], du[2, 0] + du[1, 1], du[0, 0], du[0, 1]
    zero = 0.0 * u[0]
    return -u[0], zero, zero, zero, u[1], u[2]


def _energy(u: Any, v: Any, w: Any, u_free: bool, v_free: bool) -> Any:
    a, b = _strain(u, u_free), _strain(v, v_free)
    normal = sum(2.0 * a[i] * b[i] for i in range(3))
    shear = sum(a[i] * b[i] for i in range(3, 6))
    return w["lame"] * (a[0] + a[1] + a[2]) * (b[0] + b[1] + b[2]) + w["shear"] * (normal + shear)


def _constant(u: Any, v: Any, w: Any) -> Any:
    return _energy(u, v, w, True, True)


def _linear(u: Any, v: Any, w: Any) -> Any:
    return _energy(u, v, w, True, False) + _energy(u, v, w, False, True)


def _square(u: Any, v: Any, w: Any) -> Any:
    return _energy(u, v, w, False, False)


def _mass(u: Any, v: Any, w: Any) -> Any:
    return w["density"] * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2])
