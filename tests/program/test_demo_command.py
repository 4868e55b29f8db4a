"""The command ``demo``: does it write all that it promises, or say why not?"""

import sys

import pytest
from command_line import fails, run


@pytest.mark.slow
def test_demo_writes_numbers_a_picture_and_a_page(tmp_path):
    pytest.importorskip("pyvista")
    pytest.importorskip("k3d")
    out = tmp_path / "new" / "folder"
    result = run("demo", "--out", out)
    assert result.exit_code == 0, result.output
    assert {path.name for path in out.iterdir()} == {
        "knot.ply",
        "knot.csv",
        "knot.png",
        "knot.html",
    }
    assert "against the exact arc length" in result.stdout
    assert "geodesic-toolkit distance YOUR_MESH.ply" in result.stdout
    assert result.stderr == ""


def test_demo_writes_the_numbers_where_nothing_can_be_drawn(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "k3d", None)
    result = run("demo", "--out", tmp_path)
    assert result.exit_code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"knot.ply", "knot.csv"}
    assert "warning: " in result.stderr
    assert "geodesic-toolkit[viz]" in result.stderr


def test_demo_refuses_a_folder_that_cannot_be(tmp_path):
    (tmp_path / "file").write_text("")
    fails(run("demo", "--out", tmp_path / "file" / "folder"), 2, "cannot be made")
