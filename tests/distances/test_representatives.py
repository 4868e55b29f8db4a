"""Does each vertex read the distance of its representative, refined or not?"""

import dataclasses

import numpy as np
import pytest

import geodesic_toolkit as gt


@pytest.mark.parametrize("refine", [False, True])
def test_a_vertex_reads_the_distance_of_its_representative(refine):
    sphere = gt.testing.shapes.icosphere(2)
    twin = gt.TriangleMesh(np.concatenate([sphere.vertices, sphere.vertices[:5]]), sphere.faces)
    count = sphere.n_vertices
    metric = dataclasses.replace(
        gt.CotanLaplacian().assemble(twin),
        representatives=np.concatenate([np.arange(count), np.arange(5)]),
    )
    method = gt.HeatMethod(
        metric, heat_solver=gt.Supernodal(), poisson_solver=gt.Supernodal(), refine=refine
    )
    for source in (7, 2, count + 2):
        found = method.distance(source)
        assert found[source] == 0
        np.testing.assert_array_equal(found[count:], found[:5])
        np.testing.assert_array_equal(found, method.distance(source % count))
