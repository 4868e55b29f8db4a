"""Does a kind of domain of a plugin do what the core's own do, and say what it leaves out?"""

import json
import re

import numpy as np
import pytest
from command_line import fails, run
from solids import Bare, BareLaplacian, Solid, SolidLaplacian, cube

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.matrix.fingerprints import fingerprint_of_solver
from geodesic_toolkit.domains.located import check_present
from geodesic_toolkit.errors import (
    ConformanceError,
    InvalidOptionError,
    InvalidSourceError,
    PluginLoadError,
    UnreachableError,
    UnsupportedDomainError,
    WriteError,
)
from geodesic_toolkit.registry.catalog import resolve_operator
from geodesic_toolkit.testing import shapes
from geodesic_toolkit.viz.scene import make_scene

CUBE = cube(9)
MIDDLE = [[0.5, 0.5, 0.5]]
FROM_MIDDLE = np.linalg.norm(CUBE.positions - 0.5, axis=1)

HEAT_IN_A_CUBE = 0.15
"""Error of plain heat over the distance, in the mean: 0.045 from the vertex in the middle, 0.107
from a place between vertices, and half of that with half of the edges."""

FLAT = 1 / 8
"""Edge of the cells of the cube, which no interpolation in one is farther off than."""


@pytest.fixture(autouse=True)
def plugins(register):
    """Operators and a reader, registered for the time of a test."""
    register(gt.operators, "solid", SolidLaplacian)
    register(gt.operators, "bare", BareLaplacian)
    register(gt.readers, "solid", lambda path: cube(int(path.read_text())))
    register(gt.readers, "bare", lambda path: Bare(int(path.read_text())))


@pytest.fixture
def solid_file(tmp_path):
    path = tmp_path / "cube.solid"
    path.write_text("5")
    return path


@pytest.fixture
def bare_file(tmp_path):
    path = tmp_path / "line.bare"
    path.write_text("12")
    return path


@pytest.fixture(scope="module")
def solver():
    return gt.GeodesicSolver(CUBE, operator=SolidLaplacian())


# -- what it can -----------------------------------------------------------------------------------


def mean_error(distance, expected=FROM_MIDDLE):
    return np.abs(distance - expected).sum() / expected.sum()


def test_distances_come_from_the_operator_that_names_the_kind():
    solver = gt.GeodesicSolver(CUBE)
    assert solver.operator == SolidLaplacian()
    assert mean_error(solver.distance(int(FROM_MIDDLE.argmin()))) < HEAT_IN_A_CUBE


def test_no_path_crosses_masked_vertices():
    wall = np.isclose(CUBE.positions[:, 0], 0.5)
    distance = gt.GeodesicSolver(CUBE, mask=wall).distance(0)
    np.testing.assert_array_equal(np.isinf(distance), CUBE.positions[:, 0] > 0.49)
    with pytest.raises(InvalidSourceError, match="is masked"):
        gt.GeodesicSolver(CUBE, mask=wall).distance(int(FROM_MIDDLE.argmin()))
    with pytest.raises(InvalidOptionError, match="leaves no tetrahedron"):
        gt.GeodesicSolver(CUBE, mask=np.ones(CUBE.n_vertices, dtype=bool))


def test_a_point_is_located_inside_an_element(solver):
    point = np.array([[0.31, 0.42, 0.53]])
    places = solver.locate(point)
    assert len(places.vertices) == 4
    np.testing.assert_allclose(places.weights @ CUBE.positions, point, atol=1e-12)
    straight = np.linalg.norm(CUBE.positions - point, axis=1)
    assert mean_error(solver.distance(point), straight) < HEAT_IN_A_CUBE


def test_a_point_outside_moves_to_the_boundary(solver):
    places = solver.locate([0.31, 0.42, 1.2])
    np.testing.assert_allclose(places.weights @ CUBE.positions, [[0.31, 0.42, 1.0]], atol=1e-12)


def test_located_places_are_sources(solver):
    cell = CUBE.cells[700]
    inside = gt.Located([cell], [[0.1, 0.2, 0.3, 0.4]])
    np.testing.assert_array_equal(solver.distance(inside), solver.distance(solver.locate(inside)))
    straight = np.linalg.norm(CUBE.positions - inside.positions(CUBE), axis=1)
    assert mean_error(solver.distance(inside), straight) < HEAT_IN_A_CUBE
    late = gt.OffsetSources(inside, [0.25])
    assert solver.distance(late).min() >= 0.25


