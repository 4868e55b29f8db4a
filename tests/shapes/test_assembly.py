"""The compiled assembly and right-hand side do what the slow, readable forms of them do."""

import copy
import pickle

import numpy as np
import pytest
import slow_kernels
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sample_shapes import many_sheets, scrambled
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.errors import InvalidDiscretizationError, UnsupportedDomainError
from geodesic_toolkit.geometry.intrinsic import delaunay_triangles
from geodesic_toolkit.geometry.triangles import (
    face_areas,
    face_edge_lengths,
    frames_from_lengths,
    inverse_frames,
    measured_by_lengths,
    mollified_lengths,
)
from geodesic_toolkit.testing import shapes


def fan(count):
    """Return triangles around one vertex that come in no order, and one of which is double."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    at = np.random.default_rng(0).permutation(count)
    faces = np.column_stack([at + 1, np.zeros(count, int), (at + 1) % count + 1])
    return gt.TriangleMesh(np.vstack([[0, 0, 0.2], rim]), np.vstack([faces, faces[:1]]))


SPHERE = shapes.icosphere(2)
FLAT = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [5, 5, 5]]
MESHES = {
    "one triangle": gt.TriangleMesh(FLAT, [[0, 1, 3]]),
    "sphere": SPHERE,
    "scrambled": scrambled(shapes.grid(9, shear=0.7)),
    "right angles": shapes.grid(6),
    "obtuse": shapes.grid(9, shear=2.0),
    "two parts": shapes.disjoint_union(shapes.grid(4), shapes.icosphere(1)),
    "many sheets": many_sheets(turned=[4]),
    "fan": fan(50),
    "no area": gt.TriangleMesh(FLAT, [[0, 1, 3], [0, 1, 2], [1, 1, 0], [0, 3, 1]]),
    "repeated vertices": gt.TriangleMesh(SPHERE.vertices, np.vstack([SPHERE.faces, [[5, 7, 5]]])),
    "small": gt.TriangleMesh(SPHERE.vertices * 1e-9, SPHERE.faces),
    "large and far away": gt.TriangleMesh(SPHERE.vertices * 1e6 + 1e7, SPHERE.faces),
    "unused vertices": gt.TriangleMesh(np.vstack([np.ones((3, 3)), SPHERE.vertices]),
                                       SPHERE.faces + 3),
}  # fmt: skip


KERNELS = {name: getattr(_native, name) for name in slow_kernels.NAMES}
SLOW = {name: getattr(slow_kernels, name) for name in slow_kernels.NAMES}


@pytest.fixture
def use(monkeypatch):
    """The function that chooses between kernels and their slow forms."""

    def use(kernels):
        for name, function in (KERNELS if kernels else SLOW).items():
            monkeypatch.setattr(_native, name, function)

    return use


def both(use, compute):
    """Return what `compute` does with slow kernels and with compiled ones."""
    results = []
    for kernels in (False, True):
        use(kernels)
        results.append(compute())
    return results


def assert_same(numpy, kernels):
    assert kernels.notes["triangulation"] == numpy.notes["triangulation"]
    assert kernels.notes["dropped_faces"] == numpy.notes["dropped_faces"]
    for note in ("mollified_by", "obtuse_excess"):
        assert kernels.notes[note] == pytest.approx(numpy.notes[note], rel=1e-9, abs=1e-12)
    assert kernels.spacing == pytest.approx(numpy.spacing, rel=1e-13)
    np.testing.assert_array_equal(kernels.boundary, numpy.boundary)
    np.testing.assert_array_equal(kernels.components, numpy.components)
    mine, theirs = kernels.stiffness, numpy.stiffness
    # A needle's cotangents are large and cancel: they are as exact as the largest of them.
    close = {"rtol": 1e-7, "atol": 1e-9 * np.abs(theirs.data).max()}
    if numpy.notes["triangulation"] != "given":  # the same edges, or others of the same circles
        np.testing.assert_allclose(mine.toarray(), theirs.toarray(), **close)
        assert kernels.mass.sum() == pytest.approx(numpy.mass.sum())
        return
    np.testing.assert_allclose(kernels.mass, numpy.mass, rtol=1e-9)
    np.testing.assert_array_equal(mine.indptr, theirs.indptr)
    np.testing.assert_array_equal(mine.indices, theirs.indices)
    np.testing.assert_allclose(mine.data, theirs.data, **close)
    coefficients = numpy.gradient.coefficients
    np.testing.assert_allclose(
        kernels.gradient.coefficients, coefficients, atol=1e-9 * np.abs(coefficients).max()
    )


@pytest.mark.parametrize(
    "options", [{}, {"mass": "voronoi"}, {"intrinsic_delaunay": True}], ids=str
)
@pytest.mark.parametrize("name", MESHES)
def test_kernels_assemble_what_numpy_does(use, name, options):
    operator = gt.CotanLaplacian(**options)
    assert_same(*both(use, lambda: operator.assemble(MESHES[name])))


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(st.integers(0, 2**32 - 1), st.integers(3, 12), st.integers(1, 30))
def test_kernels_assemble_any_soup_of_faces(use, seed, n_vertices, n_faces):
    rng = np.random.default_rng(seed)
    faces = rng.integers(n_vertices, size=(n_faces, 3))
    mesh = gt.TriangleMesh(rng.normal(size=(n_vertices, 3)), faces)
    if not any(len(set(face)) == 3 for face in faces.tolist()):
        for kernels in (False, True):
            use(kernels)
            with pytest.raises(UnsupportedDomainError, match="at one position"):
                gt.CotanLaplacian().assemble(mesh)
        return
    assert_same(*both(use, lambda: gt.CotanLaplacian().assemble(mesh)))


@pytest.mark.parametrize("kernels", [False, True])
@pytest.mark.parametrize("name", MESHES)
def test_a_stiffness_has_its_edges_sorted_and_a_diagonal_in_every_row(use, name, kernels):
    use(kernels)
    stiffness = gt.CotanLaplacian().assemble(MESHES[name]).stiffness
    assert (stiffness != stiffness.T).nnz == 0
    copied = csr_array((stiffness.data, stiffness.indices, stiffness.indptr), stiffness.shape)
    assert copied.has_canonical_format
    rows = np.repeat(np.arange(stiffness.shape[0]), np.diff(stiffness.indptr))
    assert (rows == stiffness.indices).sum() == stiffness.shape[0]
    faces = MESHES[name].faces
    edges = {(int(a), int(b)) for face in faces if len(set(face)) == 3 for a in face for b in face}
    assert edges <= set(zip(rows.tolist(), stiffness.indices.tolist(), strict=True))


@pytest.mark.parametrize(("points", "face"), [(np.ones((3, 3)), [0, 1, 2]), (np.eye(3), [0, 0, 1])])
def test_a_mesh_of_one_place_is_refused_by_kernels_too(use, points, face):
    use(True)
    with pytest.raises(UnsupportedDomainError, match="at one position"):
        gt.CotanLaplacian().assemble(gt.TriangleMesh(points, [face]))


def test_overflow_is_an_error_with_kernels_and_without(use):
    mesh = gt.TriangleMesh(SPHERE.vertices * 1e200, SPHERE.faces)
    for kernels in (False, True):
        use(kernels)
        with pytest.raises(UnsupportedDomainError, match="another unit of length"):
            gt.CotanLaplacian().assemble(mesh)


def changed(stiffness, change):
    dense = stiffness.toarray()
    change(dense)
    return csr_array(dense)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a.__setitem__((3, 3), np.nan), "entry .* is not finite"),
        (lambda a: a.__setitem__((3, 3), np.inf), "entry .* is not finite"),
        (lambda a: a.__setitem__((3, 3), a[3, 3] + 1e-3), "row 3 of the stiffness sums to 0.001"),
        (lambda a: a.__setitem__((3, [4, 5]), a[3, [4, 5]] + [1e-3, -1e-3]), "not symmetric"),
        (lambda a: a.__imul__(-1), "positive semidefinite"),
    ],
)
def test_a_broken_stiffness_is_named_with_kernels_as_without(use, change, message):
    good = gt.CotanLaplacian().assemble(SPHERE)
    broken = changed(good.stiffness, change)
    names = ("mass", "gradient", "spacing", "boundary")
    parts = {name: getattr(good, name) for name in names}
    for kernels in (False, True):
        use(kernels)
        with pytest.raises(InvalidDiscretizationError, match=message):
            gt.Discretization(stiffness=broken, **parts)


def test_triangles_of_given_edges_are_measured_by_kernels_as_by_numpy(use):
    rng = np.random.default_rng(0)
    lengths, _ = mollified_lengths(rng.uniform(0.1, 1, size=(500, 3)))
    (inverse, areas), (by_kernel, areas_by_kernel) = both(use, lambda: measured_by_lengths(lengths))
    np.testing.assert_allclose(by_kernel, inverse, rtol=1e-13)
    np.testing.assert_allclose(areas_by_kernel, areas, rtol=1e-13)


# -- flips -------------------------------------------------------------------------------------


def positive_weights(faces, lengths, n_vertices):
    frames = frames_from_lengths(lengths)
    gradient = gt.ElementGradient.of_triangles(
        faces, inverse_frames(frames), face_areas(frames), n_vertices
    )
    sums = gradient.sums()
    stiffness, boundary = sums.stiffness().scipy, sums.boundary
    inner = stiffness.tocoo()
    kept = (inner.row != inner.col) & ~(boundary[inner.row] & boundary[inner.col])
    return inner.data[kept], stiffness


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(2, 9), st.floats(0, 4), st.floats(0.01, 1))
def test_kernels_flip_edges_as_libigl_does(use, seed, n, shear, flatness):
    rng = np.random.default_rng(seed)
    mesh = shapes.grid(n, shear=shear)
    vertices = mesh.vertices + rng.uniform(-0.3, 0.3, size=(n * n, 3)) * [1 / n, 1 / n, flatness]
    turn = rng.random(mesh.n_faces) < rng.choice([0.0, 0.3])
    faces = np.where(turn[:, None], mesh.faces[:, ::-1], mesh.faces)
    lengths, _ = mollified_lengths(face_edge_lengths(vertices, faces))
    numpy, kernels = both(use, lambda: delaunay_triangles(faces, lengths))
    total = face_areas(frames_from_lengths(lengths)).sum()
    assert face_areas(frames_from_lengths(kernels[1])).sum() == pytest.approx(total)
    weights, stiffness = positive_weights(*kernels[:2], n * n)
    assert weights.max(initial=-1.0) < 1e-6 * np.abs(stiffness.data).max()
    _, expected = positive_weights(*numpy[:2], n * n)
    np.testing.assert_allclose(
        stiffness.toarray(), expected.toarray(), atol=1e-6 * np.abs(expected.data).max()
    )


@pytest.mark.parametrize("name", ["many sheets", "fan", "two parts", "sphere"])
def test_flips_leave_edges_of_one_or_many_faces(use, name):
    mesh = MESHES[name]
    lengths, _ = mollified_lengths(face_edge_lengths(mesh.vertices, mesh.faces))
    numpy, kernels = both(use, lambda: delaunay_triangles(mesh.faces, lengths))
    for side in (0, 1):
        assert np.sort(kernels[side], axis=None) == pytest.approx(np.sort(numpy[side], axis=None))


def test_twins_know_when_faces_are_turned_and_edges_crowded():
    sheet = shapes.grid(3)
    twin, coherent = _native.sorted_half_edges(sheet.faces, 9).twins()
    assert coherent
    assert (twin >= 0).sum() == 2 * 8
    np.testing.assert_array_equal(twin[twin[twin >= 0]], np.flatnonzero(twin >= 0))
    turned = sheet.faces.copy()
    turned[3] = turned[3, ::-1]
    assert not _native.sorted_half_edges(turned, 9).twins()[1]
    crowded, coherent = _native.sorted_half_edges(MESHES["many sheets"].faces, 7).twins()
    assert coherent
    assert (crowded == -1).all()


# -- the right-hand side -----------------------------------------------------------------------


def turned(gradient, seed=0):
    """Return the same triangles, with coefficients in frames that are turned at random."""
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(gradient.elements))
    frame = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    coefficients = np.einsum("abe,ebm->eam", frame, gradient.coefficients)
    return gt.ElementGradient(
        gradient.elements, coefficients, gradient.measure, gradient.n_vertices
    )


def with_segment():
    """Return a triangle and a segment (i, j, j), as operators on clouds make them."""
    slopes = np.array([[[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]], [[-0.5, 0.5, 0.0], [0.0, 0.0, 0.0]]])
    return gt.ElementGradient([[0, 1, 2], [2, 3, 3]], slopes, [0.5, 0.1], 4, stars=True)


PLAIN = gt.CotanLaplacian().assemble(SPHERE).gradient
GRADIENTS = {"lazy": PLAIN, "turned": turned(PLAIN), "with a segment": with_segment()}


def generic(gradient, log_heat):
    return -gradient.adjoint(gradient.unit(log_heat))


@pytest.mark.parametrize("columns", [None, 1, 2, 17])
@pytest.mark.parametrize("name", GRADIENTS)
def test_the_right_hand_side_is_minus_the_adjoint_of_the_direction(use, name, columns):
    gradient = GRADIENTS[name]
    shape = (gradient.n_vertices,) if columns is None else (gradient.n_vertices, columns)
    log_heat = np.random.default_rng(2).uniform(-600, 0, size=shape)
    expected = generic(gradient, log_heat)
    for kernels in (False, True):
        use(kernels)
        for heat in (Heat.of_log(log_heat), Heat.of(np.exp(log_heat))):
            load = gradient.descent_load(heat)
            assert load.shape == shape
            np.testing.assert_allclose(load, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(
    # Where corners differ by rounding alone, a gradient has no direction.
    st.lists(
        st.floats(-2000, 2000).map(lambda value: round(value, 6)) | st.just(-np.inf),
        min_size=12,
        max_size=12,
    ),
    st.floats(1e-150, 1e150),
)
def test_any_logarithm_gives_the_same_right_hand_side(use, log_heat, size):
    mesh = shapes.icosphere(0)
    gradient = gt.CotanLaplacian().assemble(mesh).gradient
    log_heat = np.array(log_heat)
    pair = np.column_stack([log_heat, log_heat[::-1]])
    numpy, kernels = both(use, lambda: gradient.descent_load(Heat.of_log(log_heat)))
    np.testing.assert_allclose(kernels, numpy, atol=1e-6)
    np.testing.assert_allclose(gradient.descent_load(Heat.of_log(pair))[:, 0], kernels, atol=1e-12)


@pytest.mark.parametrize("level", [1e-300, 1e-200, 1.0, 1e300])
def test_the_level_of_the_heat_does_not_matter(use, level):
    use(True)
    heat = 1 + np.random.default_rng(3).uniform(size=PLAIN.n_vertices)
    expected = generic(PLAIN, np.log(heat))
    for shaped in (heat, heat[:, None] * np.ones(3)):
        load = PLAIN.descent_load(Heat.of(shaped * level))
        np.testing.assert_allclose(load.T - expected, 0, atol=1e-11)


def test_where_there_is_no_gradient_there_is_no_load(use):
    for kernels in (False, True):
        use(kernels)
        for shape in ((162,), (162, 3)):
            cold = np.full(shape, -np.inf)
            assert not PLAIN.descent_load(Heat.of_log(cold)).any()
            assert not PLAIN.descent_load(Heat.of_log(np.zeros(shape))).any()
            assert not PLAIN.descent_load(Heat.of(np.zeros(shape))).any()
            assert not PLAIN.descent_load(Heat.of(np.ones(shape))).any()


def test_what_is_not_a_number_does_not_vanish(use):
    heat = np.ones(162)
    heat[7] = np.nan
    for kernels in (False, True):
        use(kernels)
        for shaped in (heat, heat[:, None] * np.ones(2)):
            for form in (Heat.of, Heat.of_log):
                load = PLAIN.descent_load(form(shaped))
                assert np.isnan(load[7]).all()


def test_any_memory_order_does(use):
    use(True)
    heat = np.random.default_rng(4).uniform(1, 2, size=(162, 4))
    expected = PLAIN.descent_load(Heat.of(heat))
    for other in (np.asfortranarray(heat), np.repeat(heat, 2, axis=1)[:, ::2]):
        np.testing.assert_array_equal(PLAIN.descent_load(Heat.of(other)), expected)


def tetrahedron():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    hats = np.linalg.inv(np.column_stack([np.ones(4), corners]))[1:]
    return gt.ElementGradient([[0, 1, 2, 3]], hats[None], [1 / 6], 4)


@pytest.mark.parametrize(
    "gradient", [tetrahedron(), gt.UniformLaplacian().assemble(SPHERE).gradient], ids=repr
)
def test_other_gradients_have_the_same_right_hand_side_by_their_own_means(use, gradient):
    use(True)
    log_heat = np.random.default_rng(5).uniform(-5, 0, size=(gradient.n_vertices, 3))
    for shaped in (log_heat, log_heat[:, 0]):
        expected = generic(gradient, shaped)
        load = gradient.descent_load(Heat.of(np.exp(shaped)))
        np.testing.assert_allclose(load, expected, atol=1e-12)
        np.testing.assert_array_equal(gradient.descent_load(Heat.of_log(shaped)), expected)


# -- triangles in three numbers ----------------------------------------------------------------


@pytest.mark.parametrize("name", GRADIENTS)
def test_three_numbers_hold_all_of_a_triangle(name):
    gradient = GRADIENTS[name]
    p, q, r = gradient.inverse_frames.T
    first, second = gradient.coefficients[:, :, 1], gradient.coefficients[:, :, 2]
    np.testing.assert_allclose(p**2 + q**2, (first**2).sum(axis=1))
    np.testing.assert_allclose(q * r, (first * second).sum(axis=1), atol=1e-9)
    np.testing.assert_allclose(r**2, (second**2).sum(axis=1))


@pytest.mark.parametrize("name", GRADIENTS)
def test_copies_leave_out_what_derives(name):
    gradient = GRADIENTS[name]
    field = np.random.default_rng(6).normal(
        size=(*gradient.unit(np.zeros(gradient.n_vertices)).shape,)
    )
    expected = gradient.adjoint(field), gradient.stiffness().toarray()
    for twin in (
        copy.copy(gradient),
        copy.deepcopy(gradient),
        pickle.loads(pickle.dumps(gradient)),
    ):
        held = {name for name, value in vars(twin).items() if isinstance(value, np.ndarray)}
        assert len(held & {"coefficients", "inverse_frames"}) == 1
        assert repr(twin) == repr(gradient)
        assert twin.stars == gradient.stars
        np.testing.assert_array_equal(twin.adjoint(field), expected[0])
        np.testing.assert_array_equal(twin.stiffness().toarray(), expected[1])
        assert not twin.coefficients.flags.writeable
        assert not twin.inverse_frames.flags.writeable


def test_triangles_without_area_are_refused():
    with pytest.raises(InvalidDiscretizationError, match="coefficient 0 is not finite"):
        gt.ElementGradient.of_triangles(
            np.array([[0, 1, 2]]), np.array([[1.0, np.nan, np.inf]]), np.zeros(1), 3
        )
    with pytest.raises(InvalidDiscretizationError, match="element 0 refers to"):
        gt.ElementGradient.of_triangles(np.array([[0, 1, 3]]), np.ones((1, 3)), np.ones(1), 3)


TWICE = {
    "front and back": lambda faces: np.concatenate([faces, faces[:, ::-1]]),
    "in turn": lambda faces: np.stack([faces, faces[:, [1, 2, 0]]], axis=1).reshape(-1, 3),
    "in part, three times": lambda faces: np.concatenate([faces, faces[5:9], faces[5:9, ::-1]]),
}


@pytest.mark.parametrize("repeat", TWICE.values(), ids=TWICE.keys())
@pytest.mark.parametrize("mesh", [shapes.icosphere(2), shapes.grid(9, shear=3.0)])
def test_faces_that_are_there_twice_count_once(mesh, repeat):
    twice = gt.TriangleMesh(mesh.vertices, repeat(mesh.faces))
    one, other = (gt.CotanLaplacian().assemble(each) for each in (mesh, twice))
    np.testing.assert_array_equal(other.mass, one.mass)
    np.testing.assert_array_equal(other.stiffness.toarray(), one.stiffness.toarray())
    np.testing.assert_array_equal(other.boundary, one.boundary)
    assert other.notes["dropped_faces"] == twice.n_faces - mesh.n_faces
    last = gt.SurfacePoint(twice.n_faces - 1, (0.5, 0.3, 0.2))
    place = twice.vertices[twice.faces[-1]].T @ last.barycentric
    for source in (0, last, place):
        np.testing.assert_allclose(
            gt.geodesic_distance(twice, source, refine=True),
            gt.geodesic_distance(mesh, place if source is last else source, refine=True),
            rtol=1e-12,
            atol=1e-12,
        )
    np.testing.assert_array_equal(gt.exact_distance(twice, 3), gt.exact_distance(mesh, 3))
    solvers = [gt.GeodesicSolver(each, refine=True) for each in (mesh, twice)]
    paths = [gt.geodesic_path(solver, 0, 70) for solver in solvers]
    np.testing.assert_allclose(paths[1].points, paths[0].points, atol=1e-12)
    assert solvers[1].diagnosis.non_manifold_edges == 0
    np.testing.assert_array_equal(
        gt.UniformLaplacian().assemble(twice).stiffness.toarray(),
        gt.UniformLaplacian().assemble(mesh).stiffness.toarray(),
    )
