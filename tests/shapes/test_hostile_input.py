"""Whatever is handed in, the answer is right or a typed error: the table, and files."""

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    FarSourceWarning,
    GeodesicError,
    InvalidDomainError,
    InvalidOptionError,
    InvalidSourceError,
    ReadError,
    UnknownPluginError,
    UnsupportedDomainError,
    WriteError,
)
from geodesic_toolkit.io import write
from geodesic_toolkit.testing import shapes

MESH = shapes.icosphere(2)
V, F = MESH.vertices, MESH.faces
N = len(V)
TWO = csr_array([[0.0, 1.0], [1.0, 0.0]])


def with_vertex(index, value):
    vertices = V.copy()
    vertices[index] = value
    return vertices


def with_face(index, value):
    faces = F.astype(type(value))
    faces[index] = value
    return faces


# -- the table: (what, the exact class, what the message says) -------------------------------------

BAD = {
    "source n + 5": ((V, F), N + 5, {}, InvalidSourceError, f"vertex {N + 5} does not exist"),
    "source -1": ((V, F), -1, {}, InvalidSourceError, "vertex -1 does not exist"),
    "source 1e12": ((V, F), 10**12, {}, InvalidSourceError, "does not exist"),
    "source NaN": ((V, F), np.nan, {}, InvalidSourceError, "floats are points"),
    "source point NaN": ((V, F), [np.nan, 0, 0], {}, InvalidSourceError, "point 0 is not finite"),
    "no sources": ((V, F), [], {}, InvalidSourceError, "there are none"),
    "source a string": ((V, F), "7", {}, InvalidSourceError, "must be vertex indices"),
    "source None": ((V, F), None, {}, InvalidSourceError, "must be vertex indices"),
    "source a boolean": ((V, F), True, {}, InvalidSourceError, "must be vertex indices"),
    "source 1.5": ((V, F), 1.5, {}, InvalidSourceError, "vertex indices must be integers"),
    "source an object": ((V, F), object(), {}, InvalidSourceError, "must be vertex indices"),
    "source a dictionary": ((V, F), {0: 1}, {}, InvalidSourceError, "must be vertex indices"),
    "source a set": ((V, F), {0, 1}, {}, InvalidSourceError, "must be vertex indices"),
    "source complex": ((V, F), 1 + 0j, {}, InvalidSourceError, "must be vertex indices"),
    "source 2**70": ((V, F), 2**70, {}, InvalidSourceError, "does not exist"),
    "source 2**64 - 1": ((V, F), np.uint64(2**64 - 1), {}, InvalidSourceError, "does not exist"),
    "sources with None": ((V, F), [0, None], {}, InvalidSourceError, "mix kinds of places"),
    "a table of sources": ((V, F), [[0, 1], [2, 3]], {}, InvalidSourceError, "one-dimensional"),
    "ragged sources": ((V, F), [[0, 1], [2]], {}, InvalidSourceError, "cannot be read"),
    "a mask for sources": ((V, F), np.arange(N) < 3, {}, InvalidSourceError, "flatnonzero"),
    "a source point inf": ((V, F), [0, 0, np.inf], {}, InvalidSourceError, "point 0 is not finite"),
    "a source point (2,)": ((V, F), [0.0, 1.0], {}, InvalidSourceError, r"of shape \(3,\)"),
    "a face that is not there": (
        (V, F),
        gt.SurfacePoint(len(F), (1, 0, 0)),
        {},
        InvalidSourceError,
        f"lies on face {len(F)}",
    ),
    "a face of a cloud": (
        gt.PointCloud(V),
        gt.SurfacePoint(0, (1, 0, 0)),
        {"operator": gt.PointCloudLaplacian(normals="pca")},
        InvalidSourceError,
        "needs a TriangleMesh",
    ),
    "a place on a graph": (
        gt.Graph(3, [[0, 1]]),
        [0.0, 0.0, 0.0],
        {},
        InvalidSourceError,
        "has no positions",
    ),
    "a masked source": ((V, F), 0, {"mask": np.arange(N) == 0}, InvalidSourceError, "is masked"),
    "vertices (n, 2)": ((V[:, :2], F), 0, {}, InvalidDomainError, r"must have shape \(n, 3\)"),
    "a NaN vertex": ((with_vertex(7, np.nan), F), 0, {}, InvalidDomainError, "vertex 7 is not"),
    "an inf vertex": ((with_vertex(9, np.inf), F), 0, {}, InvalidDomainError, "vertex 9 is not"),
    "an empty mesh": ((np.zeros((0, 3)), F), 0, {}, InvalidDomainError, "no vertices"),
    "no faces": ((V, np.zeros((0, 3), dtype=int)), 0, {}, InvalidDomainError, "no faces"),
    "face index n": ((V, with_face(3, N)), 0, {}, InvalidDomainError, f"face 3 .* vertex {N}"),
    "face index 1e9": ((V, with_face(3, 10**9)), 0, {}, InvalidDomainError, "face 3"),
    "face index -1": ((V, with_face(3, -1)), 0, {}, InvalidDomainError, "face 3 .* vertex -1"),
    "face index 2**64 - 1": (
        (V, np.full((1, 3), 2**64 - 1, dtype=np.uint64)),
        0,
        {},
        InvalidDomainError,
        "too large",
    ),
    "face index NaN": ((V, with_face(3, np.nan)), 0, {}, InvalidDomainError, "not whole numbers"),
    "face index inf": ((V, with_face(3, np.inf)), 0, {}, InvalidDomainError, "not whole numbers"),
    "faces of 0.5": ((V, F + 0.5), 0, {}, InvalidDomainError, "not whole numbers"),
    "faces (f, 2)": ((V, F[:, :2]), 0, {}, InvalidDomainError, r"must have shape \(n, 3\)"),
    "faces (f, 4)": ((V, F[:, [0, 1, 2, 0]]), 0, {}, InvalidDomainError, r"shape \(n, 3\)"),
    "faces (3,)": ((V, F[0]), 0, {}, InvalidDomainError, r"must have shape \(n, 3\)"),
    "faces None": ((V, None), 0, {}, InvalidDomainError, "an array of numbers, not a NoneType"),
    "faces of strings": ((V, F.astype(str)), 0, {}, InvalidDomainError, "real numbers"),
    "boolean faces": ((V, F > 0), 0, {}, InvalidDomainError, "real numbers"),
    "boolean vertices": ((V > 0, F), 0, {}, InvalidDomainError, "real numbers"),
    "vertices None": ((None, F), 0, {}, UnsupportedDomainError, "not a shape"),
    "dates": ((V.astype("datetime64[s]"), F), 0, {}, InvalidDomainError, "real numbers"),
    "points (n, 2)": (V[:, :2], 0, {}, UnsupportedDomainError, "not a shape"),
    "three arrays": ((V, F, F), 0, {}, UnsupportedDomainError, "not a shape"),
    "a file's name": ("bunny.off", 0, {}, UnsupportedDomainError, "geodesic_toolkit.read"),
    "object vertices": ((V.astype(object), F), 0, {}, InvalidDomainError, "object"),
    "object faces": ((V, F.astype(object)), 0, {}, InvalidDomainError, "object"),
    "ragged vertices": (
        ([[0, 0, 0], [1, 0]], [[0, 1, 1]]),
        0,
        {},
        InvalidDomainError,
        "vertices cannot be read as an array: row 1 has 2 entries, where row 0 has 3",
    ),
    "ragged faces": (
        (V, [[0, 1, 2], [0, 1, 2, 3]]),
        0,
        {},
        InvalidDomainError,
        "faces cannot be read as an array: row 1 has 4 entries, where row 0 has 3",
    ),
    "ragged points": (
        [[0, 0, 0], [1, 0, 0], [1, 0], [2, 0, 0]],
        0,
        {},
        InvalidDomainError,
        "points cannot be read as an array: row 2 has 2 entries, where row 0 has 3",
    ),
    "lists of no table": (
        [[[0, 0], [1]], [[0, 0], [1]], [[2]]],
        0,
        {},
        InvalidDomainError,
        "points cannot be read as an array: row 2 has 1 entries",
    ),
    "a ragged mixture": ([[0, 0, 0], "abc"], 0, {}, UnsupportedDomainError, "not a shape"),
    "complex vertices": ((V + 0j, F), 0, {}, InvalidDomainError, "complex"),
    "strings": ((V.astype(str), F), 0, {}, InvalidDomainError, "dtype"),
    "all at one place": (
        (np.ones((3, 3)), [[0, 1, 2]]),
        0,
        {},
        UnsupportedDomainError,
        "at one position",
    ),
    "negative time": ((V, F), 0, {"time": -1.0}, InvalidOptionError, "must be positive"),
    "time 0": ((V, F), 0, {"time": 0}, InvalidOptionError, "must be positive"),
    "time inf": ((V, F), 0, {"time": np.inf}, InvalidOptionError, "must be positive"),
    "time a list": ((V, F), 0, {"time": [1.0, 2.0]}, InvalidOptionError, "time must be a number"),
    "time twice": ((V, F), 0, {"time": 1, "time_factor": 2}, InvalidOptionError, "not both"),
    "factor None": ((V, F), 0, {"time_factor": None}, InvalidOptionError, "must be a number"),
    "time 1e300": ((V, F), 0, {"time": 1e300}, InvalidOptionError, "heat becomes uniform"),
    "factor 1e30": ((V, F), 0, {"time_factor": 1e30}, InvalidOptionError, "so long that the heat"),
    "time a string": ((V, F), 0, {"time": "1"}, InvalidOptionError, "time must be a number"),
    "refine a string": ((V, F), 0, {"refine": "no"}, InvalidOptionError, "True, False or"),
    "vertices of 1e200": ((1e200 * V, F), 0, {}, UnsupportedDomainError, "another unit of length"),
    "vertices of 1e-200": ((1e-200 * V, F), 0, {}, UnsupportedDomainError, "another unit"),
    "time NaN": ((V, F), 0, {"time": np.nan}, InvalidOptionError, "must be positive"),
    "negative factor": ((V, F), 0, {"time_factor": -2}, InvalidOptionError, "must be positive"),
    "unknown boundary": ((V, F), 0, {"boundary": "wall"}, InvalidOptionError, "boundary must be"),
    "no boundary": ((V, F), 0, {"boundary": None}, InvalidOptionError, "boundary must be"),
    "operator 3": ((V, F), 0, {"operator": 3}, InvalidOptionError, "3 is not an operator"),
    "operator dict": ((V, F), 0, {"operator": dict}, InvalidOptionError, "is not an operator"),
    "solver 3": ((V, F), 0, {"solver": 3}, InvalidOptionError, "3 is not a solver"),
    "solver of another step": (
        (V, F),
        0,
        {"solver": {"heat": "superlu", "poison": "cg"}},
        InvalidOptionError,
        "not 'poison'",
    ),
    "cg for heat": ((V, F), 0, {"solver": {"heat": "cg"}}, InvalidOptionError, "small values"),
    "unknown diffusion": ((V, F), 0, {"diffusion": "nope"}, UnknownPluginError, "nope"),
    "a mask of 3": ((V, F), 0, {"mask": [True] * 3}, InvalidOptionError, "one boolean for each"),
    "a mask of integers": ((V, F), 0, {"mask": [0] * N}, InvalidOptionError, "one boolean for"),
    "a mask of all": ((V, F), 0, {"mask": [True] * N}, InvalidOptionError, "leaves no face"),
    "unknown operator": ((V, F), 0, {"operator": "cott"}, UnknownPluginError, "cotan"),
    "unknown solver": ((V, F), 0, {"solver": "superlo"}, UnknownPluginError, "superlu"),
    "wrong operator": ((V, F), 0, {"operator": "pointcloud"}, UnsupportedDomainError, "PointCloud"),
    "no shape at all": (7, 0, {}, UnsupportedDomainError, "is not a shape"),
    "a matrix 2 x 3": (csr_array(np.ones((2, 3))), 0, {}, InvalidDomainError, "square"),
    "a length of -1": (-TWO, 0, {}, InvalidDomainError, "edge 0 has length -1"),
    "a length of NaN": (np.nan * TWO, 0, {}, InvalidDomainError, "edge 0 has length nan"),
    "a length of inf": (np.inf * TWO, 0, {}, InvalidDomainError, "edge 0 has length inf"),
    "k larger than n": (
        gt.PointCloud(V[:30]),
        0,
        {"operator": gt.PointCloudLaplacian(k=30)},
        InvalidOptionError,
        "k=30 needs 31 points",
    ),
    "a missing point": (
        gt.PointCloud(with_vertex(4, np.nan)),
        4,
        {"operator": gt.PointCloudLaplacian(normals="pca")},
        InvalidSourceError,
        "point 4 of the PointCloud is missing",
    ),
}


