"""Arrays that are given to a constructor stay the caller's: writeable, in order, without effect.

Each case has the arguments of a constructor, by name. After construction all of their arrays are
to be what they were; then they are filled with nonsense, and the object is to be what it was.
"""

import copy
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.testing import shapes

MESH = shapes.icosphere(1)
METRIC = gt.CotanLaplacian().assemble(MESH)
CLOUD = gt.PointCloudLaplacian(normals="pca").assemble(gt.PointCloud(shapes.icosphere(2).vertices))
COUNT = MESH.n_vertices
EDGES = np.array([[0, 1], [1, 2], [2, 0]])


def unsorted(matrix):
    """Return a matrix with the entries of each row in reverse."""
    order = np.concatenate(
        [np.arange(*ends)[::-1] for ends in zip(matrix.indptr[:-1], matrix.indptr[1:], strict=True)]
    )
    entries = (matrix.data[order], matrix.indices[order], matrix.indptr.copy())
    return csr_array(entries, shape=matrix.shape)


def of_metric(metric, **others):
    names = ("mass", "stiffness", "gradient", "spacing", "boundary", "scales", "surface_frames")
    return {name: getattr(metric, name) for name in names} | others


GRADIENT = METRIC.gradient
CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "TriangleMesh": (gt.TriangleMesh, {"vertices": MESH.vertices, "faces": MESH.faces}),
    "PointCloud": (gt.PointCloud, {"points": MESH.vertices}),
    "PointCloud with normals": (
        gt.PointCloud,
        {"points": MESH.vertices, "normals": MESH.vertices},
    ),
    "Graph": (gt.Graph, {"n_vertices": 3, "edges": EDGES, "lengths": np.ones(3)}),
    "EdgeGradient": (
        gt.EdgeGradient,
        {"edges": EDGES, "edge_weights": np.ones(3), "measure": np.ones(3)},
    ),
    "ElementGradient": (
        ElementGradient,
        {
            "elements": GRADIENT.elements,
            "coefficients": GRADIENT.coefficients,
            "measure": GRADIENT.measure,
            "vertex_count": COUNT,
        },
    ),
    "ElementGradient of triangles": (
        ElementGradient.of_triangles,
        {
            "elements": GRADIENT.elements,
            "inverse": GRADIENT.inverse_frames,
            "areas": GRADIENT.measure,
            "vertex_count": COUNT,
        },
    ),
    "Discretization": (
        gt.Discretization,
        of_metric(METRIC, known_components=METRIC.components, representatives=np.arange(COUNT)),
    ),
    "Discretization of unsorted rows": (
        gt.Discretization,
        of_metric(METRIC, stiffness=unsorted(METRIC.stiffness)),
    ),
    "Discretization of stars": (gt.Discretization, of_metric(CLOUD)),
    "Curve": (gt.Curve, {"points": MESH.vertices[:4]}),
    "OffsetSources": (gt.OffsetSources, {"sources": np.arange(3), "offsets": np.ones(3)}),
    "OffsetSources in space": (
        gt.OffsetSources,
        {"sources": MESH.vertices[:3], "offsets": np.ones(3)},
    ),
    "SourcePoints": (
        gt.SourcePoints,
        {
            "vertices": np.arange(2),
            "shares": np.ones(2),
            "begins": np.arange(3),
            "n_vertices": 3,
            "distances": np.zeros(2),
            "starts": np.ones(2),
            "front_curvatures": np.ones(2),
        },
    ),
}


def arrays_of(thing):
    """Return the arrays in an object, or in a dictionary, by name."""
    found = {}
    parts = thing if isinstance(thing, dict) else vars(thing)
    for name, value in parts.items():
        if isinstance(value, np.ndarray):
            found[name] = value
        elif isinstance(value, csr_array | CompressedRows):
            arrays = {"data": value.data, "indices": value.indices, "indptr": value.indptr}
            found |= {f"{name}.{part}": array for part, array in arrays.items()}
    return found


def own(arguments):
    """Return writeable copies of arguments."""
    return {
        name: value.copy() if isinstance(value, np.ndarray | csr_array) else value
        for name, value in arguments.items()
    }


@pytest.mark.parametrize("name", CASES)
def test_arrays_stay_as_they_were(name):
    construct, arguments = CASES[name]
    given = own(arguments)
    before = copy.deepcopy(arrays_of(given))
    construct(**given)
    for which, array in arrays_of(given).items():
        assert array.flags.writeable, which
        np.testing.assert_array_equal(array, before[which], err_msg=which)


@pytest.mark.parametrize("name", CASES)
def test_what_becomes_of_them_later_does_not_matter(name):
    construct, arguments = CASES[name]
    given = own(arguments)
    made = construct(**given)
    before = copy.deepcopy(arrays_of(made))
    assert before
    for array in arrays_of(given).values():
        array.fill(1 if array.dtype == np.bool_ else 77)
    for which, array in arrays_of(made).items():
        np.testing.assert_array_equal(array, before[which], err_msg=which)


@pytest.mark.parametrize("name", [name for name in CASES if "OffsetSources" not in name])
def test_what_is_made_of_them_is_read_only(name):
    construct, arguments = CASES[name]
    for which, array in arrays_of(construct(**own(arguments))).items():
        assert not array.flags.writeable, which


def test_a_list_of_sources_may_change_after_its_offsets_are_given():
    sources = [0, 5]
    late = gt.OffsetSources(sources, [0.0, 0.1])
    expected = gt.geodesic_distance(MESH, late)
    sources[1] = 7
    np.testing.assert_array_equal(gt.geodesic_distance(MESH, late), expected)


def test_located_sources_do_not_follow_the_indices_that_they_were_located_by():
    solver, vertices = gt.GeodesicSolver(MESH), np.array([0, 5])
    places = solver.locate(vertices)
    vertices[:] = 7
    assert places.vertices.tolist() == [0, 5]


def test_a_mask_may_change_after_the_solver_is_made():
    mask = np.zeros(COUNT, dtype=np.bool_)
    mask[3] = True
    solver = gt.GeodesicSolver(MESH, mask=mask)
    expected = solver.distance(0)
    mask[:] = True
    assert np.flatnonzero(solver.mask).tolist() == [3]
    np.testing.assert_array_equal(solver.distance(0), expected)


def test_an_analysis_does_not_follow_its_pattern():
    given = METRIC.stiffness + csr_array(np.eye(COUNT))
    system = given.copy()
    analysis = gt.Supernodal().analyse(system)
    order = np.random.default_rng(0).permutation(COUNT)
    other = csr_array(given[order][:, order])
    other.sort_indices()
    system.indices[:], system.indptr[:], system.data[:] = other.indices, other.indptr, other.data
    solution = analysis.factorize(system).solve(np.ones(COUNT))
    np.testing.assert_allclose(other @ solution, np.ones(COUNT))


@pytest.mark.parametrize(
    "name", [name for name in CASES if name.startswith(("Edge", "Element", "Discretization"))]
)
def test_arrays_that_are_handed_over_are_taken_without_a_copy(name):
    construct, arguments = CASES[name]
    given = own(arguments)
    made = arrays_of(construct(**given, copy=False))
    for which, array in arrays_of(given).items():
        if which.startswith("stiffness") and "unsorted" in name:
            continue  # sorted elsewhere
        shared = [np.shares_memory(array, other) for other in made.values()]
        assert any(shared) or not array.size, which
        assert not array.flags.writeable or not array.size, which
