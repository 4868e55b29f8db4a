"""Every check of the project, in the order of what fails fastest.

``nox`` runs all of them, ``nox -s tests`` one, ``nox -s tests -- -k tube`` one with arguments. All
but the last run in the environment that nox itself is installed in, which ``tools/setup.sh dev``
makes.
"""

import shutil
import sys
import tomllib
from pathlib import Path

import nox

nox.options.default_venv_backend = "none"

ROOT = Path(__file__).parent
BIN = Path(sys.executable).parent
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/pyproject.toml"))


def run(session: nox.Session, tool: str, *arguments: str, **options: dict[str, str]) -> None:
    """Run a tool of this environment, which need not be on the path."""
    found = shutil.which(tool, path=BIN)
    if found is None:
        session.error(f"{tool} is not installed beside nox; run: bash tools/setup.sh dev")
    session.run(found, *arguments, **options)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, formatting, and the order in which modules may import each other."""
    run(session, "ruff", "check", ".")
    run(session, "ruff", "format", "--check", ".")
    run(session, "lint-imports", "--no-cache")


@nox.session
def types(session: nox.Session) -> None:
    """Types, strictly."""
    run(session, "mypy")


@nox.session
def tests(session: nox.Session) -> None:
    """The tests; arguments after ``--`` go to pytest."""
    run(session, "pytest", "-n", "auto", *(session.posargs or ["tests"]))


@nox.session
def doctests(session: nox.Session) -> None:
    """The examples in docstrings."""
    run(session, "pytest", "-n", "auto", "--doctest-modules", "geodesic_toolkit")


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation with its executed gallery; a warning is an error."""
    arguments = ["-W", "--keep-going", "-q", "-b", "html", "docs", "docs/_build/html"]
    run(session, "sphinx-build", *arguments)


@nox.session(venv_backend="uv|virtualenv")
def plugins(session: nox.Session) -> None:
    """Wheels of the core and of every plugin, in an environment with nothing else in it."""
    if not PLUGINS:
        session.skip("there are no plugins")
    wheels = Path(session.create_tmp()) / "wheels"
    shutil.rmtree(wheels, ignore_errors=True)
    for project in [ROOT, *PLUGINS]:
        build = ["-m", "build", "--wheel", "--outdir", str(wheels), str(project)]
        session.run(sys.executable, *build, silent=True, external=True)
    session.install(*map(str, sorted(wheels.glob("*.whl"))), "pytest")
    session.run("geodesic-toolkit", "plugins")
    for plugin in PLUGINS:
        project = tomllib.loads((plugin / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        for kind in ("operators", "solvers"):
            for name in project.get("entry-points", {}).get(f"geodesic_toolkit.{kind}", {}):
                session.run("geodesic-toolkit", "check", name)
        if (plugin / "tests").is_dir():
            with session.chdir(plugin):  # away from the checkout: the wheels are what is tested
                # Open3D installs dash, whose pytest plugin warns of its own making.
                session.run("pytest", "-p", "no:dash", "--rootdir", ".", "tests")
