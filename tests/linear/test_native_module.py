"""Do the compiled kernels load for each level of processor, and refuse what is not theirs?"""

import importlib
import os
import subprocess
import sys

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit import _native

ROUNDING = 1e-9  # levels differ in whether a product and a sum are rounded once or twice


def run(code, *arguments, level=""):
    """Run `code` in a process of its own, with a level chosen in its environment."""
    options = ["-P"]  # not the checkout beside it
    if sys.flags.no_site:  # nor an editable install, which this process does not see
        options.append("-S")
    return subprocess.run(
        [sys.executable, *options, "-c", code, *map(str, arguments)],
        env={**os.environ, "GEODESIC_TOOLKIT_LEVEL": str(level)},
        capture_output=True,
        text=True,
        check=False,
    )


# -- levels ----------------------------------------------------------------------------------------


def test_the_level_is_a_number():
    assert type(_native.LEVEL) is int
    assert _native.LEVEL in {2, 3, 4}


def test_registers_are_those_of_the_level():
    assert {2: 2, 3: 4, 4: 8}[_native.LEVEL] == _native.LANES


DISTANCES = """
import sys
import numpy as np
import geodesic_toolkit as gt
from geodesic_toolkit import _native
mesh = gt.testing.shapes.icosphere(4)
fields = []
for refine in (False, True):
    fields.extend(gt.GeodesicSolver(mesh, refine=refine).distances(range(20)))
np.save(sys.argv[1], fields)
print(_native.LEVEL)
"""


def fields(level, folder):
    """Return distances on a mesh of about one unit, as kernels of some level find them."""
    finished = run(DISTANCES, folder / "fields.npy", level=level)
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.strip() == str(level)
    return np.load(folder / "fields.npy")