def test_a_surface_point_lies_in_a_triangle_of_the_kind(solver):
    on = solver.locate(gt.SurfacePoint(3, (0.5, 0.5, 0.0)))
    assert set(on.vertices) == set(CUBE.triangles[3, :2])
    with pytest.raises(InvalidSourceError, match="there are 768"):
        solver.locate(gt.SurfacePoint(768, (1.0, 0.0, 0.0)))


def test_a_curve_through_a_solid_is_a_source(solver):
    axis = gt.Curve([[0.5, 0.5, 0.0], [0.5, 0.5, 1.0]])
    straight = np.linalg.norm(CUBE.positions[:, :2] - 0.5, axis=1)
    np.testing.assert_allclose(solver.distance(axis), straight, atol=FLAT)


def test_queries_are_answered_inside_elements(solver):
    points = np.random.default_rng(0).uniform(size=(60, 3))
    expected = np.linalg.norm(points - 0.5, axis=1)
    np.testing.assert_allclose(solver.query(points, MIDDLE), expected, atol=FLAT)
    assert solver.query([0.5, 0.5, 3.0], MIDDLE) == np.inf
    labels, _ = solver.nearest_source(points, [0, CUBE.n_vertices - 1])
    clear = np.abs(points.sum(axis=1) - 1.5) > 0.3
    np.testing.assert_array_equal(labels[clear], (points.sum(axis=1) > 1.5)[clear])


def test_queries_in_a_masked_solid_are_of_what_is_left():
    wall = np.isclose(CUBE.positions[:, 0], 0.5)
    solver = gt.GeodesicSolver(CUBE, mask=wall)
    near, beyond = solver.query([[0.1, 0.5, 0.5], [0.9, 0.5, 0.5]], 0)
    assert near < 1
    assert beyond == np.inf


def test_matrices_samples_and_cells_take_the_kind(solver, tmp_path):
    landmarks = gt.farthest_point_sampling(solver, 4, start=0)
    assert len(set(landmarks.tolist())) == 4
    matrix = gt.distance_matrix(solver, landmarks, targets=landmarks)
    assert matrix.shape == (4, 4)
    labels = gt.geodesic_voronoi(solver, landmarks)
    np.testing.assert_array_equal(labels[landmarks], np.arange(4))


def test_ways_are_compared():
    comparison = gt.compare(cube(5), 0)
    assert comparison.reference_name == "the default"
    assert {"auto", "plain heat", "solid", "cg for Poisson"} <= {
        row.variant.name for row in comparison.rows if row.failure is None
    }


@pytest.mark.parametrize("kind", ["ply", "pcd", "vtu", "vtp", "csv", "npy", "txt"])
def test_distances_are_saved_with_the_shape(solver, kind, tmp_path):
    if kind in {"vtu", "vtp"}:
        pytest.importorskip("vtkmodules")
    path = tmp_path / f"d.{kind}"
    gt.write(path, CUBE, solver.distance(0))
    if kind == "ply":
        back = gt.read(path)
        np.testing.assert_allclose(back.vertices, CUBE.positions)
        np.testing.assert_array_equal(back.faces, CUBE.triangles)
    assert path.stat().st_size > 0


def test_a_scene_has_the_triangles_of_the_boundary(solver):
    scene = make_scene(CUBE, solver.distance(0), sources=MIDDLE)
    assert scene.edges is None
    assert len(scene.faces) == len(CUBE.triangles)
    np.testing.assert_allclose(scene.sources, [[0, 0, 0]], atol=1e-12)


def test_a_picture_is_drawn(solver, tmp_path):
    pytest.importorskip("k3d", reason="HTML pictures need the extra viz")
    pytest.importorskip("pyvista", reason="isolines need the extra viz")
    path = tmp_path / "solid.html"
    gt.viz.save_html(CUBE, solver.distance(0), path)
    assert path.stat().st_size > 10_000


def test_a_path_leads_along_edges(solver):
    path = gt.geodesic_path(solver, 0, CUBE.n_vertices - 1)
    assert path.length == pytest.approx(np.sqrt(3))  # the cells have diagonals
    np.testing.assert_allclose(path.points[[0, -1]], [[0, 0, 0], [1, 1, 1]])
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    np.testing.assert_allclose(steps, path.lengths)
    assert gt.geodesic_path(solver, [0, 5], 5).vertices.tolist() == [5]
    assert repr(path) == "EdgePath(9 vertices, length 1.73205)"