@pytest.mark.parametrize("row", BAD)
def test_bad_input_is_one_typed_error(row):
    shape, source, options, error, message = BAD[row]
    with pytest.raises(error, match=message) as caught:
        gt.geodesic_distance(shape, source, **options)
    assert type(caught.value) is error


def test_vertices_and_faces_as_two_arguments_get_the_advice_to_give_a_pair():
    pair = r"as a pair, {}\(\(vertices, faces\), \.\.\.\)"
    with pytest.raises(UnsupportedDomainError, match=pair.format("GeodesicSolver")):
        gt.GeodesicSolver(V, F)
    with pytest.raises(UnsupportedDomainError, match=pair.format("geodesic_distance")):
        gt.geodesic_distance(V, F, 0)
    with pytest.raises(UnsupportedDomainError, match=pair.format("exact_distance")):
        gt.exact_distance(V, F, 0)


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.full((4, 3), np.nan), np.zeros((4, 2)), [["a", "b", "c"]]]
)
def test_a_cloud_of_nothing_is_refused(points):
    with pytest.raises(InvalidDomainError):
        gt.PointCloud(points)


# -- files -----------------------------------------------------------------------------------------

GARBAGE = np.random.default_rng(0).integers(0, 256, 4096, dtype=np.uint8).tobytes()
OFF = b"OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"