@pytest.mark.slow
@pytest.mark.parametrize("level", [2, 3, 4])
def test_distances_do_not_depend_on_the_level(level, tmp_path):
    if level > _native._processor_level():
        pytest.skip(f"this processor does not have level {level}")
    if importlib.util.find_spec(f"geodesic_toolkit._native._level{level}") is None:
        pytest.skip(f"level {level} is not built: an editable install has the processor's own")
    found = fields(level, tmp_path)
    np.testing.assert_allclose(found, fields(_native.LEVEL, tmp_path), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("level", ["1", "5", "best"])
def test_an_impossible_level_is_reported(level):
    finished = run("import geodesic_toolkit._native", level=level)
    assert finished.returncode == 1
    message = finished.stderr.splitlines()[-1]
    assert message.startswith("ImportError: GEODESIC_TOOLKIT_LEVEL is ")
    assert repr(level) in message
    assert "unset it" in message


def test_no_level_above_the_processors_is_tried(monkeypatch):
    monkeypatch.setattr(_native, "_processor_level", lambda: 3)
    monkeypatch.delenv("GEODESIC_TOOLKIT_LEVEL", raising=False)
    assert _native._levels() == [3, 2]
    monkeypatch.setenv("GEODESIC_TOOLKIT_LEVEL", "4")
    with pytest.raises(ImportError, match="has the levels 2, 3: name one"):
        _native._levels()


def test_other_processors_have_one_level(monkeypatch):
    monkeypatch.setattr(_native.importlib, "import_module", missing)
    assert _native._processor_level() == 2


def missing(name):
    raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def test_missing_modules_are_reported_with_advice(monkeypatch):
    monkeypatch.setattr(_native, "_processor_level", lambda: 3)
    monkeypatch.delenv("GEODESIC_TOOLKIT_LEVEL", raising=False)
    monkeypatch.setattr(_native.importlib, "import_module", missing)
    with pytest.raises(ImportError, match=r"level 3 or 2 of x86-64.* builds them"):
        _native._load()


def test_the_next_lower_level_is_taken_where_one_is_missing(monkeypatch):
    def found(name):
        return name if name.endswith("_level2") else missing(name)

    monkeypatch.setattr(_native, "_processor_level", lambda: 4)
    monkeypatch.delenv("GEODESIC_TOOLKIT_LEVEL", raising=False)
    monkeypatch.setattr(_native.importlib, "import_module", found)
    assert _native._load() == ("geodesic_toolkit._native._level2", 2)


def test_a_module_that_is_broken_is_not_passed_by(monkeypatch):
    def broken(name):
        raise ImportError(f"{name}: undefined symbol")

    monkeypatch.setattr(_native, "_processor_level", lambda: 4)
    monkeypatch.setattr(_native.importlib, "import_module", broken)
    with pytest.raises(ImportError, match="undefined symbol"):
        _native._load()


# -- arrays ----------------------------------------------------------------------------------------

# A square of two triangles, and a matrix on its vertices that is definite.
VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
INDPTR, INDICES = np.array([0, 2, 4, 6, 8], np.int32), np.array([0, 1, 0, 1, 2, 3, 2, 3], np.int32)
DATA = np.array([2.0, -1, -1, 2, 2, -1, -1, 2])
EDGES = np.array([[0, 1], [2, 3]])
FRAMES, AREAS = np.ones((2, 3)), np.ones(2)
TWIN = np.array([-1, 4, -1, -1, 1, -1])
HELD = np.zeros(4, dtype=bool)
LENGTHS = np.array([[1.0, 2**0.5, 1.0], [1.0, 1.0, 2**0.5]])
UPWARDS = np.tile([0.0, 0.0, 1.0], (4, 1))
PATTERN = np.arange(0, 17, 4, dtype=np.int32), np.tile(np.arange(4, dtype=np.int32), 4)


def calls():
    """Return calls of kernels that go well, by name: the function and its arguments."""
    sides = _native.sorted_half_edges(FACES, 4)
    analysis = _native.analyze(INDPTR, INDICES)
    factor = _native.Factor(analysis, DATA)
    table = np.ones((4, 3))
    diagonal = (np.array([0, 3, 4, 7]), np.full(4, 2.0), np.arange(4.0))
    edges = _native.edges_of(FACES, 4)
    bounds = _native.Bounds(VERTICES, *edges)
    corners = _native.gather_corners(FACES, FRAMES, False, False, HELD)
    return {
        "components": (_native.components, INDPTR, INDICES),
        "components_of_edges": (_native.components_of_edges, EDGES, 4),
        "is_sound": (_native.is_sound, INDPTR, INDICES, DATA),
        "obtuse_excess": (_native.obtuse_excess, INDPTR, INDICES, DATA, np.ones(4), 2),
        "diagonal_places": (_native.diagonal_places, INDPTR, INDICES),
        "plus_diagonal": (_native.plus_diagonal, INDPTR, INDICES, DATA, *diagonal),
        "row_sums": (_native.row_sums, INDPTR, INDICES, DATA),
        "edges_of": (_native.edges_of, FACES, 4),
        "Bounds": (_native.Bounds, VERTICES, *edges),
        "hold": (bounds.hold, np.array([0, 1]), VERTICES[:1], np.zeros(1), np.ones((1, 4))),
        "hold_near": (
            bounds.hold_near,
            np.array([0, 1]),
            VERTICES[:1],
            np.zeros(1),
            np.array([0, 2]),
            np.array([0, 1]),
            np.ones(2),
            np.ones(1),
        ),
        "cross_near": (
            _native.GraphCorners(4, EDGES, np.ones(2)).cross_near,
            np.array([0, 1]),
            np.array([2]),
            np.zeros(1),
            np.ones(1),
            1,
        ),
        "sweep_near": (
            _native.Sweeper(corners, np.zeros(4), HELD).sweep_near,
            np.ones(4),
            False,
            np.array([0, 1]),
            np.array([2]),
            np.zeros(1),
            np.ones(1),
            np.full(1, 1e-9),
            8,
            0,
            9,
            np.ones(1),
        ),
        "faces_at": (_native.faces_at, FACES, HELD),
        "is_symmetric": (_native.is_symmetric, INDPTR, INDICES),
        "minimum_degree": (_native.minimum_degree, INDPTR, INDICES),
        "analyze": (_native.analyze, INDPTR, INDICES),
        "eliminate_front": (_native.eliminate_front, np.full(6, 3.0), 3, 2),
        "Factor": (_native.Factor, analysis, DATA),
        "solve": (factor.solve, np.ones(4), np.ones(4)),
        "solve_table": (factor.solve, table, table.copy()),
        "proper_faces": (_native.proper_faces, FACES, 4),
        "measure_triangles": (_native.measure_triangles, VERTICES, FACES),
        "measure_lengths": (_native.measure_lengths, FRAMES),
        "edge_lengths": (_native.edge_lengths, FRAMES),
        "sorted_half_edges": (_native.sorted_half_edges, FACES, 4),
        "edge_sums": (_native.edge_sums, FACES, sides, FRAMES, AREAS),
        "mirrored": (_native.mirrored, np.array([0, 1, 1, 2, 2], np.int32), INDICES[[1, 5]], AREAS),
        "mean_edge_length": (_native.mean_edge_length, VERTICES, INDPTR, INDICES),
        "flip_edges": (_native.flip_edges, FACES.copy(), FRAMES.copy(), TWIN.copy(), HELD),
        "flip_edges_with_directions": (
            _native.flip_edges_with_directions,
            FACES.copy(),
            FRAMES.copy(),
            TWIN.copy(),
            HELD,
            np.zeros(6),
            np.ones(6),
        ),
        "vertex_normals": (_native.vertex_normals, VERTICES, FACES),
        "tangent_axes": (_native.tangent_axes, UPWARDS),
        "unit_vectors": (_native.unit_vectors, np.ones(4)),
        "to_space": (_native.to_space, np.ones((4, 2)), UPWARDS, UPWARDS),
        "polar_form": (_native.polar_form, np.ones((4, 2))),
        "polar_directions": (
            _native.polar_directions,
            VERTICES,
            FACES,
            LENGTHS,
            TWIN,
            HELD[:2],
            UPWARDS,
            np.roll(UPWARDS, 1, axis=1),
        ),
        "bisectors": (_native.bisectors, LENGTHS, np.zeros(6), np.ones(6)),
        "triangle_turns": (_native.triangle_turns, LENGTHS, np.zeros((2, 3)), HELD[:2]),
        "space_turns": (
            _native.space_turns,
            VERTICES,
            FACES,
            UPWARDS,
            np.roll(UPWARDS, 1, axis=1),
            False,
        ),
        "straight_lines": (
            _native.straight_lines,
            LENGTHS,
            TWIN,
            np.array([0]),
            np.full((1, 3), 1 / 3),
            np.zeros(1),
            np.ones(1),
            10,
        ),
        "connection_laplacian": (
            _native.connection_laplacian,
            *PATTERN,
            FACES,
            FRAMES,
            AREAS,
            np.tile([1.0, 0.0], (2, 3)),
        ),
        "edge_turns": (_native.edge_turns, *PATTERN, FACES, np.tile([1.0, 0.0], (2, 3))),
        "real_form": (
            _native.real_form,
            *PATTERN,
            np.ones((len(PATTERN[1]), 2)),
            np.ones(4),
            np.ones(4),
        ),
        "poisson_load": (_native.poisson_load, FACES, FRAMES, AREAS, np.ones(4), False),
        "angle_defects": (_native.angle_defects, FACES, FRAMES, HELD),
        "gather_corners": (_native.gather_corners, FACES, FRAMES, False, False, HELD),
        "in_sight": (
            _native.in_sight,
            np.array([0, 3]),
            FACES[0],
            np.full(3, 0.6),
            FACES,
            FRAMES,
            False,
            HELD,
        ),
        "falling": (_native.falling, np.ones(4), False),
        "fill": (_native.fill, INDPTR, INDICES, DATA, np.ones(4), np.array([0], np.int32)),
    }


CALLS = calls()
WRITES = {
    "solve",
    "solve_table",
    "flip_edges",
    "flip_edges_with_directions",
    "fill",
    "hold",
    "hold_near",
}
ARRAYS = [
    (name, place)
    for name, (_, *arguments) in CALLS.items()
    for place, argument in enumerate(arguments)
    if isinstance(argument, np.ndarray)
]


def call(name, place, array):
    """Call a kernel with another array in one place."""
    function, *arguments = CALLS[name]
    arguments[place] = array
    return function(*arguments)


@pytest.mark.parametrize("name", CALLS)
def test_what_fits_is_taken(name):
    function, *arguments = CALLS[name]
    function(*arguments)


@pytest.mark.parametrize(("name", "place"), ARRAYS)
def test_arrays_of_another_type_are_not_converted(name, place):
    array = CALLS[name][1 + place]
    for dtype in {np.float64, np.float32, np.int64, np.int32, np.uint8} - {array.dtype.type}:
        with pytest.raises(TypeError, match="incompatible function arguments"):
            call(name, place, array.astype(dtype))


@pytest.mark.parametrize(("name", "place"), ARRAYS)
def test_arrays_with_gaps_are_not_copied(name, place):
    if (name, place) == ("fill", 3):
        pytest.skip("a column of a table is what it is for")
    array = CALLS[name][1 + place]
    gaps = np.repeat(array, 2, axis=-1)[..., ::2]
    if array.shape[-1] == 1:
        pytest.skip("one number has no gaps")
    assert not gaps.flags.c_contiguous
    with pytest.raises(TypeError, match="incompatible function arguments"):
        call(name, place, gaps)


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("solve", 1),
        ("flip_edges", 0),
        ("flip_edges", 1),
        ("flip_edges", 2),
        ("flip_edges_with_directions", 4),
        ("flip_edges_with_directions", 5),
        ("fill", 3),
        ("fill", 4),
        ("hold", 3),
    ],
)
def test_what_may_not_be_written_to_is_not(name, place):
    array = CALLS[name][1 + place].copy()
    array.flags.writeable = False
    with pytest.raises(TypeError, match="incompatible function arguments"):
        call(name, place, array)