def test_a_path_begins_at_the_vertex_from_which_it_is_shortest(solver):
    path = gt.geodesic_path(solver, [0.02, 0.01, 0.0], [1.0, 1.0, 0.98])
    assert path.vertices[[0, -1]].tolist() == [0, CUBE.n_vertices - 1]


def test_a_path_on_a_graph_follows_the_shorter_of_parallel_edges_and_starts_late():
    edges = [[0, 1], [0, 1], [1, 2], [2, 3], [3, 0]]
    solver = gt.GeodesicSolver(gt.Graph(4, edges, [9.0, 1.0, 1.0, 1.0, 4.0]))
    assert gt.geodesic_path(solver, 0, 2).lengths.tolist() == [1.0, 1.0]
    late = gt.OffsetSources([0, 3], [0.0, 5.0])
    assert gt.geodesic_path(solver, late, 3).vertices.tolist() == [0, 1, 2, 3]
    with pytest.raises(UnsupportedDomainError, match="a Graph has no positions"):
        _ = gt.geodesic_path(solver, 0, 2).points


def test_no_path_leads_around_a_wall(solver):
    wall = np.isclose(CUBE.positions[:, 0], 0.5)
    with pytest.raises(UnreachableError, match=r"corner 728 lies in another component, or behind"):
        gt.geodesic_path(gt.GeodesicSolver(CUBE, mask=wall), 0, 728)


# -- on the command line ---------------------------------------------------------------------------