def command(*words):
    """Return the exit status and what was said of a command, run as a user runs it."""
    done = subprocess.run(
        [sys.executable, "-m", "geodesic_toolkit", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


BAD_FILES = {
    "truncated.off": OFF[:40],
    "garbage.ply": GARBAGE,
    "garbage.stl": GARBAGE,
    "garbage.glb": GARBAGE,
    "garbage.off": GARBAGE,
    "empty.obj": b"",
    "really_off.ply": OFF,
    "really_off.stl": OFF,
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_file_is_a_read_error(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(BAD_FILES[name])
    with pytest.raises(ReadError, match=name):
        gt.read(path)


@pytest.mark.slow
def test_the_command_says_in_one_line_what_is_wrong(tmp_path):
    good = tmp_path / "square.off"
    good.write_bytes(OFF)
    garbage = tmp_path / "garbage.ply"
    garbage.write_bytes(GARBAGE)
    for words, status in [
        (("distance", garbage, "--source", 0), 3),
        (("distance", good, "--source", 4), 2),
        (("distance", tmp_path, "--source", 0), 2),
        (("distance", good, "--source", 0, "--output", tmp_path / "no" / "d.npy"), 2),
    ]:
        code, out, err = command(*words)
        assert code == status, err
        assert out == ""
        assert "Traceback" not in err


@pytest.mark.slow
def test_a_coarse_mesh_is_named_by_command_and_doctor(tmp_path):
    path = tmp_path / "square.off"
    path.write_bytes(OFF)
    code, out, err = command("distance", path, "--source", 0, "--no-refine", "--json")
    assert code == 0
    assert "has 4 vertices" in err + " ".join(map(str, json.loads(out)["warnings"]))
    code, out, _ = command("doctor", path, "--json")
    told = json.loads(out)
    assert told["diagnosis"]["coarse_components"] == 1
    assert told["diagnosis"]["refined"]  # which needs no more vertices
    assert not any("divide the faces" in line for line in told["recommendations"])


def test_an_output_that_cannot_be_written_leaves_the_old_one(tmp_path):
    folder = tmp_path / "out.npy"
    folder.mkdir()
    with pytest.raises(WriteError):
        write(folder, MESH, np.zeros(N))
    assert folder.is_dir()


def test_a_source_in_other_units_warns():
    solver = gt.GeodesicSolver(shapes.icosphere(2))
    with pytest.warns(FarSourceWarning, match="are the units the same"):
        solver.distance([1000.0, 0.0, 0.0])
    solver.distance([1.3, 0.0, 0.0])


def test_a_path_asks_for_a_solver_by_name():
    with pytest.raises(InvalidOptionError, match=r"GeodesicSolver\(mesh\)"):
        gt.geodesic_path(shapes.icosphere(1), 0, 1)


# -- arrays with a mask ----------------------------------------------------------------------------


def masked(values, *entries):
    array = np.ma.array(values)
    for entry in entries:
        array[entry] = np.ma.masked
    return array


MASKED = {
    "vertices": lambda: gt.TriangleMesh(masked(V, 3), F),
    "faces": lambda: gt.geodesic_distance((V, masked(F, 3)), 0),
    "points": lambda: gt.as_domain(masked(V, 3)),
    "normals": lambda: gt.PointCloud(V, masked(V, (1, 2))),
    "lengths": lambda: gt.Graph(3, [[0, 1], [1, 2]], masked([1.0, 2.0], 1)),
    "mask": lambda: gt.GeodesicSolver(MESH, mask=masked(np.zeros(N, bool), 3)),
    "sources": lambda: gt.geodesic_distance(MESH, masked([0, 5], 1)),
    "source sets": lambda: gt.GeodesicSolver(MESH).distances(masked([0, 5], 1)),
    "offsets": lambda: gt.OffsetSources([0, 5], masked([0.0, 0.5], 1)),
    "curve": lambda: gt.Curve(masked(V[:2], 1)),
    "points to ask": lambda: gt.GeodesicSolver(MESH).query(masked(V, 3), 0),
    "distance": lambda: gt.GeodesicSolver(MESH).interpolate(masked(np.ones(N), 3), V[:1]),
}


@pytest.mark.parametrize("what", MASKED)
def test_an_array_in_which_something_is_masked_is_refused_and_not_read_as_if_nothing_was(what):
    with pytest.raises(GeodesicError, match=r"is a masked array, and entry \[.*an array without a"):
        MASKED[what]()


def test_an_array_in_which_nothing_is_masked_is_an_array():
    mesh = gt.TriangleMesh(np.ma.array(V), np.ma.array(F))
    distance = gt.geodesic_distance(mesh, np.ma.array([0, 5]), mask=np.ma.array(np.zeros(N, bool)))
    np.testing.assert_array_equal(distance, gt.geodesic_distance(MESH, [0, 5]))


@pytest.mark.parametrize("refine", [0, 1, None, "yes", 1.0])
def test_a_refine_that_is_neither_a_truth_value_nor_auto_is_refused(refine):
    with pytest.raises(InvalidOptionError, match='refine must be True, False or "auto"'):
        gt.GeodesicSolver(MESH, refine=refine)


@pytest.mark.parametrize(
    "asked",
    [
        lambda mesh: gt.distance_matrix(mesh, [0, 5]),
        lambda mesh: gt.farthest_point_sampling(mesh, 3),
        lambda mesh: gt.geodesic_voronoi(mesh, [0, 5]),
        lambda mesh: gt.eikonal_residual(mesh, np.zeros(N)),
        lambda mesh: gt.geodesic_path(mesh, 0, 5),
    ],
)
def test_a_mesh_in_the_place_of_its_solver_is_refused_with_the_cure(asked):
    with pytest.raises(InvalidOptionError, match=r"needs a GeodesicSolver, not a TriangleMesh"):
        asked(MESH)


@pytest.mark.parametrize("unit", [1e-320, 1e-110, 1e80, 1e150, 1e300])
def test_clouds_out_of_the_range_of_floats_are_refused(unit):
    points = gt.testing.shapes.icosphere(1).vertices
    with pytest.raises(UnsupportedDomainError, match=r"the cloud is .* wide: .* another unit"):
        gt.geodesic_distance(gt.PointCloud(unit * points), 0)
    expected = gt.geodesic_distance(gt.PointCloud(points), 0)
    for scale in (1e-70, 1e70):
        distance = gt.geodesic_distance(gt.PointCloud(scale * points), 0)
        np.testing.assert_allclose(distance / scale, expected, rtol=1e-12)


SPHERE = shapes.icosphere(1)
SOLVER = gt.GeodesicSolver(SPHERE)

FIELDS = {
    "isolines": lambda values: gt.isolines(SPHERE, values, 1.0),
    "area": lambda values: gt.area_above(SPHERE, values, 1.0),
    "interpolation": lambda values: SOLVER.interpolate(values, SPHERE.vertices[:2]),
    "residual": lambda values: gt.eikonal_residual(SOLVER, values),
    "file": lambda values: write("never-written.npy", SPHERE, values),
    "density": lambda values: gt.centroidal_voronoi(SOLVER, [0, 1], density=values),
    "disc": lambda values: gt.geodesic_disc(SOLVER, 0, 1.0).carry(values),
    "scene": gt.viz.two_sided,
    "vectors": lambda values: gt.parallel_transport(SOLVER, 0, values),
    "map": lambda values: gt.exp_map(SOLVER, 0, values),
    "mean": lambda values: gt.geodesic_mean(SOLVER, range(42), weights=values),
}
"""Functions that take numbers at vertices, or several of them."""


@pytest.mark.parametrize("ask", FIELDS.values(), ids=FIELDS)
@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.ones(42) * 1j, "must hold real numbers, not numbers of complex128"),
        (["1.5"] * 42, "must hold real numbers, not <U3"),
        (np.zeros(42, dtype="M8[s]"), "must hold real numbers, not datetime64"),
        (np.ones(42).astype(object), "must hold real numbers, not object"),
        ([[1.0], [1.0, 2.0]], "cannot be read as an array"),
        ([None] * 42, "must hold real numbers, not object"),
        ({0: 1.0}, "must hold real numbers, not object"),
        (np.ma.masked_equal(np.arange(42), 3), r"is a masked array, and entry \[3\] is masked"),
    ],
    ids=["complex", "text", "dates", "objects", "ragged", "nothing", "mapping", "masked"],
)
def test_fields_that_are_not_real_numbers_are_refused_everywhere(ask, values, message):
    with pytest.raises(InvalidOptionError, match=message):
        ask(values)


def test_distances_that_are_nan_are_not_interpolated():
    distance = SOLVER.distance(0)
    distance[7] = np.nan
    with pytest.raises(InvalidOptionError, match="distance is nan at vertex 7; where there is no"):
        SOLVER.interpolate(distance, SPHERE.vertices[:2])


# -- numbers, names of files and shapes in every function that takes them --------------------------

NUMBERS = {
    "time": lambda value: gt.GeodesicSolver(SPHERE, time=value),
    "time_factor": lambda value: gt.GeodesicSolver(SPHERE, time_factor=value),
    "max_distance": lambda value: gt.distance_matrix(SOLVER, [0], max_distance=value),
    "a level": lambda value: gt.area_above(SPHERE, np.zeros(42), value),
}


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [True, np.True_, "1", [1.0], np.ones(1), 1j, {}, b"1"], ids=repr)
def test_numbers_are_numbers(name, value):
    with pytest.raises(InvalidOptionError, match=f"{name} must be a number, not "):
        NUMBERS[name](value)