@pytest.mark.parametrize(
    ("name", "place", "array"),
    [
        ("components", 0, np.array([0, 2, 4, 6, 9], np.int32)),  # one more than there are indices
        ("components", 0, np.array([1, 2, 4, 6, 8], np.int32)),
        ("components", 0, np.array([], np.int32)),
        ("components_of_edges", 0, np.zeros((2, 3), np.int64)),
        ("diagonal_places", 1, INDICES[:-1]),
        ("plus_diagonal", 3, np.array([0, 3, 4])),
        ("plus_diagonal", 4, np.ones(2)),
        ("plus_diagonal", 5, np.ones(5)),
        ("row_sums", 2, DATA[:-1]),
        ("edges_of", 0, np.zeros((3, 2), np.int64)),
        ("Bounds", 0, np.ones((5, 3))),
        ("hold", 3, np.ones((1, 3))),
        ("hold_near", 3, np.array([0, 3])),
        ("hold_near", 4, np.array([0, 4])),  # a vertex that there is not
        ("hold_near", 6, np.ones(2)),
        ("cross_near", 1, np.array([4])),
        ("cross_near", 3, np.ones(2)),
        ("sweep_near", 0, np.ones(3)),
        ("sweep_near", 3, np.array([4])),
        ("sweep_near", 10, np.ones(2)),
        ("faces_at", 0, np.zeros((3, 2), np.int64)),
        ("is_symmetric", 1, INDICES[:-1]),
        ("minimum_degree", 1, INDICES[:-1]),
        ("eliminate_front", 0, np.ones(5)),
        ("angle_defects", 1, np.ones((3, 3))),
        ("gather_corners", 1, np.ones((3, 3))),
        ("analyze", 1, INDICES[:-1]),
        ("is_sound", 2, DATA[:-1]),
        ("obtuse_excess", 3, np.ones(5)),
        ("Factor", 1, np.append(DATA, 1.0)),
        ("solve", 0, np.ones(5)),
        ("solve", 0, np.ones((5, 1))),
        ("solve", 0, np.ones((4, 2))),  # for which there is no space
        ("solve", 0, np.ones((2, 2))),
        ("solve", 1, np.ones(3)),
        ("solve_table", 0, np.ones((4, 3, 1))),
        ("solve_table", 1, np.ones((4, 4))),
        ("proper_faces", 0, np.zeros((2, 4), np.int64)),
        ("measure_triangles", 0, np.ones((4, 2))),
        ("measure_triangles", 1, np.zeros((2, 4), np.int64)),
        ("measure_lengths", 0, np.ones((2, 2))),
        ("edge_lengths", 0, np.ones((3, 2))),
        ("sorted_half_edges", 0, np.zeros((3, 2), np.int64)),
        ("edge_sums", 0, np.zeros((3, 3), np.int64)),
        ("edge_sums", 2, np.ones((3, 3))),
        ("edge_sums", 3, np.ones(1)),
        ("mirrored", 2, np.ones(3)),
        ("mean_edge_length", 0, np.ones((3, 3))),
        ("flip_edges", 1, np.ones((3, 3))),
        ("flip_edges", 2, np.zeros(5, np.int64)),
        ("flip_edges_with_directions", 4, np.zeros(5)),
        ("vertex_normals", 0, np.ones((4, 2))),
        ("tangent_axes", 0, np.ones((4, 2))),
        ("polar_directions", 3, np.zeros(5, np.int64)),
        ("polar_directions", 4, HELD),
        ("polar_directions", 5, np.ones((3, 3))),
        ("bisectors", 1, np.zeros(5)),
        ("triangle_turns", 1, np.zeros((1, 3))),
        ("space_turns", 1, np.zeros((2, 4), np.int64)),
        ("space_turns", 2, np.ones((3, 3))),
        ("straight_lines", 1, np.zeros(5, np.int64)),
        ("straight_lines", 2, np.array([2])),  # a face that there is not
        ("straight_lines", 4, np.zeros(2)),
        ("connection_laplacian", 5, np.ones((2, 3))),
        ("connection_laplacian", 1, PATTERN[1][:-1]),
        ("edge_turns", 3, np.ones((2, 3))),
        ("real_form", 2, np.ones((16, 1))),
        ("real_form", 3, np.ones(3)),
        ("in_sight", 0, np.array([0, 2])),
        ("in_sight", 0, np.array([0, 1, 3])),
        ("in_sight", 1, np.array([0, 1, 4])),
        ("in_sight", 2, np.ones(2)),
        ("in_sight", 4, np.ones((3, 3))),
        ("in_sight", 6, HELD[:2]),
        ("polar_form", 0, np.ones((4, 3))),
        ("to_space", 0, np.ones((3, 2))),
        ("to_space", 0, np.ones((4, 3))),
        ("to_space", 2, np.ones((3, 3))),
        ("poisson_load", 1, np.ones((3, 3))),
        ("poisson_load", 2, np.ones(3)),
        ("poisson_load", 3, np.ones((4, 2, 2))),
        ("fill", 3, np.ones(3)),
        ("fill", 3, np.ones(4)[::-1]),
    ],
)
def test_shapes_that_do_not_match_are_reported(name, place, array):
    with pytest.raises(ValueError, match="arrays do not fit together: "):
        call(name, place, array)


