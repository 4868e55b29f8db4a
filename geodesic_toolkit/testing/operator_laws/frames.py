"""Tangent frames and turns, which make vectors at different vertices comparable."""

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import Frames
from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.figures import ALGEBRA, relative
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject
from geodesic_toolkit.testing.samples import Sample
from geodesic_toolkit.testing.shapes import pyramid
from geodesic_toolkit.vector_heat.connection import connection_laplacian

__all__ = ["FRAME_LAWS"]

LENGTH = 1e-12
"""For lengths and right angles."""

COVARIANCE = 1e-6
"""For the same shape seen otherwise."""


def _frames(subject: OperatorSubject, domain: Domain, metric: Discretization) -> Frames | None:
    """Return the frames of a domain, None where the operator refuses it by name."""
    try:
        return subject.recipe.frames(domain, metric)
    except UnsupportedDomainError:
        return None


def _cases(subject: OperatorSubject) -> Iterator[tuple[Sample, Discretization, Frames]]:
    """Iterate over the samples that have frames."""
    for sample, discretization in subject.cases():
        frames = _frames(subject, sample.domain, discretization)
        if frames is not None:
            yield sample, discretization, frames


def frames_are_orthonormal(subject: OperatorSubject) -> Iterable[Measured]:
    """Normals and axes have length 1 and are at right angles (largest difference)."""
    for sample, _, frames in _cases(subject):
        triads = np.stack([frames.x_axes, frames.y_axes, frames.normals], axis=1)
        products = np.einsum("nad,nbd->nab", triads, triads)
        yield Measured(float(np.abs(products - np.eye(3)).max()), LENGTH, sample.name)


def turns_have_length_one(subject: OperatorSubject) -> Iterable[Measured]:
    """There is a turn for each corner of each element, of length 1 (largest difference).

    The connection Laplacian ``G_cᴴ W G_c`` is Hermitian and positive semidefinite then.
    """
    for sample, discretization, frames in _cases(subject):
        gradient = discretization.gradient
        if isinstance(gradient, ElementGradient) and frames.turns.shape != gradient.elements.shape:
            found = f"{sample.name}: turns {frames.turns.shape}, not {gradient.elements.shape}"
            yield Measured(1.0, 0.0, found)
            continue
        yield Measured(float(np.abs(np.abs(frames.turns) - 1).max()), LENGTH, sample.name)


def in_the_plane_transport_changes_nothing(subject: OperatorSubject) -> Iterable[Measured]:
    """On a flat sample ``L_c`` of a vector that is the same everywhere is 0 (relative)."""
    for sample, discretization, frames in _cases(subject):
        flat = sample.inner is not None and sample.dim == 2
        if not flat or not sample.domain.has("positions"):
            continue
        positions = sample.domain.positions
        _, _, axes = np.linalg.svd(positions - positions.mean(axis=0))
        field = frames.to_frames(np.tile(axes[0], (len(positions), 1)))
        matrix = connection_laplacian(discretization, frames).scipy
        scale = float(np.bincount(matrix.indices, np.abs(matrix.data)).max())
        off = np.abs(np.asarray(matrix @ field))
        yield Measured(float(off.max()) / scale, ALGEBRA, sample.name)


def holonomy_is_the_angle_defect(subject: OperatorSubject) -> Iterable[Measured]:
    """Round the tip of a pyramid a vector turns by what the angles there lack of 2π (difference).

    For operators on meshes that have triangles.
    """
    if TriangleMesh not in subject.recipe.domains:
        return
    sides, height = 7, 0.8
    mesh = pyramid(sides, 3, height=height)
    discretization = subject.recipe.assemble(mesh)
    gradient, frames = discretization.gradient, _frames(subject, mesh, discretization)
    if frames is None or not (isinstance(gradient, ElementGradient) and gradient.of_planes):
        return
    angle = 0.0
    for j in range(sides):
        here, there = 1 + j, 1 + (j + 1) % sides
        around = [(gradient.elements == vertex).any(axis=1) for vertex in (0, here, there)]
        row = np.flatnonzero(np.all(around, axis=0))[0]
        before, after = (frames.turns[row, gradient.elements[row] == v][0] for v in (here, there))
        angle += float(np.angle(before * after.conjugate()))
    tip = sides * np.arccos((np.cos(2 * np.pi / sides) + height**2) / (1 + height**2))
    off = float(abs(np.exp(1j * (angle + tip)) - 1))
    yield Measured(off, ALGEBRA, "a pyramid of seven sides")


def moving_the_shape_moves_its_frames(subject: OperatorSubject) -> Iterable[Measured]:
    """A rigid motion turns normals along, up to their sign, and leaves ``|L_c|`` (relative)."""
    for kind in subject.samples:
        if kind.moved is None:
            continue
        rotation = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
        moved = kind.moved(kind.generic, rotation, np.array([1.0, -2.0, 0.5]))
        both = []
        for domain in (kind.generic, moved):
            metric = subject.recipe.assemble(domain)
            frames = _frames(subject, domain, metric)
            if frames is not None:
                sizes = np.abs(connection_laplacian(metric, frames).entries.view(complex))
                both.append((frames.normals, sizes))
        if len(both) == 2:
            (normals, sizes), (seen, seen_sizes) = both
            turned = np.abs(np.einsum("nd,nd->n", normals @ rotation.T, seen))
            figure = max(float(1 - turned.min()), relative(seen_sizes, sizes))
            yield Measured(figure, COVARIANCE, kind.kind.__name__)


FRAME_LAWS = (
    frames_are_orthonormal,
    turns_have_length_one,
    in_the_plane_transport_changes_nothing,
    holonomy_is_the_angle_defect,
    moving_the_shape_moves_its_frames,
)
