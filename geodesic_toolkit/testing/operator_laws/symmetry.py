"""Laws of symmetry: the shape with renumbered vertices, moved, or scaled."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.figures import relative
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject
from geodesic_toolkit.testing.samples import DomainSamples

__all__ = ["SYMMETRY_LAWS"]

COVARIANCE = 1e-6
"""Tolerance for the same shape in another form: rounding, after square roots and eigenvectors."""


def permuting_the_vertices_permutes_the_result(subject: OperatorSubject) -> Iterable[Measured]:
    """Renumbered vertices renumber M and L, with no other change (relative)."""
    for kind in subject.samples:
        if kind.permuted is None:
            continue
        order = np.random.default_rng(3).permutation(kind.generic.n_vertices)
        permuted = subject.recipe.assemble(kind.permuted(kind.generic, order))
        yield _same(subject.assemble(kind.generic), permuted, kind, order=order)


def moving_the_shape_changes_nothing(subject: OperatorSubject) -> Iterable[Measured]:
    """A rigid motion does not change M, L and the spacing (relative)."""
    for kind in subject.samples:
        if kind.moved is not None:
            rotation = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
            moved = kind.moved(kind.generic, rotation, np.array([1.0, -2.0, 0.5]))
            yield _same(subject.assemble(kind.generic), subject.recipe.assemble(moved), kind)


def scaling_the_shape_scales_the_result(subject: OperatorSubject) -> Iterable[Measured]:
    """Scaling lengths by s scales the spacing by s and ``M⁻¹L`` by 1/s² (relative)."""
    for kind in subject.samples:
        if kind.scaled is not None:
            for factor in (1e-3, 1e3):
                scaled = subject.recipe.assemble(kind.scaled(kind.generic, factor))
                yield _same(subject.assemble(kind.generic), scaled, kind, factor=factor)


def _same(
    given: Discretization,
    seen: Discretization,
    kind: DomainSamples[Any],
    *,
    order: Any = None,
    factor: float | None = None,
) -> Measured:
    """Return the differences of two discretizations of one shape, in mass, L and spacing.

    Under scaling only ``M⁻¹L`` is compared: M may be an area, or a number of neighbours.
    """
    probe = np.cos(1.0 + np.arange(given.n_vertices) ** 1.5)[:, None]
    order = np.arange(given.n_vertices) if order is None else order
    if factor is None:
        mass = relative(seen.mass, given.mass[order])
        pull = relative(seen.stiffness @ probe[order], (given.stiffness @ probe)[order])
        spacing = abs(seen.spacing / given.spacing - 1)
    else:
        mass, heavy = 0.0, (given.mass > 0) & (seen.mass > 0)
        expected = (given.stiffness @ probe)[heavy] / given.mass[heavy, None]
        scaled = (seen.stiffness @ probe)[heavy] / seen.mass[heavy, None]
        pull = relative(scaled * factor**2, expected)
        spacing = abs(seen.spacing / (factor * given.spacing) - 1)
    figures = {"mass": mass, "stiffness": pull, "spacing": spacing}
    name = max(figures, key=lambda key: figures[key])
    scale = "" if factor is None else f" scaled by {factor:g}"
    return Measured(figures[name], COVARIANCE, f"{name}, {kind.kind.__name__}{scale}")


SYMMETRY_LAWS = (
    permuting_the_vertices_permutes_the_result,
    moving_the_shape_changes_nothing,
    scaling_the_shape_scales_the_result,
)
