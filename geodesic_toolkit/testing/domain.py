"""The contract of a kind of domain, as executable laws."""

import copy
import pickle
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import (
    Domain,
    graph_of,
    normals_of,
    polygons_of,
    positions_of,
    triangles_of,
)
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.sources.ground import Ground, lies_in_triangles
from geodesic_toolkit.testing.conformance import (
    Check,
    ConformanceReport,
    Measured,
    as_checks,
    run_checks,
)
from geodesic_toolkit.testing.recipe_laws import faults

__all__ = ["DOMAIN_LAWS", "check_domain", "domain_checks"]

ROUNDING = 1e-9
"""Tolerance of points computed in two ways, relative to the size of the shape."""

ARRAYS = {
    "positions": positions_of,
    "triangles": triangles_of,
    "polygons": polygons_of,
    "as_graph": graph_of,
}
"""Capabilities that are data, and the calls that return them."""


def domain_checks(
    domain: Domain, *, expected_failures: Mapping[str, str] | None = None
) -> list[Check]:
    """Return the contract of a kind of domain as a list of checks, one per law.

    Parameters
    ----------
    domain : Domain
        A shape of that kind, with at least ten vertices.
    expected_failures : mapping of str to str, optional
        Laws that are known to fail, with the reason. A law that holds nevertheless is reported too.

    Returns
    -------
    list of Check
        Calling one raises if its law is broken; ``check.run()`` returns the figures.

    Raises
    ------
    InvalidOptionError
        The object is not a domain, or a failure is declared for a law that does not exist.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> checks = gt.testing.domain_checks(gt.testing.shapes.icosphere(2))
    >>> {check.law: check for check in checks}["places_are_closest"].run().ok
    True
    """
    if not isinstance(domain, Domain):
        raise InvalidOptionError(f"expected an instance of a Domain, not {domain!r}")
    return as_checks(DOMAIN_LAWS, domain, expected_failures or {})


def check_domain(
    domain: Domain, *, expected_failures: Mapping[str, str] | None = None
) -> ConformanceReport:
    """Check a kind of domain against the whole contract.

    Parameters and errors are those of :func:`domain_checks`.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound.

    Raises
    ------
    ConformanceError
        Laws are broken, or laws that were declared to fail hold.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.check_domain(gt.Graph(12, [[i, i + 1] for i in range(11)])).ok
    True
    """
    checks = domain_checks(domain, expected_failures=expected_failures)
    return run_checks(domain, checks).or_raise()


def vertices_are_counted(domain: Domain) -> Iterable[Measured]:
    """``n_vertices`` is a positive integer, and ``present`` has one boolean for each."""
    count, present = domain.n_vertices, domain.present
    found = []
    if not isinstance(count, int) or count < 1:
        found.append(f"n_vertices is {count!r}")
    if getattr(present, "shape", None) != (count,) or present.dtype != np.bool_:
        found.append(f"present is {present!r}")
    yield faults(found)


def capabilities_have_the_agreed_form(domain: Domain) -> Iterable[Measured]:
    """Positions (N, 3), triangles (F, 3), normals and edges fit the vertices."""
    found = []
    for name, ask in (*ARRAYS.items(), ("normals", normals_of)):
        if domain.has(name):
            try:
                ask(domain)
            except UnsupportedDomainError as error:
                found.append(str(error))
    if domain.has("positions"):
        somewhere = np.isfinite(domain.positions).all(axis=1)
        lost = _used(domain) & domain.present & ~somewhere
        if lost.any():
            found.append(f"vertex {int(lost.argmax())} is present and used, but not finite")
    yield faults(found)


def capabilities_left_out_are_refused(domain: Domain) -> Iterable[Measured]:
    """Capabilities that the kind omits raise an UnsupportedDomainError."""
    points, mask = np.zeros((1, 3)), np.zeros(domain.n_vertices, dtype=np.bool_)
    asked = {
        "positions": lambda: domain.positions,
        "triangles": lambda: domain.triangles,
        "polygons": lambda: domain.polygons,
        "as_graph": domain.as_graph,
        "without": lambda: domain.without(mask),
        "closest": lambda: domain.closest(points),
        "attach": lambda: domain.attach(None, np.zeros(domain.n_vertices), "distance"),
    }
    found = []
    for name, ask in asked.items():
        raised = None if domain.has(name) else _raised(ask)
        if not domain.has(name) and not isinstance(raised, UnsupportedDomainError):
            found.append(f"{name} raised {raised!r}")
    yield faults(found)


def arrays_are_read_only(domain: Domain) -> Iterable[Measured]:
    """All arrays that a domain holds or returns are read-only, also in a pickled copy."""
    found = []
    for way, shape in (("", domain), ("pickled ", pickle.loads(pickle.dumps(domain)))):  # noqa: S301
        held = {**getattr(shape, "__dict__", {}), **_data(shape), "present": shape.present}
        found += [
            f"{way}{name} is writeable"
            for name, array in held.items()
            if isinstance(array, np.ndarray) and array.flags.writeable
        ]
    yield faults(found)


def copies_are_the_same(domain: Domain) -> Iterable[Measured]:
    """Pickle and deepcopy keep all numbers of a domain."""
    copies = {"pickle": pickle.loads(pickle.dumps(domain)), "deepcopy": copy.deepcopy(domain)}  # noqa: S301
    yield faults([f"{way} changes it" for way, other in copies.items() if not _same(domain, other)])


