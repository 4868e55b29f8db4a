"""Every check of the project, in the order of what fails fastest.

``nox`` runs all of them, ``nox -s tests`` one, ``nox -s tests -- -k tube`` one with arguments. All
but the last run in the environment that nox itself is installed in, which ``tools/setup.sh dev``
makes.
"""

import importlib.util
import os
import shutil
import sys
import sysconfig
import tomllib
from pathlib import Path

import nox

nox.options.default_venv_backend = "none"

ROOT = Path(__file__).parent
BIN = Path(sys.executable).parent
NATIVE = ROOT / "native"
PROSE = [
    *("geodesic_toolkit", "docs", "native", "tests", "plugins", "benchmarks", "tools"),
    "changelog.d",
    *sorted(path.name for path in ROOT.glob("*.md")),
]
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/pyproject.toml"))

WITHOUT_WHEELS = {"cholmod": "sksparse"}
"""Plugins that call a library without wheels, which is their extra of that name, and its module."""

BUILT_HERE = sorted(map(str, ROOT.glob("build/petsc/*.whl")))
"""The wheel of petsc4py, which tools/petsc.sh builds where PETSc is installed."""


def run(session: nox.Session, tool: str, *arguments: str, **options: dict[str, str]) -> None:
    """Run a tool of this environment, which need not be on the path."""
    found = shutil.which(tool, path=BIN)
    if found is None:
        session.error(f"{tool} is not installed beside nox; run: bash tools/setup.sh dev")
    session.run(found, *arguments, **options)


def sources(*kinds: str) -> list[str]:
    """Return the files of the compiled kernels that have such endings, or all of them."""
    kinds = kinds or (".c", ".h", ".cpp", ".hpp")
    return sorted(str(path) for path in NATIVE.rglob("*") if path.suffix in kinds)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, formatting, spelling, and the order in which modules may import each other."""
    run(session, "ruff", "check", ".")
    run(session, "ruff", "format", "--check", ".")
    run(session, "clang-format", "--dry-run", "-Werror", *sources())
    run(session, "lint-imports", "--no-cache")
    run(session, "codespell", *PROSE)
    run(session, "zizmor", "--offline", "--quiet", ".github/workflows")
    run(session, "towncrier", "build", "--draft", "--version", "next", silent=True)


@nox.session
def prose(session: nox.Session) -> None:
    """Plain words in all texts: tools/prose.toml lists those to replace, with better ones."""
    session.run(sys.executable, "tools/prose.py", *session.posargs, external=True)


@nox.session
def types(session: nox.Session) -> None:
    """Types, strictly: of the package, and of a user's program by both common checkers."""
    run(session, "mypy")
    run(session, "mypy", "tests/typing")
    run(session, "pyright", "--pythonpath", sys.executable)


def test(session: nox.Session, *options: str) -> None:
    """Run pytest with the programs of this environment on the path, as mpiexec has to be."""
    path = os.pathsep.join([str(BIN), os.environ.get("PATH", os.defpath)])
    arguments = [*options, *(session.posargs or ["tests"])]
    run(session, "pytest", "-n", "auto", *arguments, env={"PATH": path})


@nox.session
def tests(session: nox.Session) -> None:
    """The tests; arguments after ``--`` go to pytest."""
    test(session)


@nox.session(default=False)
def coverage(session: nox.Session) -> None:
    """The tests with their coverage, which has a floor: ``[tool.coverage]`` has the numbers."""
    test(session, "--cov", "--cov-report=term")


