import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_volume import TetLaplacian, TetMesh, VoxelImage, VoxelLaplacian


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(TetLaplacian()), ids=str)
def test_the_operator_on_tetrahedra_keeps_the_contract(law):
    law()


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(VoxelLaplacian()), ids=str)
def test_the_operator_on_voxels_keeps_the_contract(law):
    law()


@pytest.mark.parametrize("law", gt.testing.domain_checks(TetMesh.samples().generic), ids=str)
def test_tetrahedra_keep_the_contract_of_a_domain(law):
    law()


@pytest.mark.parametrize("law", gt.testing.domain_checks(VoxelImage.samples().generic), ids=str)
def test_voxels_keep_the_contract_of_a_domain(law):
    law()
