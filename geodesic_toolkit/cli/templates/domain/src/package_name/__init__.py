"""A kind of domain for geodesic-toolkit, straight wires in space, and its operator."""

from dataclasses import dataclass
from typing import ClassVar, NoReturn, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidDomainError,
    InvalidOptionError,
    UnsupportedDomainError,
)

__all__ = ["WireLaplacian", "Wires"]

Floats = NDArray[np.float64]


@final
class Wires(gt.Domain):
    """Straight wires between points in space.

    Parameters
    ----------
    points : array-like of shape (N, 3)
        The ends of the wires, finite.
    edges : array-like of shape (E, 2)
        The two ends of each wire, as indices of points.

    Raises
    ------
    InvalidDomainError
        Other shapes, a point that is not finite, an end that does not exist, or a wire without
        length. The message has the first index.
    """

    edges: NDArray[np.int64]

    def __init__(self, points: ArrayLike, edges: ArrayLike) -> None:
        ends = np.array(points, dtype=np.float64)
        if ends.ndim != 2 or ends.shape[1] != 3 or not len(ends):
            raise InvalidDomainError(f"points must be of shape (N, 3), not {ends.shape}")
        if not np.isfinite(ends).all():
            bad = int(np.isfinite(ends).all(axis=1).argmin())
            raise InvalidDomainError(f"point {bad} is not finite: {ends[bad].tolist()}")
        self._points = ends
        self.edges = gt.Graph(len(ends), edges).edges  # which refuses edges that are none
        lengths = self.as_graph().lengths
        if not lengths.all():
            raise InvalidDomainError(f"wire {lengths.argmin()} has no length")
        ends.setflags(write=False)

    @property
    def n_vertices(self) -> int:
        """Number of points."""
        return len(self._points)

    @property
    def positions(self) -> Floats:
        """The points, of shape (N, 3)."""
        return self._points

    def _steps(self) -> Floats:
        """Return the vectors along the wires, of shape (E, 3)."""
        steps: Floats = self._points[self.edges[:, 1]] - self._points[self.edges[:, 0]]
        return steps

    def as_graph(self) -> gt.Graph:
        """Return the wires as edges, with their lengths."""
        return gt.Graph(self.n_vertices, self.edges, np.linalg.norm(self._steps(), axis=1))

    def without(self, mask: NDArray[np.bool_]) -> "Wires":
        """Return the wires whose ends are both outside a mask, (N,); points keep their indices."""
        if mask.all():
            raise InvalidOptionError("the mask leaves no wire")
        return Wires(self._points, self.edges[~mask[self.edges].any(axis=1)])

    def closest(self, points: Floats) -> gt.Located:
        """Return the places on the wires that are closest to points in space, (Q, 3)."""
        start, step = self._points[self.edges[:, 0]], self._steps()
        along = np.einsum("qed,ed->qe", points[:, None] - start, step)
        share = np.clip(along / (step**2).sum(axis=1), 0, 1)
        gaps = np.linalg.norm(start + share[..., None] * step - points[:, None], axis=2)
        best = gaps.argmin(axis=1)
        share = share[np.arange(len(points)), best]
        return gt.Located(self.edges[best], np.column_stack([1 - share, share]))

    @classmethod
    def samples(cls) -> "gt.testing.DomainSamples[Wires]":
        """Return wires with known distances, on which the conformance kit measures operators."""
        return gt.testing.DomainSamples(
            kind=Wires,
            families=([_straight(17), _straight(65)], [_ring(20), _ring(80)]),
            generic=_bent(),
            permuted=lambda wires, order: Wires(
                wires.positions[order], np.argsort(order)[wires.edges]
            ),
            united=lambda first, second: Wires(
                np.concatenate([first.positions, second.positions + np.array([10.0, 0.0, 0.0])]),
                np.concatenate([first.edges, second.edges + first.n_vertices]),
            ),
            isolated=lambda wires: Wires(
                np.concatenate([wires.positions, [[0.1, 0.2, 0.3]]]), wires.edges
            ),
            moved=lambda wires, rotation, shift: Wires(
                wires.positions @ rotation.T + shift, wires.edges
            ),
            scaled=lambda wires, factor: Wires(wires.positions * factor, wires.edges),
            degenerate=(
                Wires([[0, 0, 0]], []),
                Wires([[0, 0, 0], [1, 0, 0]], [[0, 1]]),
                Wires([[0, 0, 0], [1, 0, 0]], [[0, 1], [1, 0]]),
            ),
        )


@final
@dataclass(frozen=True, kw_only=True)
class WireLaplacian(gt.LaplaceOperator):
    """Linear elements on wires.

    ``L`` is -Δ, positive semidefinite: the weight of a wire is one over its length. The mass of a
    point is half of the length of its wires.
    """

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (Wires,)

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on wires."""
        self.check_domain(domain)
        assert isinstance(domain, Wires)  # for the type checker; check_domain has raised
        if not len(domain.edges):
            raise UnsupportedDomainError("there is not a single wire: distances need one")
        lengths = domain.as_graph().lengths
        ends = np.bincount(domain.edges.ravel(), minlength=domain.n_vertices)
        mass = np.zeros(domain.n_vertices)
        np.add.at(mass, domain.edges, lengths[:, None] / 2)
        gradient = gt.EdgeGradient(domain.edges, 1 / lengths, mass)
        return gt.Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=float(lengths.mean()),
            boundary=ends == 1,
        )

    def frames(self, domain: gt.Domain, metric: gt.Discretization) -> NoReturn:  # noqa: ARG002
        """Raise an `UnsupportedDomainError`: a line in space has no tangent plane."""
        raise UnsupportedDomainError(f"{domain!r} has no tangent plane: there are no vectors on it")


def _straight(n: int) -> gt.testing.Sample:
    """Return a straight line of n points, with distances from its first."""
    along = np.linspace(0.0, 1.0, n)
    points = np.outer(along, [1.0, 0.0, 0.0])
    return gt.testing.Sample(
        name=f"line, {n} points",
        domain=Wires(points, np.column_stack([np.arange(n - 1), np.arange(1, n)])),
        dim=1,
        positions=along[:, None],
        source=0,
        distance=along,
        spacing=1 / (n - 1),
        measure=1.0,
        error=0.01,
        inner=np.abs(along - 0.5) < 0.3,
    )


def _ring(n: int) -> gt.testing.Sample:
    """Return a regular polygon of n wires in the unit circle, with distances along them."""
    index = np.arange(n)
    angle = 2 * np.pi * index / n
    points = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    side = 2 * np.sin(np.pi / n)
    return gt.testing.Sample(
        name=f"ring, {n} points",
        domain=Wires(points, np.column_stack([index, (index + 1) % n])),
        dim=1,
        positions=points,
        source=0,
        distance=np.minimum(index, n - index) * side,
        spacing=side,
        measure=n * side,
        error=0.05,
    )


def _bent() -> Wires:
    """Return a bent line of unequal wires: a shape without symmetry."""
    along = np.cumsum(1 + 0.3 * np.sin(np.arange(40.0) ** 2)) / 40
    points = np.column_stack([along, along**2, np.sin(3 * along)])
    return Wires(points, np.column_stack([np.arange(39), np.arange(1, 40)]))