FILES = {
    "read": gt.read,
    "points": gt.read_points,
    "mask": lambda path: gt.read_mask(path, 3),
    "vertices": gt.read_vertices,
    "polygons": gt.read_polygons,
    "curves": lambda path: gt.read_curves(path, SPHERE),
    "write": lambda path: gt.write(path, SPHERE, np.zeros(42)),
    "like": lambda path: gt.write("never-written.ply", SPHERE, np.zeros(42), like=path),
    "matrix": lambda path: gt.distance_matrix(SOLVER, [0], out=path),
}


@pytest.mark.parametrize("ask", FILES.values(), ids=FILES)
@pytest.mark.parametrize("path", [3, True, ["a.ply"], b"a.ply", {}], ids=repr)
def test_the_name_of_a_file_is_text_or_a_path(ask, path):
    with pytest.raises(InvalidOptionError, match="the name of a file must be text or a path, not"):
        ask(path)


@pytest.mark.parametrize("thing", [None, "mesh", 3, {}, []])
def test_what_is_not_a_shape_is_refused_where_shapes_are_written_or_compared(thing, tmp_path):
    with pytest.raises(UnsupportedDomainError, match="is not a shape"):
        gt.write(tmp_path / "d.npy", thing, [0.0])
    with pytest.raises(UnsupportedDomainError, match="is not a shape"):
        gt.variants_for(thing)
    assert not list(tmp_path.iterdir())


