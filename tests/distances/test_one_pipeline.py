"""Meshes, clouds and graphs share every line after `assemble`."""

import sys
from pathlib import Path

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.testing import shapes

PACKAGE = Path(gt.__file__).parent
PIPELINE = {
    str(PACKAGE / name)
    for name in (
        "heat/method.py",
        "heat/diffusion.py",
        "heat/graphs.py",
        "heat/positive.py",
        "sources/points.py",
        "heat/log_range.py",
        "linear/superlu.py",
    )
}


def sphere_as(kind):
    sphere = shapes.icosphere(3)
    if kind == "mesh":
        return sphere
    if kind == "cloud":
        return gt.PointCloud(sphere.vertices)
    edges = np.unique(np.sort(sphere.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(sphere.vertices[edges[:, 0]] - sphere.vertices[edges[:, 1]], axis=1)
    return gt.Graph(sphere.n_vertices, edges, lengths)


def lines_run(work):
    """The lines of the pipeline's files that `work` executes."""
    seen = set()

    def trace(frame, event, argument):
        if frame.f_code.co_filename not in PIPELINE:
            return None
        if event == "line":
            seen.add((Path(frame.f_code.co_filename).name, frame.f_lineno))
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        work()
    finally:
        sys.settrace(before)
    return seen


def solve(kind):
    domain = sphere_as(kind)
    operator = {
        "mesh": gt.CotanLaplacian(),
        "cloud": gt.PointCloudLaplacian(),
        "graph": gt.UniformLaplacian(dim=2),
    }[kind]
    metric = operator.assemble(domain)
    diffusion = operator.diffusion(metric)
    superlu = gt.SuperLU()

    def work():
        method = gt.HeatMethod(
            metric, diffusion=diffusion, heat_solver=superlu, poisson_solver=superlu
        )
        method.distances([0, [5, 9]])

    return lines_run(work)


@pytest.mark.parametrize("kind", ["cloud", "graph"])
def test_a_cloud_and_a_graph_run_the_very_lines_of_a_mesh(kind):
    lines = solve("mesh")
    assert len(lines) > 100
    # A graph is held to the paths along its edges besides.
    assert solve(kind) == lines if kind == "cloud" else solve(kind) > lines


def test_the_three_agree_on_the_sphere():
    mesh, *others = (
        gt.geodesic_distance(sphere_as(kind), 0) for kind in ("mesh", "cloud", "graph")
    )
    away = mesh > 0.3
    for distance in others:
        np.testing.assert_allclose(distance[away], mesh[away], rtol=0.06)
