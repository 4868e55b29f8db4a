"""Solids from files, on the command line, in files and pictures."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit_volume import TetMesh, VoxelImage
from geodesic_toolkit_volume.samples import box, subdivided

VERTICES, CELLS = box((4, 3, 3), 0.5)
BODY = np.ones((4, 3, 2), dtype=bool)
BODY[1, 1, 1] = False


@pytest.mark.parametrize(
    ("suffix", "form"), [("mesh", "medit"), ("msh", "gmsh"), ("vtk", "vtk"), ("vtu", "vtu")]
)
def test_tetrahedra_are_read_through_meshio(tmp_path, suffix, form):
    meshio = pytest.importorskip("meshio")
    file = tmp_path / f"solid.{suffix}"
    meshio.Mesh(VERTICES, [("tetra", CELLS)]).write(file, file_format=form)
    mesh = gt.read(file)
    assert isinstance(mesh, TetMesh)
    np.testing.assert_array_equal(mesh.cells, CELLS)
    np.testing.assert_allclose(mesh.vertices, VERTICES)


@pytest.mark.parametrize(
    ("suffix", "form"), [("mesh", "medit"), ("msh", "gmsh"), ("vtk", "vtk"), ("vtu", "vtu")]
)
def test_a_surface_is_left_to_the_core(tmp_path, suffix, form):
    meshio = pytest.importorskip("meshio")
    file = tmp_path / f"surface.{suffix}"
    meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]).write(file, file_format=form)
    assert isinstance(gt.read(file), gt.TriangleMesh)


def test_a_wanted_kind_gets_the_surface_of_a_solid(tmp_path):
    meshio = pytest.importorskip("meshio")
    file = tmp_path / "solid.mesh"
    meshio.Mesh(VERTICES, [("tetra", CELLS)]).write(file)
    surface = gt.read(file, kinds=[gt.TriangleMesh])
    assert isinstance(surface, gt.TriangleMesh)
    assert surface.n_faces == len(TetMesh(VERTICES, CELLS).triangles)
    assert isinstance(gt.read(file, kinds=[TetMesh]), TetMesh)
    assert isinstance(gt.read(file, kinds=[gt.PointCloud]), TetMesh)  # which operators then refuse


def test_a_solid_of_the_shared_data_converges(shared_data):
    solid = gt.read(shared_data("igltut__octopus-low.mesh"))
    assert (solid.n_vertices, len(solid.cells)) == (452, 1140)
    distance = gt.GeodesicSolver(solid).distance(0)
    straight = np.linalg.norm(solid.vertices - solid.vertices[0], axis=1)
    assert (distance >= straight * (1 - 1e-9)).all()
    finer = gt.GeodesicSolver(subdivided(solid)).distance(0)[: solid.n_vertices]
    away = finer > 0
    assert np.abs(distance[away] / finer[away] - 1).mean() < 0.01  # 0.6 % were measured


@pytest.mark.parametrize("name", ["broken.mesh", "broken.msh", "broken.vtk", "broken.vtu"])
def test_a_damaged_file_is_named(tmp_path, name):
    file = tmp_path / name
    file.write_text("MeshVersionFormatted 1\nTetrahedra\n3\n1 2 x\n")
    with pytest.raises(ReadError, match=name):
        gt.read(file)


@pytest.mark.parametrize("first", [0, 1])
def test_files_of_tetgen_are_read_by_either_name(tmp_path, first):
    write_tetgen(tmp_path, first)
    for name in ("solid.node", "solid.ele"):
        mesh = gt.read(tmp_path / name)
        np.testing.assert_array_equal(mesh.cells, CELLS)
        np.testing.assert_allclose(mesh.vertices, VERTICES)


def write_tetgen(folder, first):
    rows = [f"{k + first} {x} {y} {z} 7" for k, (x, y, z) in enumerate(VERTICES)]
    nodes = "\n".join([f"{len(rows)} 3 1 0  # nodes", *rows])
    (folder / "solid.node").write_text(nodes + "\n# made by hand\n")
    rows = [f"{k + first} " + " ".join(map(str, cell + first)) for k, cell in enumerate(CELLS)]
    (folder / "solid.ele").write_text("\n".join([f"{len(rows)} 4 0", *rows]))


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        ("4 3 0 0\n0 0 0 0\n", "4 rows are announced, 1 follow"),
        ("1 3 0 0\n5 0 0 0\n", "numbered from 0 or 1"),
        ("1 3 0 0\n0 0 zero 0\n", "could not convert"),
        ("# nothing\n", "solid.node"),
    ],
)
def test_damaged_files_of_tetgen_are_refused(tmp_path, nodes, message):
    write_tetgen(tmp_path, 0)
    (tmp_path / "solid.node").write_text(nodes)
    with pytest.raises(ReadError, match=message):
        gt.read(tmp_path / "solid.ele")
    (tmp_path / "solid.node").unlink()
    with pytest.raises(ReadError, match=r"solid\.node is missing"):
        gt.read(tmp_path / "solid.ele")


@pytest.mark.parametrize("name", ["body.nii", "body.nii.gz"])
def test_a_nifti_image_has_its_affine(tmp_path, name):
    nibabel = pytest.importorskip("nibabel")
    affine = np.diag([2.0, 1.0, 3.0, 1.0])
    affine[:3, 3] = [5, 6, 7]
    nibabel.save(nibabel.Nifti1Image(BODY.astype(np.int16), affine), tmp_path / name)
    image = gt.read(tmp_path / name)
    assert isinstance(image, VoxelImage)
    np.testing.assert_array_equal(image.mask, BODY)
    assert image.spacing == (2.0, 1.0, 3.0)
    assert image.positions[0].tolist() == [5.0, 6.0, 7.0]


def test_a_nifti_image_of_nothing_or_of_four_axes_is_refused(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    for shape, message in (((2, 2, 2), "the body is empty"), ((2, 2, 2, 3), "three axes")):
        image = nibabel.Nifti1Image(np.zeros(shape, dtype=np.int16), np.eye(4))
        nibabel.save(image, tmp_path / "body.nii")
        with pytest.raises(ReadError, match=message):
            gt.read(tmp_path / "body.nii")


@pytest.mark.parametrize("of_cells", [True, False])
def test_a_vtk_image_is_read(tmp_path, of_cells):
    write_vti(tmp_path / "body.vti", of_cells)
    image = gt.read(tmp_path / "body.vti")
    np.testing.assert_array_equal(image.mask, BODY)
    assert image.spacing == (2.0, 1.0, 0.5)
    half = 0.5 if of_cells else 0.0
    np.testing.assert_allclose(image.positions[0], [10 + 2 * half, 20 + half, 30 + 0.5 * half])


def write_vti(file, of_cells, scalars=True):
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    data = vtkImageData()
    data.SetDimensions(*(np.array(BODY.shape) + of_cells).tolist())
    data.SetSpacing(2.0, 1.0, 0.5)
    data.SetOrigin(10, 20, 30)
    if scalars:
        array = numpy_support.numpy_to_vtk(BODY.transpose(2, 1, 0).ravel().astype(np.uint8), 1)
        (data.GetCellData() if of_cells else data.GetPointData()).SetScalars(array)
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(file))
    writer.SetInputData(data)
    writer.Write()


def test_a_vtk_image_without_scalars_and_another_file_are_refused(tmp_path):
    write_vti(tmp_path / "body.vti", False, scalars=False)
    with pytest.raises(ReadError, match="no scalars"):
        gt.read(tmp_path / "body.vti")
    (tmp_path / "other.vti").write_text("<VTKFile type='PolyData'></VTKFile>")
    with pytest.raises(ReadError, match="not a VTK XML image"):
        gt.read(tmp_path / "other.vti")


@pytest.mark.parametrize("suffix", ["ply", "vtu", "csv", "npy"])
def test_distances_are_written(tmp_path, suffix):
    if suffix == "vtu":
        pytest.importorskip("vtkmodules")
    for shape in (TetMesh(VERTICES, CELLS), VoxelImage(BODY)):
        file = tmp_path / f"distance.{suffix}"
        gt.write(file, shape, gt.GeodesicSolver(shape).distance(0))
        assert file.stat().st_size > 0


def test_cells_are_written_with_their_distances(tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh, file = TetMesh(VERTICES, CELLS), tmp_path / "distance.vtu"
    distance = gt.GeodesicSolver(mesh).distance(0)
    gt.write(file, mesh, distance)
    np.testing.assert_array_equal(gt.read(file).cells, CELLS)
    np.testing.assert_array_equal(meshio.read(file).point_data["distance"], distance)


@pytest.mark.parametrize("name", ["distance.nii", "distance.nii.gz", "distance.vti"])
def test_images_are_written_with_their_distances_and_places(tmp_path, name):
    pytest.importorskip("nibabel")
    pytest.importorskip("vtkmodules")
    affine = np.array([[0, -2.0, 0, 5], [1.0, 0, 0, 6], [0, 0, 3.0, 7], [0, 0, 0, 1]])
    image, file = VoxelImage(BODY, affine=affine), tmp_path / name
    distance = gt.GeodesicSolver(image).distance(0)
    gt.write(file, image, distance)
    again = gt.read(file)
    np.testing.assert_array_equal(again.mask.ravel(), distance > 0)
    np.testing.assert_allclose(again.positions, image.positions)
    if name != "distance.vti":
        import nibabel

        np.testing.assert_array_equal(nibabel.load(file).get_fdata().ravel(), distance)


def test_solids_in_formats_of_others_are_refused(tmp_path):
    mesh, image = TetMesh(VERTICES, CELLS), VoxelImage(BODY)
    says = r"this format is for VoxelImage, not for a TetMesh; can be written: \.ply, .*\.vtu"
    for name in ("distance.nii", "distance.nii.gz", "distance.vti"):
        with pytest.raises(InvalidOptionError, match=says):
            gt.write(tmp_path / name, mesh, np.zeros(mesh.n_vertices))
    with pytest.raises(InvalidOptionError, match=r"not for a Graph; .*: \.gii, \.npy"):
        gt.write(tmp_path / "distance.nii", mesh.as_graph(), np.zeros(mesh.n_vertices))
    with pytest.raises(InvalidOptionError, match=r"can be written: .*\.nii, \.nii\.gz, \.vti$"):
        gt.write(tmp_path / "distance.foo", image, np.zeros(image.n_vertices))
    with pytest.raises(InvalidOptionError, match="distances must be real numbers of shape"):
        gt.write(tmp_path / "distance.vti", image, [0.0])
    assert not list(tmp_path.iterdir())


def test_the_command_line_writes_the_formats_of_solids(tmp_path):
    from typer.testing import CliRunner

    from geodesic_toolkit.cli.program import app

    pytest.importorskip("vtkmodules")
    nibabel = pytest.importorskip("nibabel")
    body, out = tmp_path / "body.nii.gz", tmp_path / "distance.vti"
    nibabel.save(nibabel.Nifti1Image(BODY.astype(np.int16), np.eye(4)), body)
    call = ["distance", str(body), "--source", "0", "--output"]
    result = CliRunner().invoke(app, [*call, str(out)])
    assert result.exit_code == 0, result.output
    expected = gt.GeodesicSolver(VoxelImage(BODY)).distance(0)
    np.testing.assert_array_equal(gt.read(out).mask.ravel(), expected > 0)
    write_tetgen(tmp_path, 0)
    call[1] = str(tmp_path / "solid.ele")
    result = CliRunner().invoke(app, [*call, str(tmp_path / "d.nii")])
    assert result.exit_code == 2
    assert "this format is for VoxelImage, not for a TetMesh" in result.output
    result = CliRunner().invoke(app, [*call, str(tmp_path / "d.vtu")])
    assert result.exit_code == 0, result.output
    np.testing.assert_array_equal(gt.read(tmp_path / "d.vtu").cells, CELLS)


def test_the_command_line_measures_a_solid(tmp_path):
    from typer.testing import CliRunner

    from geodesic_toolkit.cli.program import app

    write_tetgen(tmp_path, 0)
    out = tmp_path / "distance.npy"
    call = ["distance", str(tmp_path / "solid.ele"), "--source", "0", "--output", str(out)]
    result = CliRunner().invoke(app, call)
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(np.load(out), np.linalg.norm(VERTICES, axis=1), rtol=0.01)


def test_solids_are_drawn(tmp_path):
    pytest.importorskip("pyvista")
    for shape in (TetMesh(VERTICES, CELLS), VoxelImage(BODY)):
        distance = gt.GeodesicSolver(shape).distance(0)
        gt.viz.plot(shape, distance, path=tmp_path / "solid.png")
        assert (tmp_path / "solid.png").stat().st_size > 0
