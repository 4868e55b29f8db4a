"""Does it agree with the default solver, and refuse by name?"""

import sys
from types import ModuleType

import numpy as np
import pytest
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError, SolverError
from geodesic_toolkit_cholmod import Cholmod

AGREEMENT = 1e-6
"""Difference of distances on a unit sphere from those of the default solver."""


@pytest.fixture
def sphere():
    pytest.importorskip("sksparse.cholmod", reason="scikit-sparse is not installed")
    return gt.testing.shapes.icosphere(3)


@pytest.mark.parametrize("mode", ["simplicial", "supernodal"])
@pytest.mark.parametrize("refine", [True, False])
def test_distances_agree_with_those_of_the_default_solver(sphere, mode, refine):
    ours = gt.GeodesicSolver(sphere, solver=Cholmod(mode=mode), refine=refine).distance(0)
    default = gt.GeodesicSolver(sphere, refine=refine).distance(0)
    np.testing.assert_allclose(ours, default, atol=AGREEMENT)


def test_distances_far_away_are_those_along_a_long_strip(sphere):
    strip = gt.testing.shapes.grid(1500, 2)
    solver = gt.GeodesicSolver(strip, solver="cholmod", refine=False)
    default = gt.GeodesicSolver(strip, refine=False)
    np.testing.assert_allclose(solver.distance(0), default.distance(0), rtol=AGREEMENT)


def test_a_matrix_that_rounding_keeps_from_being_singular_is_refused(sphere):
    barely = csr_array([[1.0, -1.0], [-1.0, 1.0 + 2e-16]])
    with pytest.raises(SolverError, match="singular to working precision"):
        Cholmod().factorize(barely)


@pytest.mark.parametrize("option", ["mode", "ordering"])
def test_an_option_that_is_not_known_is_refused(option):
    with pytest.raises(InvalidOptionError, match=f"{option} must be one of"):
        Cholmod(**{option: "other"})


def test_another_version_of_scikit_sparse_is_refused_by_name(monkeypatch):
    monkeypatch.setitem(sys.modules, "sksparse", ModuleType("sksparse"))
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", ModuleType("sksparse.cholmod"))
    with pytest.raises(MissingDependencyError, match="which a newer version has replaced"):
        Cholmod()


def test_without_scikit_sparse_the_message_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", None)
    with pytest.raises(MissingDependencyError, match="libsuitesparse-dev"):
        Cholmod()
