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

UNEVEN = 1.5
"""Scale of a part of a cloud, in mean lengths of its spokes, from which on plain heat is warned of.
Measured: scan lines, heaps and samples of surfaces have 1, vertices of CAD models and an airborne
tile up to 1.2; sweeps of spinning scanners 1.9 (16 beams) to 40, and then plain heat is 3 to 25 %
off."""


class Complaints:
    """What a solver warns of when it is asked; safe to use from several threads.

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

    def where_cut(self, sets: Sequence[SourcePoints]) -> None:
        """Warn where a mesh is cut along seams, and say how far the first source set comes."""
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

    def where_off(
        self, sets: Sequence[SourcePoints], distances: FloatArray | Sequence[FloatArray]
    ) -> None:
        """Warn where plain heat is far from the refined distance."""
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
    """Warn where a cloud is sampled so unevenly that no time step is right all over it."""
    unevenness = metric.notes.get("unevenness", 1.0)
    if unevenness > UNEVEN:
        warn(
            f"the triangles that cover most of the cloud are {unevenness:.1f} times as large as "
            "most triangles are: heat that gets across them is blurred elsewhere, and plain heat "
            "can be 10 % off and more; use refine=True, or thin the cloud to one spacing",
            UnevenCloudWarning,
        )
