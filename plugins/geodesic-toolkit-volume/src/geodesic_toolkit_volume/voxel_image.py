"""Voxel images as a kind of domain."""

from __future__ import annotations

from functools import cached_property
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.domains.base import as_floats
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError
from geodesic_toolkit_volume.checks import costs_of
from geodesic_toolkit_volume.marching import Floats, Integers

__all__ = ["VoxelImage"]


@final
class VoxelImage(gt.Domain):
    """A body of voxels: boxes in a regular grid, with or without costs.

    Vertices are the centres of all voxels, in the order of ``mask.ravel()``; those outside of the
    body are missing, and infinitely far. ``distance.reshape(image.shape)`` is an image again.

    Parameters
    ----------
    mask : array-like of shape (X, Y, Z) or (X, Y), bool
        True for the voxels of the body.
    spacing : sequence of 3 or 2 floats, optional
        The sides of a voxel along the axes; 1 by default.
    costs : array-like of the shape of the mask, optional
        The cost of a unit of length in each voxel (its slowness), positive in the body; 1 by
        default. Distances are then the least cost: ``|∇φ| = cost``.
    affine : array-like of shape (4, 4), optional
        From indices of voxels to positions, as NIfTI files have it, in the place of `spacing`; its
        axes must be at right angles.

    Attributes
    ----------
    mask : ndarray of shape (X, Y, Z), bool, read-only
    spacing : tuple of three floats
    costs : ndarray of shape (X, Y, Z), float64, read-only, or None
    affine : ndarray of shape (4, 4), float64, read-only
    shape : tuple of ints
        The shape of the mask as given.

    Raises
    ------
    InvalidDomainError
        Wrong shapes, an empty body, a spacing or costs that are not positive and finite, axes that
        are not at right angles.

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_volume import VoxelImage
    >>> image = VoxelImage(np.ones((4, 3, 2), dtype=bool), spacing=(1.0, 1.0, 2.0))
    >>> gt.GeodesicSolver(image).distance(0).reshape(image.shape)[3, 0].round(3)
    array([3.   , 3.606])
    """

    mask: NDArray[np.bool_]
    spacing: tuple[float, ...]
    costs: Floats | None
    affine: Floats
    shape: tuple[int, ...]

    vertex_name = "voxel"

    def __init__(
        self,
        mask: ArrayLike,
        spacing: ArrayLike | None = None,
        costs: ArrayLike | None = None,
        *,
        affine: ArrayLike | None = None,
    ) -> None:
        try:
            check_nothing_masked(mask, "mask", InvalidDomainError, "{}.filled(False)")
            body = np.array(mask)
        except (ValueError, TypeError) as error:
            raise InvalidDomainError(f"mask cannot be read as an array: {error}") from error
        if body.dtype != np.bool_:
            raise InvalidDomainError(
                f"mask must be booleans, not {body.dtype}: of an image of numbers, image > 0"
            )
        if body.ndim not in (2, 3) or not body.any():
            raise InvalidDomainError(
                f"mask of shape {body.shape}, {int(body.sum())} voxels in the body; it must be "
                "(X, Y, Z) or (X, Y), with one voxel or more"
            )
        flat = body.ndim == 2
        if affine is not None and spacing is not None:
            raise InvalidDomainError("give spacing or affine, not both")
        places = np.eye(4) if affine is None else as_floats(affine, "affine", (4, 4))
        if spacing is not None:
            steps = as_floats(spacing, "spacing", (body.ndim,))
            if not (steps > 0).all():
                raise InvalidDomainError(f"spacing is {steps.tolist()}; it must be positive")
            places[:3, :3] = np.diag(np.append(steps, 1.0) if flat else steps)
        sides = _sides(places)
        if costs is not None:
            costs = costs_of(costs, body.shape, "voxel", body)
        shape = (*body.shape, 1) if flat else body.shape
        self._set(
            mask=np.ascontiguousarray(body).reshape(shape),
            spacing=sides,
            costs=None if costs is None else np.asarray(costs).reshape(shape),
            affine=places,
            shape=body.shape,
        )

    @property
    def n_vertices(self) -> int:
        """Number of voxels, those outside of the body among them."""
        return int(self.mask.size)

    @property
    def present(self) -> NDArray[np.bool_]:
        """True for the voxels of the body, of shape (N,)."""
        return self.mask.reshape(-1)

    @property
    def measured_in_space(self) -> bool:
        """True without costs: distances are lengths."""
        return self.costs is None

    @cached_property
    def positions(self) -> Floats:
        """The centres of all voxels, of shape (N, 3)."""
        index = np.indices(self.mask.shape, dtype=np.float64).reshape(3, -1).T
        places = index @ self.affine[:3, :3].T + self.affine[:3, 3]
        places.setflags(write=False)
        return places

    @property
    def edges(self) -> tuple[Integers, Integers]:
        """Pairs of neighbours along an axis in the body, (E, 2), and the axis of each, (E,)."""
        index, mask = np.arange(self.n_vertices).reshape(self.mask.shape), self.mask
        pairs = []
        for axis in range(3):
            one = [slice(None)] * 3
            other = list(one)
            one[axis], other[axis] = slice(None, -1), slice(1, None)
            both = mask[tuple(one)] & mask[tuple(other)]
            pairs.append(np.column_stack([index[tuple(one)][both], index[tuple(other)][both]]))
        axes = np.repeat(np.arange(3), [len(own) for own in pairs])
        return np.concatenate(pairs), axes

    def edge_costs(self, edges: Integers) -> Floats:
        """Return the mean cost of the two voxels of each edge, (E,)."""
        if self.costs is None:
            return np.ones(len(edges))
        return np.asarray(self.costs.ravel()[edges].mean(axis=1))

    def as_graph(self) -> gt.Graph:
        """Return neighbours along the axes, as far apart as their centres cost."""
        edges, axes = self.edges
        lengths = np.array(self.spacing)[axes] * self.edge_costs(edges)
        return gt.Graph(self.n_vertices, edges, lengths)

    def without(self, mask: NDArray[np.bool_]) -> VoxelImage:
        """Return the image without masked voxels."""
        left = self.mask & ~mask.reshape(self.mask.shape)
        if not left.any():
            raise InvalidOptionError("the mask leaves no voxel of the body")
        costs = None if self.costs is None else self.costs.reshape(self.shape)
        return VoxelImage(left.reshape(self.shape), costs=costs, affine=self.affine)

    def closest(self, points: Floats) -> gt.Located:
        """Return places between the centres of eight voxels, else the nearest voxel of the body."""
        inverse = np.linalg.inv(self.affine)
        index = points @ inverse[:3, :3].T + inverse[:3, 3]
        top = np.array(self.mask.shape) - 1
        inside = ((index >= -ROUNDING) & (index <= top + ROUNDING)).all(axis=1)
        index = np.clip(index, 0, top)
        low = np.minimum(index.astype(np.int64), np.maximum(top - 1, 0))
        share = (index - low)[:, None]
        corner = np.array(list(np.ndindex(2, 2, 2)))
        weights = np.where(corner, share, 1 - share).prod(axis=2)
        flat = np.ravel_multi_index(
            tuple(np.moveaxis(np.minimum(low[:, None] + corner, top), 2, 0)), self.mask.shape
        )
        whole = (self.present[flat] | (weights <= ROUNDING)).all(axis=1) & inside
        weights[weights <= ROUNDING] = 0.0
        if not whole.all():
            own, tree = self._tree
            flat[~whole] = own[tree.query(points[~whole])[1]][:, None]
            weights[~whole] = np.eye(8)[0]
        return gt.Located(flat, weights / weights.sum(axis=1, keepdims=True))

    def spans(self, vertices: Integers, weights: Floats) -> Floats:
        """Return the costs of straight lines from places between voxels to these, (P, C).

        See :meth:`geodesic_toolkit.Domain.spans`.
        """
        lengths = super().spans(vertices, weights)
        if self.costs is None:
            return lengths
        costs = np.where(weights > 0, self.costs.ravel()[vertices], 0)
        return np.asarray(lengths * (weights * costs).sum(axis=1)[:, None])

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        own = np.flatnonzero(self.present)
        return own, cKDTree(self.positions[own])

    @classmethod
    def samples(cls) -> Any:
        """Return bodies about which the truth is known."""
        from geodesic_toolkit_volume.samples import voxel_samples

        return voxel_samples()

    def __getstate__(self) -> dict[str, Any]:
        names = ("mask", "spacing", "costs", "affine", "shape")
        return {name: self.__dict__[name] for name in names}

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.shape))
        return f"VoxelImage({shape} voxels, {int(self.mask.sum())} in the body)"


def _sides(affine: Floats) -> tuple[float, ...]:
    """Return the lengths of the axes, which must be at right angles."""
    axes = affine[:3, :3]
    with np.errstate(over="ignore"):
        sides = np.linalg.norm(axes, axis=0)
    if not (np.isfinite(sides).all() and (sides > 0).all()):  # squares over- or underflow
        sides = np.abs(axes).max(axis=0)
    if not (np.isfinite(affine).all() and np.isfinite(sides).all() and (sides > 0).all()):
        raise InvalidDomainError(
            f"the sides of a voxel are {sides.tolist()}; they must be positive and finite"
        )
    axes = axes / sides
    skew = np.abs(axes.T @ axes - np.eye(3)).max()
    if skew > RIGHT_ANGLES:
        raise InvalidDomainError(
            f"the axes of the affine are not at right angles (cosine {skew:.2g}); resample the "
            "image to axes that are"
        )
    return tuple(sides.tolist())


RIGHT_ANGLES = 1e-4
"""Cosine of axes up to which they count as at right angles: NIfTI has single precision."""

ROUNDING = 1e-9
"""Share of a voxel below which a weight is rounding."""
