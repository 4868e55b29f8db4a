"""When is waiting for compiled kernels worth it, and are they there?"""

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import caching

import geodesic_toolkit as gt
from geodesic_toolkit import _kernels

SMALL, MIDDLE, LARGE = 1000, _kernels.LOADING, _kernels.COMPILING


@pytest.fixture
def machine(monkeypatch):
    """A function that says what this process and machine have; returns what was loaded."""
    loaded = []

    def have(*, in_process: bool, on_disk: bool):
        monkeypatch.setattr(_kernels, "loaded", lambda: in_process)
        monkeypatch.setattr(_kernels, "cached", lambda: on_disk)
        monkeypatch.setattr(_kernels, "load", loaded.append)
        return loaded

    return have


def test_kernels_that_are_there_are_used_for_the_smallest_job(machine):
    loaded = machine(in_process=True, on_disk=False)
    assert _kernels.worthwhile(1)
    assert loaded == []


@pytest.mark.parametrize(
    ("n_vertices", "on_disk", "worth"),
    [
        (SMALL, False, False),
        (SMALL, True, False),
        (MIDDLE - 1, True, False),
        (MIDDLE, False, False),
        (MIDDLE, True, True),
        (LARGE - 1, False, False),
        (LARGE, False, True),
    ],
)
def test_a_job_waits_for_kernels_that_it_is_large_enough_for(machine, n_vertices, on_disk, worth):
    loaded = machine(in_process=False, on_disk=on_disk)
    assert _kernels.worthwhile(n_vertices) == worth
    assert loaded == (list(_kernels.MODULES) if worth else [])


def test_it_is_vertices_that_count_and_not_faces(machine):
    loaded = machine(in_process=False, on_disk=True)
    mesh = gt.testing.shapes.grid(180)
    assert mesh.n_vertices < MIDDLE < mesh.n_faces
    gt.CotanLaplacian().assemble(mesh)
    assert loaded == []


def test_many_sources_are_worth_a_new_factor_the_sooner_the_nearer_the_kernels_are(machine):
    def sources_needed():
        return next(k for k in range(10**6) if _kernels.worth_a_change(10_000, k))

    needed = []
    for in_process, on_disk in ((True, True), (False, True), (False, False)):
        machine(in_process=in_process, on_disk=on_disk)
        needed.append(sources_needed())
    assert needed == sorted(needed)
    assert len(set(needed)) == 3
    assert not _kernels.worth_a_change(10_000, 1)


def test_kernels_are_loaded_when_all_of_them_are(monkeypatch):
    monkeypatch.setattr(_kernels, "MODULES", ("json", "os.path"))
    assert _kernels.loaded()
    monkeypatch.setattr(_kernels, "MODULES", ("json", "geodesic_toolkit._there_is_none"))
    assert not _kernels.loaded()


# -- the cache -------------------------------------------------------------------------------------

HERE = f"py{sys.version_info.major}{sys.version_info.minor}"


@pytest.fixture
def package(monkeypatch, tmp_path):
    """A package of two modules with kernels; returns its folder."""
    folder = tmp_path / "package"
    (folder / "deeper").mkdir(parents=True)
    for name in ("_one.py", "deeper/_two.py"):
        (folder / name).touch()
    monkeypatch.setattr(_kernels, "__file__", str(folder / "_kernels.py"))
    monkeypatch.setattr(_kernels, "MODULES", ("package._one", "package.deeper._two"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path / "home" / "cache"))
    return folder


def compile_into(place, stem, *, python=HERE, age=0.0):
    place.mkdir(parents=True, exist_ok=True)
    index = place / f"{stem}.kernel-12.{python}.nbi"
    index.touch()
    time = index.stat().st_mtime - age
    os.utime(index, (time, time))


def in_numbas_words(folder):
    """What Numba calls the folder for the sources of this one."""
    from numba.core.caching import _CacheLocator

    return _CacheLocator.get_suitable_cache_subpath(str(folder / "any.py"))


def test_kernels_are_cached_when_each_module_has_an_index_beside_it(package):
    assert not _kernels.cached()
    compile_into(package / "__pycache__", "_one")
    assert not _kernels.cached()
    compile_into(package / "deeper" / "__pycache__", "_two")
    assert _kernels.cached()


@pytest.mark.parametrize("fault", [{"python": "py27"}, {"age": 3600.0}])
def test_an_index_of_another_python_or_an_older_source_does_not_count(package, fault):
    compile_into(package / "__pycache__", "_one")
    compile_into(package / "deeper" / "__pycache__", "_two", **fault)
    assert not _kernels.cached()


