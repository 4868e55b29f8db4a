"""Normals at the vertices of meshes: smooth closed forms, creases, boundaries, noise."""

import numpy as np
import pytest
from curved_shapes import degrees_between, irregular_plate, irregular_sphere, outward
from geodesics import irregular_cylinder

import geodesic_toolkit as gt
from geodesic_toolkit import _native

shapes = gt.testing.shapes
ELLIPSOID = np.array([1.0, 0.8, 0.6])
RADII_OF_TORUS = 1.0, 0.4


def normals_of(points, faces):
    return _native.vertex_normals(np.ascontiguousarray(points, dtype=float), faces)


def weighted_normals(points, faces):
    """Return the normals of Max, which are exact on spheres."""
    sums = np.zeros_like(points)
    for corner in range(3):
        here = points[faces[:, corner]]
        u, v = (points[faces[:, (corner + k) % 3]] - here for k in (1, 2))
        squares = np.einsum("fd,fd->f", u, u) * np.einsum("fd,fd->f", v, v)
        np.add.at(sums, faces[:, corner], np.cross(u, v) / squares[:, None])
    return sums / np.linalg.norm(sums, axis=1)[:, None]


def ellipsoid(n):
    sphere = irregular_sphere(n)
    exact = sphere.vertices / ELLIPSOID
    exact /= np.linalg.norm(exact, axis=1)[:, None]
    return sphere.vertices * ELLIPSOID, sphere.faces, exact


def torus(n):
    """A torus of shaken vertices."""
    around, along = round((2 * n) ** 0.5), round((n / 2) ** 0.5)
    cells = np.arange(around * along).reshape(around, along)
    shake = np.random.default_rng(0).uniform(-0.3, 0.3, (2, around, along))
    u, v = (np.indices(cells.shape) + shake) * 2 * np.pi / np.array([[[around]], [[along]]])
    large, small = RADII_OF_TORUS
    exact = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    points = small * exact + large * np.stack([np.cos(u), np.sin(u), 0 * u], axis=-1)
    a, b = cells, np.roll(cells, -1, axis=0)
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate(
        [np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))]
    )
    return points.reshape(-1, 3), faces, exact.reshape(-1, 3)


@pytest.mark.parametrize(
    ("shape", "sizes", "most"), [(ellipsoid, (2000, 8000), 1e-3), (torus, (6000, 24000), 0.01)]
)
def test_normals_of_smooth_surfaces_converge_with_the_third_order(shape, sizes, most):
    tilts = []
    for n in sizes:
        points, faces, exact = shape(n)
        tilts.append(degrees_between(normals_of(points, faces), exact).mean())
        assert tilts[-1] < 0.05 * degrees_between(weighted_normals(points, faces), exact).mean()
    # Measured: 0.0040 and 0.0003 degrees; 0.014 and 0.0007.
    assert tilts[1] < most
    assert np.log2(tilts[0] / tilts[1]) > 2.7


def test_normals_of_spheres_are_those_of_max():
    mesh = irregular_sphere(900, rounds=0)
    np.testing.assert_allclose(normals_of(mesh.vertices, mesh.faces), mesh.vertices, atol=1e-11)


@pytest.mark.parametrize("noise", [0.003, 0.01, 0.1])
@pytest.mark.parametrize("shape", [ellipsoid, torus])
def test_noise_does_not_turn_normals(shape, noise):
    points, faces, exact = shape(2000)
    spacing = np.linalg.norm(points[faces[:, 0]] - points[faces[:, 1]], axis=1).mean()
    noisy = points + noise * spacing * np.random.default_rng(1).normal(size=points.shape)
    before = degrees_between(weighted_normals(noisy, faces), exact).mean()
    assert degrees_between(normals_of(noisy, faces), exact).mean() < 1.002 * before


@pytest.mark.parametrize("degrees", [10, 45, 90, 150])
def test_creases_and_the_planes_beside_them_keep_their_normals(degrees):
    plate = irregular_plate(24)
    points, faces = plate.vertices.copy(), plate.faces
    row = np.rint(23 * points[:, 0]) == 12
    points[row, 0] = 12 / 23
    angle, beyond = np.radians(degrees), points[:, 0] > 12 / 23
    x = points[beyond, 0] - 12 / 23
    points[beyond, 0], points[beyond, 2] = 12 / 23 + x * np.cos(angle), x * np.sin(angle)
    found = normals_of(points, faces)
    np.testing.assert_allclose(found, weighted_normals(points, faces), atol=1e-12)


def test_the_boundary_of_a_cylinder_keeps_its_normals():
    mesh, flat = irregular_cylinder(2000)
    rim = (flat[:, 1] == 0) | (flat[:, 1] == 3)
    found = normals_of(mesh.vertices, mesh.faces)
    before = weighted_normals(mesh.vertices, mesh.faces)
    np.testing.assert_array_less(degrees_between(found, before)[rim], 1e-9)
    exact = mesh.vertices * [1, 1, 0]
    inside = degrees_between(found, exact)[~rim]
    assert inside.mean() < 0.05 * degrees_between(before, exact)[~rim].mean()


@pytest.mark.parametrize("scale", [1e-60, 1e-6, 1e6, 1e60])
def test_normals_do_not_depend_on_the_unit(scale):
    points, faces, _ = ellipsoid(500)
    one, other = normals_of(points, faces), normals_of(scale * points, faces)
    np.testing.assert_allclose(other, one, atol=1e-12)


def test_sheets_that_meet_in_an_edge_keep_their_normals():
    points, faces, _ = ellipsoid(800)
    edge = faces[0, :2]
    fin = np.append(points, [points[edge].mean(axis=0) * 1.2], axis=0)
    found = normals_of(fin, np.append(faces, [[*edge, len(points)]], axis=0))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)


def test_where_thousands_of_edges_meet_normals_take_no_longer():
    sides = 200_000  # all pairs of vertices around the tip would be 4e10
    turn = 2 * np.pi * np.arange(sides) / sides
    points = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    faces = np.column_stack(
        [np.zeros(sides, dtype=np.int64), 1 + np.arange(sides), 1 + np.roll(np.arange(sides), -1)]
    )
    found = normals_of(np.append([[0, 0, 1.0]], points, axis=0), faces)
    np.testing.assert_allclose(found[0], [0, 0, 1], atol=1e-9)


def test_needles_and_repeated_places_have_normals():
    grid = shapes.grid(9, shear=6.0)
    points = grid.vertices + np.sin(grid.vertices[:, :1]) * [0, 0, 0.3]
    points[40] = points[41]
    found = normals_of(points, grid.faces)
    assert np.isfinite(found).all()
    assert (found[:, 2] > 0.8).all()


def test_faces_in_any_order_and_from_any_corner_have_the_same_normals():
    points, faces, exact = ellipsoid(600)
    order = np.random.default_rng(0).permutation(len(faces))
    other = normals_of(points, np.roll(faces, 1, axis=1)[order])
    np.testing.assert_allclose(other, normals_of(points, faces), atol=1e-12)
    inside_out = normals_of(points, outward(points, faces, -exact[faces[:, 0]]))
    np.testing.assert_allclose(inside_out, -normals_of(points, faces), atol=1e-12)