def test_distances_on_an_object_of_another_library_are_written(tmp_path):
    write(tmp_path / "d.csv", (V, F), np.zeros(len(V)))
    assert (tmp_path / "d.csv").read_text().startswith("vertex,x,y,z,distance\n0,")


def test_offsets_of_nothing_and_vertices_without_number_are_refused():
    with pytest.raises(InvalidSourceError, match="one for each source, not"):
        gt.OffsetSources([0], [])
    with pytest.raises(InvalidDomainError, match="more than indices can count"):
        gt.Graph(2**70, [[0, 1]])


ARRAY = np.zeros(3)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: gt.CotanLaplacian(mass=ARRAY), "mass must be"),
        (lambda: gt.CotanLaplacian(intrinsic_delaunay=ARRAY), "intrinsic_delaunay must be"),
        (lambda: gt.UniformLaplacian(mass=ARRAY), "mass must be"),
        (lambda: gt.UniformLaplacian(dim=ARRAY), "dim"),
        (lambda: gt.PointCloudLaplacian(normals=ARRAY), "normals must be"),
        (lambda: gt.GeodesicSolver(SPHERE, boundary=ARRAY), "boundary must be"),
        (lambda: gt.GeodesicSolver(SPHERE, operator=ARRAY), "is not an operator"),
        (lambda: gt.GeodesicSolver(SPHERE, solver=ARRAY), "is not a solver"),
        (lambda: gt.positive_part(ARRAY), "metric must be a Discretization, which operator.ass"),
        (
            lambda: gt.HeatMethod(SPHERE, heat_solver=gt.CG(), poisson_solver=gt.CG()),
            "metric must be a Discretization, which .* not a TriangleMesh",
        ),
        (
            lambda: gt.HeatMethod(SOLVER.method.metric, heat_solver="cg", poisson_solver=gt.CG()),
            r"heat_solver must be a LinearSolver, such as Supernodal\(\), not a str",
        ),
        (lambda: gt.read(__file__, kinds=gt.TriangleMesh), r"a list of kinds .*\[TriangleMesh\]"),
        (lambda: gt.read(__file__, kinds="mesh"), "a list of kinds of domain"),
        (lambda: gt.read(__file__, kinds=["mesh"]), "kinds holds 'mesh', which is not a kind"),
    ],
)
def test_options_of_another_type_are_refused_by_their_names(ask, message):
    with pytest.raises(InvalidOptionError, match=message):
        ask()