def test_an_index_of_the_same_source_counts_however_old_it_is(package):
    compile_into(package / "__pycache__", "_one")
    compile_into(package / "deeper" / "__pycache__", "_two", age=3600.0)
    (index,) = (package / "deeper" / "__pycache__").glob("*.nbi")
    source = (package / "deeper" / "_two.py").read_bytes()
    index.write_bytes(b"0.68" + hashlib.sha256(source).digest() + b"the rest")
    time = (package / "deeper" / "_two.py").stat().st_mtime - 3600.0
    os.utime(index, (time, time))
    assert _kernels.cached()


def test_an_index_that_numba_writes_is_known_by_its_digest(monkeypatch, tmp_path):
    source = tmp_path / "_three.py"
    source.write_text(
        "import numba\n\n@numba.njit('i8(i8)', cache=True)\ndef f(x):\n    return x\n",
        encoding="utf-8",
    )
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    code = [sys.executable, "-c", "import _three"]
    subprocess.run(code, cwd=tmp_path, check=True)
    later = source.stat().st_mtime + 3600.0
    os.utime(source, (later, later))  # as a checkout of the same source does
    assert _kernels._is_cached(source) == hasattr(caching, "_hash_source_file")


# -- helpers ---------------------------------------------------------------------------------------

ROOT = Path(_kernels.__file__).parent
IMPORT = re.compile(
    r"^from geodesic_toolkit\.(\S+) import|^from geodesic_toolkit import (\S+)", re.MULTILINE
)


def compiled_into(source):
    """What the kernels of a module take from other modules, and what these take in their turn."""
    found, waiting = set(), [source]
    while waiting:
        for match in IMPORT.finditer(waiting.pop().read_text(encoding="utf-8")):
            helper = ROOT.joinpath(*(match[1] or match[2]).split(".")).with_suffix(".py")
            if helper.exists() and helper.stem != "_typing" and helper not in found:
                found.add(helper)
                if NUMBA.search(helper.read_text(encoding="utf-8")):  # others lend constants
                    waiting.append(helper)
    return found - {source}


NUMBA = re.compile(r"^(import|from) (numba|llvmlite)", re.MULTILINE)

KERNELS = [
    source
    for source in sorted(ROOT.rglob("*.py"))
    if re.search(r"^@kernel|^\w+ = kernel\(", source.read_text(encoding="utf-8"), re.MULTILINE)
]


@pytest.mark.parametrize("source", KERNELS, ids=lambda source: source.stem)
def test_kernels_are_compiled_anew_when_what_they_are_made_of_changes(source):
    """Numba looks at the file of a kernel only, so the file says what else is compiled into it."""
    helpers = sorted(compiled_into(source))
    text = source.read_text(encoding="utf-8")
    if not helpers:
        assert "HELPERS" not in text
        return
    own_line = re.compile(r'^HELPERS = "(\w*)"$', re.MULTILINE)
    parts = [own_line.sub("", helper.read_text(encoding="utf-8")) for helper in helpers]
    digest = hashlib.sha256("".join(parts).encode()).hexdigest()[:16]
    assert own_line.findall(text) == [digest]


# -- places ----------------------------------------------------------------------------------------


def test_the_folder_that_the_environment_names_is_the_only_one(package, monkeypatch, tmp_path):
    compile_into(package / "__pycache__", "_one")
    compile_into(package / "deeper" / "__pycache__", "_two")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert not _kernels.cached()
    compile_into(tmp_path / "chosen" / in_numbas_words(package), "_one")
    compile_into(tmp_path / "chosen" / "deeper_of_another_checkout", "_two")
    assert not _kernels.cached()
    compile_into(tmp_path / "chosen" / in_numbas_words(package / "deeper"), "_two")
    assert _kernels.cached()


@pytest.mark.parametrize("system", ["linux", "darwin", "win32"])
def test_the_folder_of_the_user_counts_where_the_sources_are_not_hers(package, monkeypatch, system):
    monkeypatch.setattr(sys, "platform", system)
    folder = _kernels._user_cache()
    compile_into(package / "__pycache__", "_one")
    compile_into(folder / in_numbas_words(package / "deeper"), "_two")
    assert _kernels.cached()


def test_the_folder_of_the_user_is_the_one_that_numba_takes(package):
    from numba.misc.appdirs import AppDirs

    assert str(_kernels._user_cache()) == AppDirs(appname="numba", appauthor=False).user_cache_dir


def test_a_user_without_a_home_has_nothing_cached(package, monkeypatch):
    for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    assert not _kernels.cached()
