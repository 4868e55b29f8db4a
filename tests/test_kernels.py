"""When is waiting for compiled kernels worth it, and are they there?"""

import os
import sys

import pytest

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
