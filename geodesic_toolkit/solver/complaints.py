"""Warnings of a solver about its shape: seams, uneven clouds, meshes too coarse for plain heat."""

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import SeamWarning, UnevenCloudWarning
from geodesic_toolkit.refinement.wavefronts import made_of_triangles
from geodesic_toolkit.solver.assembly import Assembly
from geodesic_toolkit.solver.coarseness import Judge
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Complaints"]

MAX_UNEVENNESS_WITHOUT_WARNING = 1.5
"""Scale of a component of a cloud, in mean lengths of its spokes, above which there is a warning of
plain heat. Measured: scan lines, heaps and samples of surfaces have 1, vertices of CAD models and
an airborne tile up to 1.2; sweeps of spinning scanners 1.9 (16 beams) to 40, and then plain heat is
3 to 25 % off."""


class Complaints:
    """The warnings of a solver when it computes distances; safe to use from several threads.

    Parameters
    ----------
    assembly : Assembly
    """

    def __init__(self, assembly: Assembly) -> None:
        self._assembly = assembly
        self._forget()

    def _forget(self) -> None:
        self._judge: Judge | None = None
        self._lock = threading.Lock()

    def warn_where_cut(self, sets: Sequence[SourcePoints]) -> None:
        """Warn if a mesh is cut along seams, with the reach of the first source set."""
        seams, mesh = self._assembly.seams, self._assembly.passable
        if seams is None or not isinstance(mesh, TriangleMesh):
            return
        metric = self._assembly.method.metric
        reached = np.isin(metric.components, sets[0].components(metric))
        used = mesh.used
        warn(
            f"{seams.finding}. The source reaches {np.count_nonzero(reached & used)} of "
            f"{np.count_nonzero(used)} vertices; {seams.cure}",
            SeamWarning,
        )

    def warn_where_off(
        self, sets: Sequence[SourcePoints], distances: FloatArray | Sequence[FloatArray]
    ) -> None:
        """Warn if plain heat is far from the refined distance."""
        mesh, method = self._assembly.passable, self._assembly.method
        if method.refine:
            return
        _warn_where_uneven(method.metric)
        if not (isinstance(mesh, TriangleMesh) and made_of_triangles(method.metric)):
            return
        with self._lock:
            if self._judge is None:
                self._judge = Judge(mesh, method, self._assembly.unusual)
        self._judge.judge(sets, distances)

    def __getstate__(self) -> dict[str, Any]:
        return {"_assembly": self._assembly}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._forget()


def _warn_where_uneven(metric: Discretization) -> None:
    """Warn if a cloud is sampled so unevenly that a single time step is not right everywhere."""
    unevenness = metric.notes.get("unevenness", 1.0)
    if unevenness > MAX_UNEVENNESS_WITHOUT_WARNING:
        warn(
            f"the triangles that cover most of the cloud are {unevenness:.1f} times as large as "
            "most triangles: heat that crosses them is blurred elsewhere, and plain heat can be 10 "
            "% off and more; use refine=True, or thin the cloud to one spacing",
            UnevenCloudWarning,
        )
