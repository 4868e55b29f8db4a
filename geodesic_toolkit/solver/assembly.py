"""The parts of a solver, assembled from a shape and its options."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import BoolArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.geometry.seams import Seams, find_seams
from geodesic_toolkit.heat.method import Boundary, HeatMethod
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.refinement.bounds import bounds_of
from geodesic_toolkit.refinement.choice import refinement_of
from geodesic_toolkit.refinement.polyhedra import (
    MOST_FACES,
    MOST_FACES_OF_SUBDIVISIONS,
    small_parts_of,
)
from geodesic_toolkit.registry.catalog import resolve_operator, resolve_solvers

__all__ = ["Assembly", "Operator", "Refine", "Solver", "assembled"]

Operator: TypeAlias = str | type[LaplaceOperator] | LaplaceOperator
Solver: TypeAlias = str | type[LinearSolver] | LinearSolver | dict[str, Any]
Refine: TypeAlias = bool | Literal["auto", "across"]


@dataclass(frozen=True, eq=False)
class Assembly:
    """The parts of a solver.

    Attributes
    ----------
    domain : Domain
    passable : Domain
        The domain without elements of masked vertices.
    operator : LaplaceOperator
    diffusion : LaplaceOperator or None
        The operator of the heat, if it is a different one.
    method : HeatMethod
    mask : ndarray of shape (N,), bool, or None
    whole : Discretization or None
        The discretization of a whole cloud that is partly masked.
    seams : Seams or None
    solver : str, class, instance or dict
        The given linear solver.
    reason : str
        Reason for refinement, or against it, if the choice was left to "auto".
    unusual : str
        Description of an option that may make plain heat wrong on a mesh of any size.
    """

    domain: Domain
    passable: Domain
    operator: LaplaceOperator
    diffusion: LaplaceOperator | None
    method: HeatMethod
    mask: BoolArray | None
    whole: Discretization | None
    seams: Seams | None
    solver: Solver
    reason: str
    unusual: str


def assembled(
    domain: Domain,
    *,
    operator: Operator,
    diffusion: Operator | None,
    time: float | None,
    time_factor: float,
    boundary: Boundary,
    solver: Solver,
    refine: Refine,
    mask: ArrayLike | None,
) -> Assembly:
    """Return the parts of a ``GeodesicSolver`` with these options, which are documented there."""
    measures = resolve_operator(operator, domain)
    flows = None if diffusion is None else resolve_operator(diffusion, domain)
    passable, metric, held, whole = _discretized(measures, domain, mask)
    own_time = time is not None or time_factor != 1.0
    choice, reason = _refinement(refine, metric, heat_is_meant=own_time or flows is not None)
    refined = False if choice == "across" else choice
    heat_solver, poisson_solver = resolve_solvers(solver, passable.n_vertices, refine=refined)
    seams = (
        find_seams(passable.vertices, passable.faces, metric.boundary)
        if isinstance(passable, TriangleMesh)
        else None
    )
    on = metric.subdivision
    surface, in_triangles = (passable, metric) if on is None else (on.mesh, on.metric)
    most = MOST_FACES if on is None else MOST_FACES_OF_SUBDIVISIONS
    small_parts = small_parts_of(surface, in_triangles.components, most) if refined else None
    if small_parts is not None:
        reason += f"; exact on components of up to {most} faces"
    method = HeatMethod(
        metric,
        diffusion=measures.diffusion(metric)
        if flows is None
        else _discretized(flows, domain, mask)[1],
        time=time,
        time_factor=time_factor,
        boundary=boundary,
        heat_solver=heat_solver,
        poisson_solver=poisson_solver,
        refine=refined,
        across=choice == "across",
        bounds=bounds_of(surface, in_triangles) if refined else None,
        small_parts=small_parts,
    ).prepare()
    return Assembly(
        domain=domain,
        passable=passable,
        operator=measures,
        diffusion=flows,
        method=method,
        mask=held,
        whole=whole,
        seams=seams,
        solver=solver,
        reason=reason,
        unusual=_unusual(boundary, own_time=own_time),
    )


def _discretized(
    operator: LaplaceOperator, domain: Domain, mask: ArrayLike | None
) -> tuple[Domain, Discretization, BoolArray | None, Discretization | None]:
    """Return the passable domain, its discretization, the mask, and that of a whole cloud."""
    if mask is None:
        operator.check_domain(domain)
        return domain, operator.assemble(domain), None, None
    from geodesic_toolkit.solver.masks import (
        as_mask,
        assembled_without,
        passable_part,
        with_duplicates,
    )

    held = with_duplicates(domain, as_mask(mask, domain.n_vertices))
    metric, whole = assembled_without(operator, domain, held)
    return passable_part(domain, held), metric, held, whole


def _refinement(choice: Any, metric: Discretization, *, heat_is_meant: bool) -> tuple[Any, str]:
    """Return the kind of refinement, with the reason if the choice is left to "auto"."""
    if isinstance(choice, bool | np.bool_):
        return ("across" if choice and metric.fronts is not None else choice), ""
    if isinstance(choice, str) and choice == "across":
        if metric.across_edges is None and metric.fronts is None:
            raise InvalidOptionError(
                'refine="across" is for graphs and the "uniform" operator, and for operators that '
                "bring fronts"
            )
        return "across", ""
    if not isinstance(choice, str) or choice != "auto":
        raise InvalidOptionError(
            f'refine must be True, False or "auto", or "across" on graphs, not {choice!r}'
        )
    return refinement_of(metric, heat_is_meant=heat_is_meant)


def _unusual(boundary: Boundary, *, own_time: bool) -> str:
    """Describe the option that may make plain heat wrong on a mesh of any size; "" if none."""
    if boundary != "neumann":
        return f'with boundary="{boundary}"'
    return "with this time step" if own_time else ""