def test_the_commands_take_a_file_of_the_kind(solid_file, tmp_path):
    out, table = tmp_path / "d.ply", tmp_path / "d.npy"
    at = tmp_path / "at.csv"
    at.write_text("x,y,z\n0.1,0.1,0.1\n0.9,0.9,0.9\n")
    result = run("distance", solid_file, "--source", "0.1,0.1,0.1", "--output", out, "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["domain"] == "Solid"
    assert gt.read(out).n_vertices == 125
    result = run("distance", solid_file, "--source", "0", "--at", at, "--output", table)
    assert result.exit_code == 0, result.output
    assert np.load(table).shape == (2,)
    result = run("doctor", solid_file)
    assert result.exit_code == 0, result.output
    assert "Solid(125 corners, 384 tetrahedra)" in result.stdout
    result = run("compare", solid_file, "--source", "0")
    assert result.exit_code == 0, result.output
    result = run("matrix", solid_file, "--landmarks", "3", "--output", tmp_path / "m.npy")
    assert result.exit_code == 0, result.output


def test_the_kind_is_checked_with_its_operator():
    result = run("check", "solid")
    assert result.exit_code == 0, result.output
    assert "places_are_closest" in result.stdout
    assert re.search(r"(\d+) of \1 laws", result.stdout)


def test_the_commands_say_what_the_kind_leaves_out(bare_file, tmp_path):
    assert run("distance", bare_file, "--source", "0").exit_code == 0
    assert run("doctor", bare_file).exit_code == 0
    ply = ("--output", tmp_path / "d.ply")
    fails(run("distance", bare_file, "--source", "0", *ply), 2, "a Bare has no positions")
    at = tmp_path / "at.csv"
    at.write_text("0,0,0\n")
    fails(run("distance", bare_file, "--source", "0", "--at", at), 2, "a Bare has no positions")
    fails(run("distance", bare_file, "--source", "0,0,0"), 2, "a Bare has no positions")
    fails(run("check", "bare"), 2, "there are no samples of Bare", "classmethod samples()")


# -- what it leaves out ----------------------------------------------------------------------------


def bare_solver():
    return gt.GeodesicSolver(Bare())


MISSING = {
    "positions": lambda: Bare().positions,
    "triangles": lambda: Bare().triangles,
    "as_graph()": lambda: gt.geodesic_path(bare_solver(), 0, 5),
    "without(mask)": lambda: gt.GeodesicSolver(Bare(), mask=np.arange(12) == 3),
    "closest(points)": lambda: Bare().closest(np.zeros((1, 3))),
    "attach(obj, values, name)": lambda: Bare().attach(None, np.zeros(12), "distance"),
    "samples()": Bare.samples,
}


@pytest.mark.parametrize("capability", MISSING)
def test_a_capability_that_is_left_out_names_what_its_author_can_write(capability):
    with pytest.raises(UnsupportedDomainError) as caught:
        MISSING[capability]()
    assert "Bare" in str(caught.value)
    assert capability in str(caught.value)


def test_errors_of_the_core_s_own_kinds_advise_no_change_of_their_class():
    with pytest.raises(UnsupportedDomainError) as caught:
        _ = gt.Graph(2, [[0, 1]]).positions
    assert "give the class" not in str(caught.value)


@pytest.mark.parametrize(
    ("ask", "error", "message"),
    [
        (lambda s: s.distance([0.0, 0.5, 0.0]), InvalidSourceError, "a Bare has no positions"),
        (
            lambda s: s.distance(gt.Located([[0, 1]], [[0.5, 0.5]])),
            InvalidSourceError,
            "a Bare has no positions",
        ),
        (lambda s: s.query([0.0, 0.0, 0.0], 0), UnsupportedDomainError, "a Bare has no positions"),
        (
            lambda s: s.distance(gt.SurfacePoint(0, (1.0, 0.0, 0.0))),
            InvalidSourceError,
            "not a Bare",
        ),
        (lambda s: gt.write("d.ply", s.domain, np.zeros(12)), InvalidOptionError, "a Bare has no"),
        (lambda s: make_scene(s.domain, np.zeros(12)), UnsupportedDomainError, "no positions to"),
    ],
)
def test_what_needs_a_capability_that_is_left_out_says_so(ask, error, message):
    with pytest.raises(error, match=message):
        ask(bare_solver())


def test_distances_need_nothing_but_an_operator():
    np.testing.assert_allclose(bare_solver().distance(0), np.arange(12), atol=1e-3)
    assert repr(Bare()) == "Bare(12 vertices)"
    scene = make_scene(Bare(3), [0, 1, 2], positions=np.eye(3))
    assert scene.faces is None
    assert scene.edges is None


def test_a_kind_with_positions_alone_has_its_vertices():
    class Points(gt.Domain):
        n_vertices = 3
        positions = np.eye(3)

    solver = gt.GeodesicSolver(Points(), operator=OnThree())
    assert solver.locate([1.0, 0.1, 0.0]).vertices.tolist() == [0]
    assert solver.locate(gt.Curve(np.eye(3)[:2])).vertices.tolist() == [0, 1]
    with pytest.raises(UnsupportedDomainError, match=r"or its method closest\(points\)"):
        solver.query([1.0, 0.0, 0.0], 0)


class OnThree(gt.LaplaceOperator):
    """The Laplacian of a path of three vertices, on any domain that has as many."""

    domains = (gt.Domain,)

    def assemble(self, domain):
        return gt.UniformLaplacian(dim=1).assemble(gt.Graph(3, [[0, 1], [1, 2]]))


class Beads(gt.Domain):
    """Three points on a thread."""

    n_vertices = 3
    positions = np.eye(3)
    present = np.array([True, True, False])

    def as_graph(self):
        return gt.Graph(3, [[0, 1], [1, 2]], np.sqrt([2.0, 2.0]))


def test_a_kind_with_edges_and_no_triangles_is_drawn_and_saved_with_these(tmp_path):
    scene = make_scene(Beads(), [0.0, 1.0, 2.0])
    assert scene.edges.tolist() == [[0, 1], [1, 2]]
    assert scene.present.tolist() == [True, True, False]
    pytest.importorskip("vtkmodules")
    meshio = pytest.importorskip("meshio")
    gt.write(tmp_path / "d.vtu", Beads(), np.arange(3.0))
    (block,) = meshio.read(tmp_path / "d.vtu").cells
    assert block.type == "line"
    assert block.data.tolist() == [[0, 1], [1, 2]]


def test_a_vertex_that_is_not_present_cannot_be_a_source():
    solver = gt.GeodesicSolver(Beads(), operator=OnThree())
    with pytest.raises(InvalidSourceError, match="vertex 2 of the Beads is missing"):
        solver.distance(2)
    assert solver.locate([0.0, 0.0, 1.0]).vertices.tolist() == [0]


def test_a_matrix_distinguishes_shapes_of_a_kind():
    def of(solid):
        return fingerprint_of_solver(gt.GeodesicSolver(solid))["shape"]

    cells = cube(3).cells
    assert of(cube(3)) == of(cube(3))
    assert of(cube(3)) != of(Solid(cube(3).positions, cells[::-1]))


# -- which operator --------------------------------------------------------------------------------


class Finer(gt.Domain):
    n_vertices = 3


class Finest(Finer):
    pass


def operator_of(*kinds):
    return type("Own", (OnThree,), {"domains": kinds})


def test_the_operator_of_the_nearest_class_is_taken(register):
    register(gt.operators, "a", operator_of(gt.Domain))
    register(gt.operators, "b", operator_of(Bare, Finer))
    register(gt.operators, "c", operator_of(Finer))
    assert isinstance(resolve_operator("auto", Finest()), gt.operators["b"])
    register(gt.operators, "d", operator_of(Finest))
    assert isinstance(resolve_operator("auto", Finest()), gt.operators["d"])
    assert isinstance(resolve_operator("auto", Finer()), gt.operators["b"])


def test_where_no_operator_takes_the_kind_the_message_names_what_is_missing(monkeypatch):
    with pytest.raises(UnsupportedDomainError, match="names Finest in its attribute domains"):
        resolve_operator("auto", Finest())

    def broken(name):
        raise PluginLoadError(name)

    monkeypatch.setattr(type(gt.operators), "__getitem__", lambda self, name: broken(name))
    with pytest.raises(UnsupportedDomainError, match=r"bare, .* does not load"):
        resolve_operator("auto", Finest())


# -- places ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "weights", "message"),
    [
        ([0, 1], [0.5, 0.5], r"must have shape \(n, n\)"),
        ([[0, 1]], [[0.5, 0.4]], "not convex"),
        ([[0, 1]], [[1.5, -0.5]], "not convex"),
        ([[0, 1]], [[np.nan, 1.0]], "not convex"),
        ([[0, -1]], [[0.5, 0.5]], "place 0 has the vertex -1"),
        ([[0, 1]], [[1.0]], "weights must have shape"),
        ([[0.5, 1]], [[0.5, 0.5]], "not whole numbers"),
        (np.zeros((1, 0), dtype=int), np.zeros((1, 0)), "one vertex or more"),
    ],
)
def test_places_that_are_none_are_refused(vertices, weights, message):
    with pytest.raises(InvalidSourceError, match=message):
        gt.Located(vertices, weights)


