"""Ground, and track on it, by finite elements with perfectly matched layers: no method of the package's.

A cross-section (y, z) right of the centre line, fields e^{iβx}, three displacements as they are (nothing
turned by 90°), biquadratic elements. In the outer layers the coordinates are stretched into the complex
plane, dy → s dy with s = 1 + a (1 − i) ξ², so that waves that leave decay.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bmat, csr_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad

from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track


@dataclass(frozen=True)
class Extent:
    """Size of the section, m: the plain part to the side and below, the absorbing layer, and the elements."""

    width: float
    depth: float
    absorbing: float
    size: float
    strength: float = 18.0
    absorbing_elements: int = 7


def _lines(start: float, end: float, size: float) -> np.ndarray:
    return np.linspace(start, end, max(int(np.ceil((end - start) / size)), 1) + 1)


def _grid(points: list[float], sizes: list[float]) -> np.ndarray:
    """Return grid lines between points, each interval with its own element size."""
    parts = [
        _lines(low, high, size)[:-1] for low, high, size in zip(points[:-1], points[1:], sizes, strict=True)
    ]
    return np.append(np.concatenate(parts), points[-1])


class GroundSection:
    """The ground's section under strips, with or without a track's bed on top, at one β and frequency."""

    def __init__(
        self,
        ground: Ground,
        edge: np.ndarray,
        beta: float,
        frequency: float,
        extent: Extent,
        bed: tuple[Track, CrossSection] | None = None,
    ) -> None:
        self.edge, self.omega, self.beta = edge, 2.0 * np.pi * frequency, beta
        b = float(edge[-1])
        y = _grid(
            [b, extent.width, extent.width + extent.absorbing],
            [extent.size, extent.absorbing / extent.absorbing_elements],
        )
        beside = b + np.minimum(np.diff(edge)[::-1].cumsum(), extent.size)  # small elements outside, too
        y = np.unique(np.round(np.concatenate([edge, beside, y]), 9))
        y = y[np.concatenate([[True], np.diff(y) > 1e-3])]
        depths = np.cumsum([layer.thickness for layer in ground.layers if layer.thickness is not None])
        near = 0.25
        points = sorted({0.0, near, *depths, extent.depth})
        z = _grid(
            [*points, extent.depth + extent.absorbing],
            [0.06 if high <= near else extent.size for high in points[1:]]
            + [extent.absorbing / extent.absorbing_elements],
        )
        height = 0.0
        if bed is not None:
            height = bed[1].layer_height
            z = np.concatenate([-height * np.linspace(1.0, 0.0, bed[1].rows + 1)[:-1], z])
        mesh = MeshQuad.init_tensor(y, z)
        centre = mesh.p[:, mesh.t].mean(axis=1)
        mesh = mesh.remove_elements(np.flatnonzero((centre[1] < 0.0) & (centre[0] > b)))
        basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=4)
        at = np.asarray(basis.global_coordinates())
        middle = at.mean(axis=2)
        layer = np.searchsorted(depths, middle[1])
        values = np.array(
            [
                (
                    each.density * each.dilatational_speed**2 * (1.0 + 1j * each.loss_factor),
                    each.shear_modulus * (1.0 + 1j * each.loss_factor),
                    each.density,
                )
                for each in ground.layers
            ]
        )[layer]
        if bed is not None:
            track, section = bed
            (ballast,) = track.bed
            constrained = ballast.stiffness * height / track.contact_width * (1.0 + 1j * ballast.loss_factor)
            nu = section.poisson_ratio
            values[middle[1] < 0.0] = (
                constrained,
                constrained * (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)),
                ballast.mass / (height * track.contact_width),
            )
        material = {
            name: np.repeat(values[:, i : i + 1], at.shape[2], axis=1)
            for i, name in enumerate(("constrained", "shear", "density"))
        }
        for i, (name, start) in enumerate((("sy", extent.width), ("sz", extent.depth))):
            inside = np.maximum(at[i] - start, 0.0) / extent.absorbing
            material[name] = 1.0 + extent.strength * (1.0 - 1j) * inside**2
        stiffness = BilinearForm(_stiffness, dtype=complex).assemble(basis, beta=beta, **material)
        mass = BilinearForm(_mass, dtype=complex).assemble(basis, **material)
        self.basis = basis
        self._dynamic = (stiffness - self.omega**2 * mass).tocsr()
        far = basis.get_dofs(lambda x: np.isclose(x[0], y[-1]) | np.isclose(x[1], z[-1])).all()
        middle_plane = basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all("u^2")
        self._fixed = np.union1d(far, middle_plane)
        self._top = basis.get_dofs(lambda x: np.isclose(x[1], -height)) if bed is not None else None

    def strips(self, receivers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what `strip_flexibility` and `receiver_flexibility` give, in true components."""
        n = self.edge.size - 1
        mesh = self.basis.mesh
        centre = mesh.p[:, mesh.facets].mean(axis=1)
        load = np.zeros((self.basis.N, 3 * n), complex)
        for strip in range(n):
            low, high = self.edge[strip : strip + 2]
            (facets,) = np.nonzero(np.isclose(centre[1], 0.0) & (centre[0] > low) & (centre[0] < high))
            on = FacetBasis(mesh, self.basis.elem, facets=facets, intorder=4)
            for axis in range(3):
                load[:, axis * n + strip] = LinearForm(lambda v, w, axis=axis: v[axis]).assemble(on) / (
                    high - low
                )
        free = np.setdiff1d(np.arange(self.basis.N), self._fixed)
        solved = np.zeros_like(load)
        solved[free] = splu(self._dynamic[free][:, free].tocsc()).solve(load[free])
        place = []
        for y in receivers:
            (found,) = np.nonzero(np.isclose(mesh.p[1], 0.0) & np.isclose(mesh.p[0], y))
            place.append(self.basis.nodal_dofs[2, found[0]])
        return load.T @ solved, solved[place]

    def rail(self, track: Track) -> complex:
        """Return the rails' displacement per load on both, with sleepers, pads and rails on the bed."""
        free = np.setdiff1d(np.arange(self.basis.N), self._fixed)
        along, down = (
            np.isin(np.arange(self.basis.N), self._top.all(name)).astype(float) for name in ("u^1", "u^3")
        )
        inner = np.setdiff1d(free, self._top.all())
        tie = csr_matrix(np.stack([along, down], axis=1))
        pick = csr_matrix((np.ones(inner.size), (inner, np.arange(inner.size))), (self.basis.N, inner.size))
        reduced = bmat([[pick, tie]]).tocsc()
        matrix = (reduced.T @ self._dynamic @ reduced).tolil()
        size = matrix.shape[0]
        w2 = self.omega**2
        matrix[size - 2, size - 2] -= 0.5 * w2 * track.sleeper_mass
        pad = 0.5 * track.pad_stiffness * (1.0 + 1j * track.pad_loss_factor)
        rail = 0.5 * (
            track.rail_bending_stiffness * (1.0 + 1j * track.rail_loss_factor) * self.beta**4
            - w2 * track.rail_mass
        )
        matrix[size - 1, size - 1] += pad - 0.5 * w2 * track.sleeper_mass
        corner = csr_matrix(([-pad], ([size - 1], [0])), (size, 1))
        whole = bmat([[matrix, corner], [corner.T, csr_matrix([[rail + pad]])]]).tocsc()
        load = np.zeros(size + 1, complex)
        load[-1] = 0.5
        return complex(splu(whole).solve(load)[-1])


def _stiffness(u, v, w):
    def strain(field, sign):
        du = field.grad
        dx = [sign * 1j * w["beta"] * field[i] for i in range(3)]
        dy = [du[i, 0] / w["sy"] for i in range(3)]
        dz = [du[i, 1] / w["sz"] for i in range(3)]
        return dx[0], dy[1], dz[2], dz[1] + dy[2], dz[0] + dx[2], dy[0] + dx[1]

    a, b = strain(u, 1.0), strain(v, -1.0)
    lame = w["constrained"] - 2.0 * w["shear"]
    energy = lame * (a[0] + a[1] + a[2]) * (b[0] + b[1] + b[2])
    energy = energy + 2.0 * w["shear"] * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    energy = energy + w["shear"] * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
    return energy * w["sy"] * w["sz"]


def _mass(u, v, w):
    return w["density"] * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * w["sy"] * w["sz"]
