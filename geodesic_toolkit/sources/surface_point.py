"""A point inside a face."""

from dataclasses import dataclass
from typing import final

import numpy as np

from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["SurfacePoint"]


@final
@dataclass(frozen=True)
class SurfacePoint:
    """A point of a triangle mesh, given by its face.

    Parameters
    ----------
    face : int
        Index of the face.
    barycentric : tuple of three floats
        Barycentric coordinates in that face: non-negative, with sum 1.

    Raises
    ------
    InvalidSourceError
        A face that is not an index, or coordinates that are not barycentric.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.SurfacePoint(4, (0.5, 0.5, 0.0))
    SurfacePoint(face=4, barycentric=(0.5, 0.5, 0.0))
    """

    face: int
    barycentric: tuple[float, float, float]

    def __post_init__(self) -> None:
        if isinstance(self.face, bool) or not isinstance(self.face, int | np.integer):
            raise InvalidSourceError(f"face must be an integer index, not {self.face!r}")
        try:
            weights = np.array(self.barycentric, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidSourceError(
                f"barycentric coordinates must be three numbers, not {self.barycentric!r}"
            ) from error
        if weights.shape != (3,) or not (weights >= -1e-9).all() or abs(weights.sum() - 1) > 1e-6:
            raise InvalidSourceError(
                f"barycentric coordinates must be three non-negative numbers with sum 1, "
                f"not {self.barycentric!r}"
            )
        weights = np.maximum(weights, 0.0)
        a, b, c = (weights / weights.sum()).tolist()
        object.__setattr__(self, "face", int(self.face))
        object.__setattr__(self, "barycentric", (a, b, c))
