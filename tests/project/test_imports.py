"""Start-up: nothing heavy is imported before it is used."""

import subprocess
import sys

import pytest

import geodesic_toolkit as gt

HEAVY = ("open3d", "igl", "trimesh", "sklearn", "matplotlib", "pyvista", "vtk", "numba", "k3d")


def loaded_after(statement):
    code = f"{statement}\nimport sys; print(*{{name.partition('.')[0] for name in sys.modules}})"
    result = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    return set(result.stdout.splitlines()[-1].split())


def test_importing_the_package_imports_not_even_numpy():
    assert not loaded_after("import geodesic_toolkit") & {*HEAVY, "numpy", "scipy"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "statement",
    [
        "import geodesic_toolkit as gt; list(gt.operators); gt.operators['cotan']",
        "import geodesic_toolkit as gt; gt.GeodesicSolver(gt.testing.shapes.grid(5)).distance(0)",
        "import geodesic_toolkit as gt; [getattr(gt, name) for name in gt.__all__]",
    ],
)
def test_plain_use_imports_nothing_heavy(statement):
    assert not loaded_after(statement) & set(HEAVY)


def test_every_public_name_is_there_and_listed():
    for name in gt.__all__:
        assert getattr(gt, name) is not None
    assert set(gt.__all__) <= set(dir(gt))
    assert set(gt.__all__) == {"__version__", *gt._HOMES, *gt._SUBPACKAGES}


def test_a_wrong_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'geodesics'"):
        gt.geodesics  # noqa: B018 - the access is the test


@pytest.mark.slow
def test_the_path_from_a_mesh_to_its_distances_does_not_import_scipy():
    statement = """
import geodesic_toolkit as gt, numpy as np
mesh = gt.TriangleMesh(np.eye(4)[:, :3], [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
for refine in (False, True):
    solver = gt.GeodesicSolver(mesh, refine=refine)
    solver.distance(0), solver.distances([1, 2])
"""
    assert "scipy" not in loaded_after(statement)


@pytest.mark.slow
def test_the_path_from_a_mesh_with_a_boundary_to_its_distances_does_not_import_masked_arrays():
    code = """
import sys, numpy as np
import geodesic_toolkit as gt
rows = np.arange(36).reshape(6, 6)
places = np.stack([*np.divmod(rows.ravel(), 6), 0 * rows.ravel()], axis=1)
a, b, c, d = (part.ravel() for part in (rows[:-1, :-1], rows[:-1, 1:], rows[1:, :-1], rows[1:, 1:]))
faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
square = gt.TriangleMesh(places, faces)
apart = gt.TriangleMesh(np.concatenate([places, places + 9]), np.concatenate([faces, faces + 36]))
for mesh in (square, apart):
    for refine in (False, True):
        solver = gt.GeodesicSolver(mesh, refine=refine)
        solver.distance(0), solver.distances([1, 2]), solver.distance([3, 30])
assert "numpy.ma" not in sys.modules
"""
    result = subprocess.run(
        [sys.executable, "-c", code], check=False, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