@nox.session
def doctests(session: nox.Session) -> None:
    """The examples in docstrings."""
    packages = ["geodesic_toolkit", *map(str, sorted(ROOT.glob("plugins/*/src")))]
    run(session, "pytest", "-n", "auto", "--doctest-modules", *packages)


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation with its executed gallery; a warning is an error."""
    arguments = ["-W", "--keep-going", "-q", "-b", "html", "docs", "docs/_build/html"]
    run(session, "sphinx-build", *arguments)


# -- the compiled kernels --------------------------------------------------------------------------


def configure(session: nox.Session, name: str, *options: str) -> Path:
    """Set up a build of the kernels, with warnings as errors, and return its folder."""
    build = ROOT / "build" / name
    chosen = ["-DCMAKE_BUILD_TYPE=Release", "-DGT_WERROR=ON", *(f"-D{each}" for each in options)]
    if shutil.which("ninja", path=BIN):
        chosen += ["-GNinja", f"-DCMAKE_MAKE_PROGRAM={BIN / 'ninja'}"]
    run(session, "cmake", "-S", str(NATIVE), "-B", str(build), *chosen, silent=True)
    return build


def build_and_test(session: nox.Session, name: str, *options: str) -> Path:
    """Build the kernels with the programs that test them without Python, and run these."""
    build = configure(session, name, "GT_SELF_TEST=ON", *options)
    run(session, "cmake", "--build", str(build), "--parallel", silent=True)
    for program in sorted(build.glob("self_test?")):
        session.run(str(program), external=True)
    return build


def self_test(session: nox.Session, name: str, *options: str) -> None:
    """Do the same without the modules of Python."""
    build_and_test(session, name, "GT_PYTHON=OFF", *options)


def host_level() -> int:
    """Return the level of this processor, as the installed package reports it."""
    try:
        from geodesic_toolkit._native import _processor
    except ImportError:  # not an x86-64 processor: one build serves them all
        return 2
    return int(_processor.LEVEL)


def sanitizer_libraries(session: nox.Session) -> list[str]:
    """Return what a Python that was built without sanitizers has to load before all else."""
    compiler = os.environ.get("CXX", "c++")
    names = ("libasan.so", "libubsan.so", "libstdc++.so")
    asked = [[compiler, f"-print-file-name={name}"] for name in names]
    return [str(session.run(*each, silent=True, external=True)).strip() for each in asked]


KERNEL_TESTS = (
    "tests/linear/test_native_module.py",
    "tests/linear/test_supernodal_*.py",
    "tests/shapes/test_cloud_kernels.py",
    "tests/distances/test_wavefronts.py",
)
"""Tests in Python that give kernels arrays of every kind, for sanitizers."""


def python_options(session: nox.Session) -> list[str]:
    """Return what CMake has to know to build the modules for this Python."""
    nanobind = session.run(
        sys.executable, "-m", "nanobind", "--cmake_dir", silent=True, external=True
    )
    return [f"Python_EXECUTABLE={sys.executable}", f"nanobind_DIR={str(nanobind).strip()}"]


def sanitized_python(session: nox.Session, build: Path, libraries: list[str]) -> None:
    """Run the tests of the kernels in Python on a build with sanitizers."""
    site = build / "site"
    shutil.rmtree(site, ignore_errors=True)
    run(session, "cmake", "--install", str(build), "--prefix", str(site), silent=True)
    shutil.copytree(ROOT / "geodesic_toolkit", site / "geodesic_toolkit", dirs_exist_ok=True)
    environment = {
        "PYTHONPATH": os.pathsep.join([str(site), sysconfig.get_path("purelib")]),
        "LD_PRELOAD": os.pathsep.join(libraries),
        "ASAN_OPTIONS": "detect_leaks=0",  # the interpreter's own are many
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }
    tests = {pattern: sorted(ROOT.glob(pattern)) for pattern in KERNEL_TESTS}
    if missing := [pattern for pattern, found in tests.items() if not found]:
        session.error(f"there are no tests of kernels called {', '.join(missing)}")
    # -S and -P: not the editable install, and not the checkout beside the tests. A sanitizer ends
    # the process, so that pytest may not hold back what it has said. Tests of memory measure what
    # sanitizers change.
    python = [sys.executable, "-S", "-P"]
    options = ["-m", "pytest", "-p", "no:cacheprovider", "--capture=sys", "-q", "-k", "not memory"]
    workers = ["--tx", f"2*popen//python={' '.join(python)}", "--dist", "load"]
    paths = [str(path) for found in tests.values() for path in found]
    session.run(*python, *options, *workers, *paths, env=environment, external=True)


@nox.session
def sanitize(session: nox.Session) -> None:
    """The kernels under sanitizers: addresses and undefined behaviour, also in Python; threads."""
    if sys.platform == "win32":
        session.skip("sanitizers as GCC and Clang have them are for other systems")
    # Level 2 has no instruction with a mask, which would hide from the sanitizer what is read.
    # One build serves the programs and the modules of Python.
    options = ["GT_SANITIZE=address,undefined,float-cast-overflow", "GT_LEVELS=2"]
    libraries = sanitizer_libraries(session) if sys.platform == "linux" else []
    in_python = bool(libraries) and all(Path(library).is_absolute() for library in libraries)
    if in_python:
        options += python_options(session)
    else:
        session.log("not the tests in Python: the compiler has no sanitizers to load ahead")
        options.append("GT_PYTHON=OFF")
    build = build_and_test(session, "sanitized", *options)
    if in_python:
        sanitized_python(session, build, libraries)
    level = min(3, host_level())
    self_test(session, "sanitized-threads", "GT_SANITIZE=thread", f"GT_LEVELS={level}")


@nox.session(default=False)
def builds(session: nox.Session) -> None:
    """The kernels in the other builds: sanitized on every level, plain loops, Clang, all levels."""
    if sys.platform == "win32":
        session.skip("sanitizers as GCC and Clang have them are for other systems")
    host = host_level()
    if others := [str(level) for level in (3, 4) if level <= host]:
        alone = "GT_SANITIZE=address,undefined,float-cast-overflow"
        self_test(session, "sanitized-levels", alone, f"GT_LEVELS={';'.join(others)}")
    self_test(session, "plain-loops", f"GT_LEVELS={host}", "GT_PLAIN_LOOPS=ON")
    if clang := shutil.which("clang++"):
        self_test(session, "clang", f"CMAKE_CXX_COMPILER={clang}", f"GT_LEVELS={host}")
    # A wheel has every level of processor, and the editable install of other sessions has one.
    build = configure(session, "levels", *python_options(session))
    run(session, "cmake", "--build", str(build), "--parallel", silent=True)
    site = build / "site"
    shutil.rmtree(site, ignore_errors=True)
    run(session, "cmake", "--install", str(build), "--prefix", str(site), silent=True)
    shutil.copytree(ROOT / "geodesic_toolkit", site / "geodesic_toolkit", dirs_exist_ok=True)
    environment = {"PYTHONPATH": os.pathsep.join([str(site), sysconfig.get_path("purelib")])}
    options = ["-S", "-P", "-m", "pytest", "-p", "no:cacheprovider", "-q"]
    levels = str(ROOT / "tests" / "linear" / "test_native_module.py")
    session.run(sys.executable, *options, levels, env=environment, external=True)


@nox.session(default=False)
def tidy(session: nox.Session) -> None:
    """clang-tidy on the kernels, as native/.clang-tidy has it: some minutes, not by default."""
    tool = shutil.which("clang-tidy")
    if tool is None:
        session.error(
            "clang-tidy is not installed; on Debian and Ubuntu: apt-get install clang-tidy"
        )
    build = configure(session, "tidy", "GT_PYTHON=OFF", "GT_SELF_TEST=ON", "GT_LEVELS=3")
    kernels = [
        file for file in sources(".cpp") if Path(file).parent.name not in {"python", "tests"}
    ]
    # GCC's options are in that build, and one of them is not known to Clang.
    options = ["-p", str(build), "--quiet", "--extra-arg=-Wno-unknown-warning-option"]
    session.run(tool, *options, *(session.posargs or kernels), external=True)


@nox.session(venv_backend="uv|virtualenv")
def plugins(session: nox.Session) -> None:
    """Wheels of the core and of every plugin, in an environment with nothing else in it."""
    if not PLUGINS:
        session.skip("there are no plugins")
    wheels = Path(session.create_tmp()) / "wheels"
    shutil.rmtree(wheels, ignore_errors=True)
    # The kernels for this processor alone, as other sessions have them: `builds` tries every level.
    # The build tools are in this environment, and the next run finds the objects again.
    here = ["--no-isolation", "-Ccmake.define.GT_LEVELS=host"]
    for project, options in [(ROOT, here), *((plugin, []) for plugin in PLUGINS)]:
        build = ["-m", "build", "--wheel", "--outdir", str(wheels), *options, str(project)]
        session.run(sys.executable, *build, silent=True, external=True)
    # Libraries without wheels are built where this environment has them, too.
    built = [name for name, module in WITHOUT_WHEELS.items() if importlib.util.find_spec(module)]
    extras = {f"geodesic_toolkit_{name}": f"[{name}]" for name in built}
    chosen = [f"{path}{extras.get(path.name.split('-')[0], '')}" for path in wheels.glob("*.whl")]
    session.install(*sorted(chosen), *BUILT_HERE, "pytest")
    session.run("geodesic-toolkit", "plugins")
    for plugin in PLUGINS:
        project = tomllib.loads((plugin / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        for kind in ("operators", "solvers"):
            for name in project.get("entry-points", {}).get(f"geodesic_toolkit.{kind}", {}):
                if name in WITHOUT_WHEELS and name not in built:
                    session.warn(f"{name} is not checked: {WITHOUT_WHEELS[name]} is not installed")
                elif name.startswith("petsc") and not BUILT_HERE:
                    session.warn(f"{name} is not checked: bash tools/petsc.sh builds petsc4py")
                else:
                    session.run("geodesic-toolkit", "check", name)
        if (plugin / "tests").is_dir():
            with session.chdir(plugin):  # away from the checkout: the wheels are what is tested
                # Open3D installs dash, whose pytest plugin warns of its own making.
                session.run("pytest", "-p", "no:dash", "--rootdir", ".", "tests")
    new_plugins(session)


def new_plugins(session: nox.Session) -> None:
    """Write a plugin of every kind, check its style and types, install its wheel, run its tests."""
    fresh = Path(session.create_tmp()).resolve() / "fresh"
    shutil.rmtree(fresh, ignore_errors=True)
    kinds = ("operator", "domain", "solver", "reader", "command")
    folders = [str(fresh / f"fresh-{kind}") for kind in kinds]
    for kind in kinds:
        written = ["new-plugin", f"fresh-{kind}", "--kind", kind, "--directory", str(fresh)]
        session.run("geodesic-toolkit", *written, silent=True)
    packages = [f"{folder}/src" for folder in folders]
    style = (
        f"src={[str(ROOT), *packages]}",
        "lint.per-file-ignores={'test_*'=['ARG','D','PLR','S']}",
    )
    overrides = [word for each in style for word in ("--config", each)]
    ruff = ["--no-cache", "--config", str(ROOT / "pyproject.toml"), *overrides, *folders]
    run(session, "ruff", "check", *ruff)
    run(session, "ruff", "format", "--check", *ruff)
    run(session, "mypy", "--strict", *packages)
    session.install(*folders)
    # One process for all, with the options of one: imports take most of the time.
    options = ["-c", f"{folders[0]}/pyproject.toml", "--rootdir", str(fresh)]
    tests = [f"{folder}/tests" for folder in folders]
    with session.chdir(fresh):  # away from the checkout, as above
        session.run("pytest", "-q", "--import-mode=importlib", *options, *tests)