def test_memory_for_numbers_is_had_and_given_back():
    large = _native.empty(1_000_000)
    large[:] = np.arange(1_000_000)
    other = _native.empty(1_000_000)
    other[:] = 0
    np.testing.assert_array_equal(large, np.arange(1_000_000))
    del large, other
    _native.trim()
    assert _native.empty(0).shape == (0,)
    with pytest.raises(ValueError, match="a number of numbers"):
        _native.empty(-1)


def test_a_number_is_not_a_column():
    with pytest.raises(ValueError, match="arrays do not fit together: "):
        call("solve", 0, np.array(1.0))


def test_no_analysis_is_a_type_error():
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _native.Factor(None, DATA)


def test_a_solver_error_is_that_of_the_package():
    with pytest.raises(gt.errors.SolverError, match=r"not positive definite .* vertex"):
        _native.Factor(_native.analyze(INDPTR, INDICES), -DATA)


def test_arrays_outlive_what_they_are_of():
    order = _native.analyze(INDPTR, INDICES).order
    assert sorted(order) == [0, 1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        order[0] = 1


@pytest.mark.parametrize("kept", [lambda i, j: i == j, lambda i, j: i != j, lambda i, j: i <= j])
def test_a_pattern_that_lacks_entries_has_no_connection_laplacian(kept):
    rows = [[j for j in range(4) if kept(i, j)] for i in range(4)]
    indptr = np.cumsum([0, *map(len, rows)], dtype=np.int32)
    _, _, _, *others = CALLS["connection_laplacian"]
    lacking = indptr, np.concatenate(rows).astype(np.int32)
    assert _native.connection_laplacian(*lacking, *others) is None