def test_places_are_read_only_and_of_this_shape():
    place = gt.Located([[0, 1]], [[0.5, 0.5]])
    assert len(place) == 1
    assert not place.weights.flags.writeable
    square = shapes.grid(3)
    solver = gt.GeodesicSolver(square)
    np.testing.assert_allclose(solver.distance(place)[:2], 0.25)
    with pytest.raises(InvalidSourceError, match="vertex 9 does not exist; there are 9"):
        solver.distance(gt.Located([[0, 9]], [[0.5, 0.5]]))
    with pytest.raises(InvalidSourceError, match="there are none"):
        solver.distance(gt.Located(np.zeros((0, 3), dtype=int), np.zeros((0, 3))))
    cloud = gt.PointCloud([[0, 0, 0], [np.nan, 0, 0]])
    with pytest.raises(InvalidSourceError, match="here: point 1 of the PointCloud is missing"):
        check_present(cloud, np.array([0, 1]), "here")


# -- a kind that says what is not so ---------------------------------------------------------------


def wrong(**members):
    """Return a cube of a class with some members that are wrong."""

    class Wrong(gt.Domain):
        n_vertices = CUBE.n_vertices
        positions = CUBE.positions

    for name, member in members.items():
        setattr(Wrong, name, member)
    return Wrong()


class OnSolid(gt.LaplaceOperator):
    """The Laplacian of the cube, on whatever says that it is one."""

    domains = (gt.Domain,)

    def assemble(self, domain):
        return SolidLaplacian().assemble(CUBE)


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"positions": CUBE.positions[:, :2]}, r"positions must be float64 of shape \(729, 3\)"),
        ({"positions": CUBE.positions[:5]}, "positions must be float64"),
        ({"positions": CUBE.positions.tolist()}, "not a list"),
        ({"triangles": CUBE.triangles + 700}, "there are 729 vertices"),
        ({"triangles": CUBE.triangles.astype(float)}, "triangles must be int64"),
        ({"closest": lambda self, points: None}, "closest returned a NoneType"),
        (
            {"closest": lambda self, points: gt.Located([[0]], [[1.0]])},
            "a Located of 1 places for 2 points",
        ),
    ],
)
def test_what_a_kind_says_of_itself_is_checked_before_kernels_take_it(members, message):
    solver = gt.GeodesicSolver(wrong(**members), operator=OnSolid())
    with pytest.raises(UnsupportedDomainError, match=message):
        solver.distance([[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]])


