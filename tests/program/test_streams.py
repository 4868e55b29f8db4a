"""Standard input and output in place of files."""

import codecs
import gzip
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt

PROGRAM = f"{shlex.quote(sys.executable)} -m geodesic_toolkit"


def shell(command, cwd=None):
    """Run a line of a shell, with the redirections that it has."""
    return subprocess.run(command, shell=True, cwd=cwd, capture_output=True, text=True, check=False)


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
    fails(failed, 3, "error: -: ")


def test_a_piped_file_may_begin_with_a_byte_order_mark():
    mesh = codecs.BOM_UTF8 + b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    assert run("distance", "-", "--source", 0, input=mesh).exit_code == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is full")
def test_a_full_standard_output_is_an_error_that_says_so(sphere_file):
    for option in ([], ["--json"], ["--output", "-.csv"]):
        done = shell(f"{PROGRAM} distance {sphere_file} --source 0 {' '.join(option)} > /dev/full")
        assert done.returncode == 2
        assert done.stderr.startswith("error: standard output cannot be written: No space left")
        assert done.stderr.count("\n") == 1
    assert shell(f"{PROGRAM} distance {sphere_file} --source 999 2> /dev/full").returncode == 2


def test_a_closed_stream_is_wrong_usage(sphere_file):
    done = shell(f"{PROGRAM} distance - --source 0 <&-")
    assert (done.returncode, done.stdout) == (2, "")
    assert "standard input, which is closed" in done.stderr
    done = shell(f"{PROGRAM} distance {sphere_file} --source 0 --output -.csv >&-")
    assert done.returncode == 2
    assert "standard output, which is closed" in done.stderr


def test_a_full_folder_of_temporary_files_is_an_error_that_names_it(tmp_path):
    mesh = gt.testing.shapes.grid(200)
    gt.write(tmp_path / "grid.ply", mesh, np.zeros(mesh.n_vertices))
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1024, 1024))"
    program = f"import runpy; {limit}; runpy.run_module('geodesic_toolkit', run_name='__main__')"
    command = [sys.executable, "-c", program, "distance", "-", "--source", "0"]
    with (tmp_path / "grid.ply").open("rb") as given:
        done = subprocess.run(command, stdin=given, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("error: standard input cannot be stored in ")


def test_results_without_a_reader_are_not_an_error(tmp_path):
    for name in ("a.ply", "b.ply"):
        gt.write(tmp_path / name, gt.testing.shapes.grid(4), np.zeros(16))
    command = f"{PROGRAM} distance a.ply b.ply --source 0 --output {{name}}.npy"
    done = shell(f"({command}; echo $? > status) | true", cwd=tmp_path)
    assert done.stderr == ""
    assert (tmp_path / "status").read_text() == "0\n"
    assert (tmp_path / "b.npy").exists()


def test_a_reader_that_leaves_early_is_not_an_error(tmp_path):
    gt.write(tmp_path / "grid.ply", gt.testing.shapes.grid(60), np.zeros(3600))
    command = f"{PROGRAM} distance grid.ply --source 0 --output=-.csv -q"
    done = shell(f"{command} | head -n 1", cwd=tmp_path)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1
