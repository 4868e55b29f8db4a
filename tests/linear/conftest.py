"""Systems that tests of solvers share."""

import pytest
from matrices import LAPLACIANS, plus, stiffness
from scipy.sparse import csr_array

from geodesic_toolkit.testing import shapes


@pytest.fixture(scope="module", params=LAPLACIANS)
def laplacian(request):
    """A singular matrix of each kind, one after the other."""
    return csr_array(LAPLACIANS[request.param]())


@pytest.fixture
def sphere_system():
    """A definite system of 162 unknowns."""
    return plus(stiffness(shapes.icosphere(2)), 0.3)