def test_a_place_of_a_kind_that_is_not_there_is_an_error():
    out = wrong(closest=lambda self, points: gt.Located([[999]], [[1.0]]))
    with pytest.raises(InvalidSourceError, match=r"Wrong.closest: vertex 999 does not exist"):
        gt.GeodesicSolver(out, operator=OnSolid()).distance([[0.1, 0.1, 0.1]])


def test_a_mask_must_keep_the_vertices_and_edges_those_of_the_kind(tmp_path):
    fewer = wrong(without=lambda self, mask: cube(3))
    with pytest.raises(UnsupportedDomainError, match="of the same 729 vertices, not Solid"):
        gt.GeodesicSolver(fewer, operator=OnSolid(), mask=np.arange(729) == 0)
    other = wrong(as_graph=lambda self: gt.Graph(2, [[0, 1]]))
    with pytest.raises(UnsupportedDomainError, match="a Graph of 729 vertices, not Graph"):
        gt.geodesic_path(gt.GeodesicSolver(other, operator=OnSolid()), 0, 1)
    bent = wrong(normals=np.zeros((2, 3)))
    with pytest.raises((UnsupportedDomainError, WriteError), match="normals must be float64"):
        gt.write(tmp_path / "d.ply", bent, np.zeros(729))


# -- the laws --------------------------------------------------------------------------------------

KINDS = [
    CUBE,
    Bare(),
    shapes.icosphere(2),
    gt.PointCloud(np.vstack([shapes.icosphere(2).vertices, [[np.nan, 0, 0]]])),
    gt.Graph(12, [[i, i + 1] for i in range(11)]),
]


@pytest.mark.parametrize("kind", KINDS, ids=repr)
def test_every_kind_keeps_the_contract(kind):
    assert gt.testing.check_domain(kind).ok


def renumbered(self, mask):
    return Solid(CUBE.positions, CUBE.cells)


WRONG = {
    "vertices_are_counted": {"present": np.ones(3, dtype=bool)},
    "capabilities_have_the_agreed_form": {"triangles": CUBE.triangles.astype(np.int32)},
    "arrays_are_read_only": {"normals": np.zeros((729, 3))},
    "masked_vertices_belong_to_nothing": {"without": renumbered},
    "a_mask_of_everything_is_refused": {"without": lambda self, mask: self},
    "vertices_are_closest_to_themselves": {
        "closest": lambda self, points: gt.Located(
            np.zeros((len(points), 1), int), [[1.0]] * len(points)
        )
    },
    "places_are_closest": {
        "closest": lambda self, points: gt.Located(
            np.zeros((len(points), 1), int), [[1.0]] * len(points)
        )
    },
}


@pytest.mark.parametrize("law", WRONG)
def test_a_kind_that_is_wrong_breaks_the_law_of_that(law):
    domain = wrong(**WRONG[law])
    checks = {check.law: check for check in gt.testing.domain_checks(domain)}
    with pytest.raises(ConformanceError, match=law):
        checks[law]()


class Forgetful(gt.Domain):
    """Vertices that are elsewhere each time that they are asked for."""

    n_vertices = 12

    def __init__(self):
        self.shift = 0.0

    @property
    def positions(self):
        self.shift += 1.0
        return np.full((12, 3), self.shift)

    def without(self, mask):
        return self


def test_a_kind_that_forgets_or_changes_breaks_the_laws_of_copies_and_masks():
    changing = {check.law: check for check in gt.testing.domain_checks(Forgetful())}
    assert not changing["copies_are_the_same"].measure().holds
    assert not changing["masking_changes_nothing_else"].measure().holds


def test_a_capability_that_is_refused_otherwise_breaks_the_law(monkeypatch):
    def refuse(self):
        raise RuntimeError("no")

    monkeypatch.setattr(gt.Domain, "as_graph", refuse)
    checks = {check.law: check for check in gt.testing.domain_checks(Bare())}
    assert not checks["capabilities_left_out_are_refused"].run().held


def test_checks_want_a_domain():
    with pytest.raises(InvalidOptionError, match="expected an instance of a Domain"):
        gt.testing.domain_checks(Solid)
