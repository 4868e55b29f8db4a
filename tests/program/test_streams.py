"""Standard input and output in place of files."""

import gzip
import subprocess
import sys

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt


@pytest.mark.parametrize("suffix", [".off", ".ply", ".obj", ".vtk", ".vtp", ".vtu", ".stl", ".gii"])
def test_a_mesh_is_read_from_standard_input(tmp_path, suffix):
    path = tmp_path / f"sphere{suffix}"
    sphere = gt.testing.shapes.icosphere(2)
    write_mesh(path, sphere)
    by_file = run("distance", path, "--source", 0, "--output", tmp_path / "file.npy")
    assert by_file.exit_code == 0, by_file.output
    piped = run(
        "distance", "-", "--source", 0, "--output", tmp_path / "d.npy", input=path.read_bytes()
    )
    assert piped.exit_code == 0, piped.output
    np.testing.assert_array_equal(np.load(tmp_path / "d.npy"), np.load(tmp_path / "file.npy"))
    assert "stdin" not in piped.stdout


def write_mesh(path, mesh):
    """Write a mesh in the format of a suffix, by the library that people use for it."""
    if path.suffix in (".ply", ".vtp", ".vtk", ".vtu"):
        gt.write(path, mesh, np.zeros(mesh.n_vertices))
    elif path.suffix == ".gii":
        nibabel = pytest.importorskip("nibabel")
        arrays = [
            nibabel.gifti.GiftiDataArray(mesh.vertices.astype("f4"), "NIFTI_INTENT_POINTSET"),
            nibabel.gifti.GiftiDataArray(mesh.faces.astype("i4"), "NIFTI_INTENT_TRIANGLE"),
        ]
        nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), path)
    else:
        import trimesh

        made = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        text = made.export(file_type="stl_ascii" if path.suffix == ".stl" else path.suffix[1:])
        path.write_text(text if isinstance(text, str) else text.decode())


def test_distances_go_to_standard_output_without_a_summary(sphere_file, tmp_path):
    run("distance", sphere_file, "--source", 0, "--output", tmp_path / "d.csv")
    piped = run("distance", sphere_file, "--source", 0, "--output", "-.csv")
    assert piped.exit_code == 0, piped.output
    assert piped.stdout == (tmp_path / "d.csv").read_text()


def test_a_binary_output_is_whole(sphere_file, tmp_path):
    run("distance", sphere_file, "--source", 0, "--output", tmp_path / "d.npy")
    piped = run("distance", sphere_file, "--source", 0, "--output", "-.npy")
    assert piped.stdout_bytes == (tmp_path / "d.npy").read_bytes()


def test_lines_go_to_standard_output(sphere_file):
    piped = run("isolines", sphere_file, "--source", 0, "--level", 0.5, "--output", "-.obj")
    assert piped.exit_code == 0, piped.output
    assert piped.stdout.startswith(("#", "v "))


def test_bytes_of_an_unknown_format_are_bad_input():
    for content in (b"", b"\x00\x01\x02", gzip.compress(b"OFF")):
        fails(run("distance", "-", "--source", 0, input=content), 3, "not recognised")


def test_a_stream_needs_a_format(sphere_file):
    fails(run("distance", sphere_file, "--source", 0, "--output", "-"), 2, "needs a format")
    fails(run("matrix", sphere_file, "--output", "-.zarr"), 2, "folder")


def test_a_stream_is_used_once(sphere_file):
    both = ["--output", "-.csv", "--picture", "-.png"]
    fails(run("distance", sphere_file, "--source", 0, *both), 2, "the same stream")
    fails(run("distance", "-", "-", "--source", 0, input=b"OFF"), 2, "the same stream")


def test_json_and_an_output_do_not_share_standard_output(sphere_file):
    result = run("distance", sphere_file, "--source", 0, "--output", "-.csv", "--json")
    fails(result, 2, "--json")


def test_an_error_in_a_piped_file_names_standard_input():
    failed = run("distance", "-", "--source", 0, input=b"OFF\n3 1 0\n0 0 0\n1 0 0\n")
    assert failed.exit_code == 3
    assert "stdin.off" in failed.stderr


def test_a_reader_that_leaves_early_is_not_an_error(tmp_path):
    gt.write(tmp_path / "grid.ply", gt.testing.shapes.grid(60), np.zeros(3600))
    command = f"{sys.executable} -m geodesic_toolkit distance grid.ply --source 0 --output=-.csv -q"
    done = subprocess.run(
        f"{command} | head -n 1",
        shell=True,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1
