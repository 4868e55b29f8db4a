"""Where the vertices of a domain are."""

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains.base import Domain
from geodesic_toolkit.domains.cloud import PointCloud
from geodesic_toolkit.domains.mesh import TriangleMesh

__all__ = ["known_positions"]


def known_positions(domain: Domain) -> FloatArray | None:
    """Return the positions of the vertices, of shape (N, 3); None where there are none.

    Missing points of a cloud are NaN. A graph has no positions.
    """
    if isinstance(domain, TriangleMesh):
        return domain.vertices
    return domain.points if isinstance(domain, PointCloud) else None