def masked_vertices_belong_to_nothing(domain: Domain) -> Iterable[Measured]:
    """``without`` keeps all vertices and their indices; no element has a masked one."""
    if not domain.has("without"):
        return
    mask = _mask(domain)
    left, found = domain.without(mask), []
    if not isinstance(left, Domain) or left.n_vertices != domain.n_vertices:
        yield faults([f"{domain!r} became {left!r}"])
        return
    for name, rows in (("triangle", _triangles(left)), ("edge", _edges(left))):
        if rows is not None and mask[rows].any():
            found.append(f"an element of {name} has a masked vertex")
    if domain.has("positions"):
        kept = _used(left)
        if not np.array_equal(left.positions[kept], domain.positions[kept]):
            found.append("vertices that are not masked have moved")
    yield faults(found)


def masking_changes_nothing_else(domain: Domain) -> Iterable[Measured]:
    """``without`` does not change the domain itself; an empty mask keeps all of it."""
    if not domain.has("without"):
        return
    before = copy.deepcopy(domain)
    domain.without(_mask(domain))
    whole = domain.without(np.zeros(domain.n_vertices, dtype=np.bool_))
    found = [] if _same(before, domain) else ["a mask changed the domain"]
    if not _same(whole, domain):
        found.append("an empty mask changed the domain")
    yield faults(found)


def a_mask_of_everything_is_refused(domain: Domain) -> Iterable[Measured]:
    """Masking all vertices raises an InvalidOptionError."""
    if domain.has("without"):
        raised = _raised(lambda: domain.without(np.ones(domain.n_vertices, dtype=np.bool_)))
        good = isinstance(raised, InvalidOptionError)
        yield faults([] if good else [f"it gave {raised!r}"])


def vertices_are_closest_to_themselves(domain: Domain) -> Iterable[Measured]:
    """The point closest to a vertex is the vertex (distance, relative to the size of the shape)."""
    if domain.has("positions"):
        points = domain.positions[_used(domain)]
        feet = Ground(domain).closest(points).positions(domain)
        yield Measured(_farthest(feet - points) / _size(points), ROUNDING, "vertices")


def places_are_closest(domain: Domain) -> Iterable[Measured]:
    """The point closest to another is not farther than any vertex, and is closest to itself."""
    if not domain.has("positions"):
        return
    own, ground = domain.positions[_used(domain)], Ground(domain)
    low, high = own.min(axis=0), own.max(axis=0)
    points = np.random.default_rng(2).uniform(low - 0.2, high + 0.2, size=(40, 3))
    feet = ground.closest(points).positions(domain)
    gaps = np.linalg.norm(points - feet, axis=1)
    nearest = np.linalg.norm(points[:, None] - own, axis=2).min(axis=1)
    yield Measured(float((gaps - nearest).max()) / _size(own), ROUNDING, "against vertices")
    again = ground.closest(feet).positions(domain)
    yield Measured(_farthest(again - feet) / _size(own), ROUNDING, "asked again")


DOMAIN_LAWS = (
    vertices_are_counted,
    capabilities_have_the_agreed_form,
    capabilities_left_out_are_refused,
    arrays_are_read_only,
    copies_are_the_same,
    masked_vertices_belong_to_nothing,
    masking_changes_nothing_else,
    a_mask_of_everything_is_refused,
    vertices_are_closest_to_themselves,
    places_are_closest,
)
"""The contract of :class:`~geodesic_toolkit.Domain`, in the order of its report."""


def _raised(ask: Any) -> Exception | None:
    try:
        ask()
    except Exception as error:  # noqa: BLE001 - the caller examines the error
        return error
    return None


def _data(domain: Domain) -> dict[str, Any]:
    """Return the arrays that a domain provides, by name."""
    found: dict[str, Any] = {"normals": domain.normals}
    if domain.has("positions"):
        found["positions"] = domain.positions
    if domain.has("triangles"):
        found["triangles"] = domain.triangles
    if domain.has("polygons"):
        found.update(zip(("sizes", "corners"), domain.polygons, strict=True))
    if domain.has("as_graph"):
        graph = domain.as_graph()
        found.update(edges=graph.edges, lengths=graph.lengths)
    return found


def _same(first: Domain, second: Domain) -> bool:
    """Return whether two domains have equal data, bit for bit."""
    if first.n_vertices != second.n_vertices or not (first.present == second.present).all():
        return False
    ours, theirs = _data(first), _data(second)
    return ours.keys() == theirs.keys() and all(
        np.array_equal(ours[name], theirs[name], equal_nan=name in {"positions", "normals"})
        for name in ours
        if ours[name] is not None or theirs[name] is not None
    )


def _triangles(domain: Domain) -> IntArray | None:
    return domain.triangles if domain.has("triangles") else None


def _edges(domain: Domain) -> IntArray | None:
    return domain.as_graph().edges if domain.has("as_graph") else None


def _used(domain: Domain) -> BoolArray:
    """Return a mask of the vertices of elements, or of all present ones if elements are unknown."""
    rows = _triangles(domain) if lies_in_triangles(domain) else _edges(domain)
    if rows is None:
        return np.asarray(domain.present)
    used = np.zeros(domain.n_vertices, dtype=np.bool_)
    used[rows] = True
    return used


def _mask(domain: Domain) -> BoolArray:
    """Return a mask of a tenth of the vertices, at least two."""
    mask = np.zeros(domain.n_vertices, dtype=np.bool_)
    mask[:: max(1, min(10, domain.n_vertices // 2))] = True
    return mask


def _size(points: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0


def _farthest(steps: FloatArray) -> float:
    return float(np.linalg.norm(steps, axis=1).max())
