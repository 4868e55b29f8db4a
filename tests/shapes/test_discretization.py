"""The algebra that every discretization rests on, and what its contract refuses."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDiscretizationError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

DISCRETIZATIONS = {
    "cotan": gt.CotanLaplacian().assemble(shapes.icosphere(2)),
    "voronoi": gt.CotanLaplacian(mass="voronoi").assemble(shapes.grid(9)),
    "delaunay": gt.CotanLaplacian(intrinsic_delaunay=True).assemble(shapes.grid(9, shear=2.0)),
    "uniform": gt.UniformLaplacian().assemble(shapes.icosphere(2)),
    "identity": gt.UniformLaplacian(mass="identity").assemble(shapes.tube(6, 8)),
}


@pytest.fixture(params=DISCRETIZATIONS)
def discretization(request):
    return DISCRETIZATIONS[request.param]


def test_the_stiffness_is_the_gradient_squared(discretization):
    gradient = discretization.gradient
    squared = gradient.matrix.T @ (gradient.weights[:, None] * gradient.matrix.toarray())
    np.testing.assert_allclose(squared, discretization.stiffness.toarray(), atol=1e-12)


def test_the_stiffness_is_symmetric_to_the_bit_and_kills_constants(discretization):
    stiffness = discretization.stiffness
    assert (stiffness != stiffness.T).nnz == 0
    np.testing.assert_allclose(stiffness @ np.ones(stiffness.shape[0]), 0, atol=1e-12)
    assert np.linalg.eigvalsh(stiffness.toarray()).min() > -1e-12


def test_the_gradient_kills_constants(discretization):
    ones = np.ones(discretization.n_vertices)
    np.testing.assert_allclose(discretization.gradient.matrix @ ones, 0, atol=1e-12)


def test_the_adjoint_is_the_adjoint(discretization):
    gradient = discretization.gradient
    rng = np.random.default_rng(0)
    shape = gradient.unit(np.zeros((discretization.n_vertices, 3))).shape
    field = rng.normal(size=shape)
    rows = field.reshape(-1, 3)
    expected = gradient.matrix.T @ (gradient.weights[:, None] * rows)
    np.testing.assert_allclose(gradient.adjoint(field), expected, atol=1e-12)
    np.testing.assert_allclose(gradient.adjoint(field[..., 0]), expected[:, 0], atol=1e-12)


def test_blocks_of_unit_gradients_are_their_columns(discretization):
    gradient = discretization.gradient
    log_heat = np.random.default_rng(1).normal(size=(discretization.n_vertices, 4))
    block = gradient.unit(log_heat)
    for k in range(4):
        np.testing.assert_allclose(block[..., k], gradient.unit(log_heat[:, k]), atol=1e-14)


@pytest.mark.slow
@settings(deadline=None)
@given(st.floats(-1e6, 1e6))
def test_the_scale_of_heat_does_not_change_its_direction(shift):
    gradient = DISCRETIZATIONS["cotan"].gradient
    log_heat = -20 * np.linalg.norm(shapes.icosphere(2).vertices - [0, 0, 1], axis=1)
    np.testing.assert_allclose(gradient.unit(log_heat + shift), gradient.unit(log_heat), atol=1e-7)


def test_where_there_is_no_heat_there_is_no_direction(discretization):
    cold = np.full(discretization.n_vertices, -np.inf)
    assert not discretization.gradient.unit(cold).any()
    assert not discretization.gradient.unit(np.zeros(discretization.n_vertices)).any()


def test_unit_gradients_on_elements_have_length_one():
    unit = DISCRETIZATIONS["cotan"].gradient.unit(shapes.icosphere(2).vertices[:, 2] * 700)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1)


def test_mass_adds_up_to_the_area():
    for mass in ("barycentric", "voronoi"):
        square = gt.CotanLaplacian(mass=mass).assemble(shapes.grid(7))
        assert square.mass.sum() == pytest.approx(1)
    flipped = DISCRETIZATIONS["delaunay"]
    assert flipped.mass.sum() == pytest.approx(1)
    assert (gt.CotanLaplacian(mass="identity").assemble(shapes.grid(7)).mass == 1).all()


def test_intrinsic_delaunay_leaves_no_weight_of_the_wrong_sign_inside():
    flipped = DISCRETIZATIONS["delaunay"]
    inside = np.flatnonzero(~flipped.boundary)
    weights = flipped.stiffness.toarray()[inside]
    weights[np.arange(len(inside)), inside] = 0
    assert weights.max() < 1e-12
    assert flipped.notes["triangulation"] == "intrinsic Delaunay"


def test_intrinsic_delaunay_does_not_mind_how_faces_are_turned():
    mesh = shapes.grid(9, shear=2.0)
    faces = mesh.faces.copy()
    faces[::3] = faces[::3, ::-1]
    turned = gt.TriangleMesh(mesh.vertices, faces)
    stiffness = gt.CotanLaplacian(intrinsic_delaunay=True).assemble(turned).stiffness
    expected = DISCRETIZATIONS["delaunay"].stiffness
    np.testing.assert_allclose(stiffness.toarray(), expected.toarray(), atol=1e-12)


def crowded_edge():
    """Return three sheared sheets that share an edge: 200 faces each."""
    sheet = shapes.grid(11, shear=3.0)
    turns = [np.diag([1.0, np.cos(a), 1.0]) + np.sin(a) * np.eye(3)[[0, 2, 1]] * [0, 1, 0]
             for a in (0.0, 2.0, 4.0)]  # fmt: skip
    vertices = np.concatenate([sheet.vertices @ turn for turn in turns])
    faces = np.concatenate([sheet.faces + part * 121 for part in range(3)])
    shared = sheet.vertices[:, 1] == 0
    same = np.arange(363)
    same[121:] = np.where(np.tile(shared, 2), np.tile(np.arange(121), 2), same[121:])
    return gt.TriangleMesh(vertices, same[faces])


def test_intrinsic_delaunay_leaves_edges_of_more_than_two_faces_alone():
    mesh = crowded_edge()
    sides = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert (count == 3).sum() == 10
    flipped = gt.CotanLaplacian(intrinsic_delaunay=True).assemble(mesh)
    assert flipped.mass.sum() == pytest.approx(gt.CotanLaplacian().assemble(mesh).mass.sum())
    inner = np.flatnonzero(~flipped.boundary & (mesh.vertices[:, 1] != 0))
    weights = flipped.stiffness.toarray()[inner]
    weights[np.arange(len(inner)), inner] = 0
    assert weights.max() < 1e-9
    middle = 5
    exact = np.linalg.norm(mesh.vertices[:121] - mesh.vertices[middle], axis=1)
    distance = gt.geodesic_distance(mesh, middle, refine=True)
    np.testing.assert_allclose(distance[:121], exact, rtol=3e-3, atol=1e-9)


def test_intrinsic_delaunay_does_a_one_sided_surface():
    turn = np.linspace(0, np.pi, 31)[:-1]
    across = np.linspace(-0.3, 0.3, 4)
    a, w = np.meshgrid(turn, across, indexing="ij")
    ring = np.column_stack([
        ((1 + w * np.cos(a)) * np.cos(2 * a)).ravel(),
        ((1 + w * np.cos(a)) * np.sin(2 * a)).ravel(),
        (w * np.sin(a)).ravel(),
    ])  # fmt: skip
    at = np.arange(120).reshape(30, 4)
    rows = np.concatenate([at, at[:1, ::-1]])
    lower, upper = rows[:-1], rows[1:]
    faces = np.concatenate([
        np.stack([lower[:, :-1], upper[:, :-1], upper[:, 1:]], axis=-1).reshape(-1, 3),
        np.stack([lower[:, :-1], upper[:, 1:], lower[:, 1:]], axis=-1).reshape(-1, 3),
    ])  # fmt: skip
    strip = gt.TriangleMesh(ring, faces)
    flipped = gt.CotanLaplacian(intrinsic_delaunay=True).assemble(strip)
    plain = gt.CotanLaplacian().assemble(strip)
    assert flipped.mass.sum() == pytest.approx(plain.mass.sum())
    assert (flipped.components == 0).all()


def test_auto_flips_the_components_that_need_it_alone():
    good, bad = shapes.grid(21), shapes.grid(21, shear=3.0)
    both = gt.CotanLaplacian(intrinsic_delaunay="auto").assemble(shapes.disjoint_union(good, bad))
    assert both.notes["triangulation"] == "partly intrinsic Delaunay"
    alone = gt.CotanLaplacian(intrinsic_delaunay=True).assemble(bad).stiffness
    np.testing.assert_allclose(both.stiffness[441:, 441:].toarray(), alone.toarray(), atol=1e-12)
    plain = gt.CotanLaplacian().assemble(good).stiffness
    np.testing.assert_allclose(both.stiffness[:441, :441].toarray(), plain.toarray(), atol=1e-12)


def test_degenerate_faces_stay_finite_and_connect():
    vertices = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]]
    flat = gt.TriangleMesh(vertices, [[0, 1, 3], [0, 1, 2], [1, 1, 0]])
    discretization = gt.CotanLaplacian().assemble(flat)
    assert discretization.notes["dropped_faces"] == 1
    assert discretization.notes["mollified_by"] > 0
    assert discretization.components.max() == 0
    assert np.isfinite(gt.geodesic_distance(flat, 0, refine=True)).all()


def test_a_mesh_of_one_place_has_no_laplacian():
    point = gt.TriangleMesh(np.ones((3, 3)), [[0, 1, 2]])
    with pytest.raises(UnsupportedDomainError, match="at one position"):
        gt.CotanLaplacian().assemble(point)
    repeated = gt.TriangleMesh(np.eye(3), [[0, 0, 1]])
    with pytest.raises(UnsupportedDomainError, match="at one position"):
        gt.CotanLaplacian().assemble(repeated)


def test_boundary_vertices_are_those_of_edges_with_one_face():
    assert gt.CotanLaplacian().assemble(shapes.grid(5)).boundary.sum() == 16
    assert not DISCRETIZATIONS["cotan"].boundary.any()


@pytest.mark.parametrize(
    "through", [lambda x: x, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_arrays_are_read_only_also_after_copying(discretization, through):
    twin = through(discretization)
    arrays = [twin.mass, twin.boundary, twin.stiffness.data, twin.stiffness.indices]
    arrays += [value for value in vars(twin.gradient).values() if isinstance(value, np.ndarray)]
    for array in arrays:
        assert not array.flags.writeable
    assert twin.components.max() == 0


def parts():
    good = gt.CotanLaplacian().assemble(shapes.grid(3))
    names = ("mass", "stiffness", "gradient", "spacing", "boundary")
    return {name: getattr(good, name) for name in names}


def skewed(stiffness):
    dense = stiffness.toarray()
    dense[0, 1] += 0.5
    dense[0, 2] -= 0.5
    return csr_array(dense)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": np.ones(8)}, "boundary"),
        ({"mass": np.ones((9, 1))}, "must be"),
        ({"mass": -np.ones(9)}, "vertex 0 has the negative mass"),
        ({"mass": np.full(9, np.nan)}, "mass 0 is not finite"),
        ({"mass": "heavy"}, "mass is not an array"),
        ({"spacing": 0.0}, "spacing must be positive"),
        ({"spacing": np.nan}, "spacing must be positive"),
        ({"stiffness": csr_array((4, 4))}, r"must have shape \(9, 9\)"),
        ({"stiffness": csr_array(np.eye(9))}, "row 0 of the stiffness sums to 1"),
        ({"stiffness": csr_array(np.full((9, 9), np.nan))}, "stiffness entry 0 is not finite"),
        ({"stiffness": skewed(parts()["stiffness"])}, "not symmetric"),
        ({"stiffness": csr_array(-parts()["stiffness"])}, "positive semidefinite"),
        ({"gradient": DISCRETIZATIONS["cotan"].gradient}, "the gradient has 162 vertices"),
    ],
)
def test_what_breaks_the_contract_is_refused(change, message):
    with pytest.raises(InvalidDiscretizationError, match=message):
        gt.Discretization(**(parts() | change))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 1, 2]], np.zeros((1, 2, 2)), [1.0], 3), "must be"),
        (([[0, 1, 3]], np.zeros((1, 2, 3)), [1.0], 3), "element 0 refers to"),
        (([[0, 1, 2]], np.full((1, 2, 3), np.inf), [1.0], 3), "coefficient 0 is not finite"),
        (([[0, 1, 2]], np.zeros((1, 2, 3)), [-1.0], 3), "element 0 has the negative measure"),
    ],
)
def test_an_element_gradient_that_cannot_be_one_is_refused(arguments, message):
    with pytest.raises(InvalidDiscretizationError, match=message):
        gt.ElementGradient(*arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 1]], [1.0, 1.0], [1.0, 1.0]), "must be"),
        (([[0, 2]], [1.0], [1.0, 1.0]), "edge 0 refers to"),
        (([[0, 1]], [-0.5], [1.0, 1.0]), "edge weight 0 is -0.5: .*ElementGradient"),
        (([[0, 1]], [0.5], [1.0, -1.0]), "measure 1 is -1.0"),
        (([[0, 1]], [np.nan], [1.0, 1.0]), "edge weight 0 is not finite"),
    ],
)
def test_an_edge_gradient_that_cannot_be_one_is_refused(arguments, message):
    with pytest.raises(InvalidDiscretizationError, match=message):
        gt.EdgeGradient(*arguments)


class Borrowed(gt.Gradient):
    """The least that a gradient of a plugin consists of, on the numbers of another one."""

    def __init__(self, base):
        self.base = base

    @property
    def n_vertices(self):
        return self.base.n_vertices

    def unit(self, log_heat):
        return self.base.unit(log_heat)

    def adjoint(self, field):
        return self.base.adjoint(field)

    @property
    def matrix(self):
        return self.base.matrix

    @property
    def weights(self):
        return self.base.weights

    def stiffness(self):
        return self.base.stiffness()


@pytest.mark.parametrize("sources", [[0], [0, 5]])
def test_a_gradient_needs_to_know_nothing_but_logarithms_of_heat(sources):
    metric = DISCRETIZATIONS["cotan"]
    other = replace(metric, gradient=Borrowed(metric.gradient))
    direct = gt.SuperLU()
    own, borrowed = (
        gt.HeatMethod(data, heat_solver=direct, poisson_solver=direct).distances(sources)
        for data in (metric, other)
    )
    np.testing.assert_allclose(borrowed, own, atol=1e-9)
