"""fsaverage5 as neuroimagers use it: its medial wall, parcels, neighbourhoods, GIFTI."""

import numpy as np
import pytest

import geodesic_toolkit as gt

nilearn_data = pytest.importorskip("nilearn.datasets", reason="fsaverage5 comes with nilearn")
nibabel = pytest.importorskip("nibabel")


@pytest.fixture(scope="module")
def surface():
    return gt.as_domain(nilearn_data.load_fsaverage("fsaverage5")["pial"].parts["left"])


@pytest.fixture(scope="module")
def wall(surface):
    """Return the medial wall: the vertices that the flat map of the hemisphere leaves out."""
    flat = nilearn_data.load_fsaverage("fsaverage5")["flat"].parts["left"]
    wall = np.ones(surface.n_vertices, dtype=bool)
    wall[flat.faces] = False
    return wall


@pytest.fixture(scope="module")
def solver(surface, wall):
    return gt.GeodesicSolver(surface, mask=wall)


def test_paths_do_not_cross_the_medial_wall(surface, wall, solver):
    source = int(np.flatnonzero(~wall)[0])
    around, through = solver.distance(source), gt.geodesic_distance(surface, source)
    assert np.isinf(around[wall]).all()
    assert np.isfinite(around[~wall]).all()
    longer = around[~wall] - through[~wall]
    assert longer.min() > -0.5
    assert longer.max() > 5.0


def test_distances_are_near_the_exact_ones(surface):
    exact = gt.exact_distance(surface, 5000)
    error = np.abs(gt.geodesic_distance(surface, 5000) - exact).mean() / exact.mean()
    assert error < 0.008


def test_parcels_are_sources_and_have_a_matrix(surface, wall, solver):
    height = np.digitize(surface.vertices[:, 2], [-20, 10, 40])
    parcels = [np.flatnonzero((height == i) & ~wall) for i in range(4)]
    rows = solver.distances(parcels)
    nearest = np.array([[row[parcel].min() for parcel in parcels] for row in rows])
    np.testing.assert_array_equal(np.diag(nearest), 0.0)
    np.testing.assert_allclose(nearest, nearest.T, atol=1.5)
    assert (np.diff(nearest[0]) > 0).all()
    cells = gt.geodesic_voronoi(solver, [int(parcel[0]) for parcel in parcels])
    assert set(np.unique(cells[~wall])) == {0, 1, 2, 3}


def test_neighbourhoods_are_the_near_part_of_the_matrix(wall, solver):
    some = np.flatnonzero(~wall)[::200]
    near = gt.distance_matrix(solver, some, max_distance=10.0)
    rows = gt.distance_matrix(solver, some)
    kept = near.toarray()
    np.testing.assert_allclose(kept[kept > 0], rows[kept > 0])
    assert near.max() <= 10.0
    assert near.nnz == np.count_nonzero(rows <= 10.0)


def test_distances_go_to_gifti(tmp_path, surface, solver):
    distance = solver.distance(5000)
    gt.write(tmp_path / "lh.distance.shape.gii", surface, distance)
    (array,) = nibabel.load(tmp_path / "lh.distance.shape.gii").darrays
    finite = np.isfinite(distance)
    np.testing.assert_allclose(array.data[finite], distance[finite], rtol=1e-6)
