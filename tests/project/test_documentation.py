"""The documentation says what is so: its examples run, and every public name is in it."""

import ast
import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import geodesic_toolkit as gt

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
SUBMODULES = ("errors", "sklearn", "testing", "testing.shapes", "viz")


def blocks(text, language):
    """Return the code blocks of a page in Markdown."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)


def run_python(code, folder):
    """Run `code` in a process of its own, inside `folder`."""
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, "MPLBACKEND": "agg", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )


# -- what is shown runs ----------------------------------------------------------------------------


@pytest.mark.slow
def test_the_example_of_the_readme_runs_and_draws(tmp_path):
    (example,) = blocks(README, "python")
    assert len([line for line in example.splitlines() if line]) <= 6
    finished = run_python(example, tmp_path)
    assert finished.returncode == 0, finished.stderr
    assert (tmp_path / "knot.png").stat().st_size > 10_000


@pytest.mark.slow
def test_getting_started_runs_from_top_to_bottom(tmp_path):
    pytest.importorskip("nibabel")
    prelude = """
        import geodesic_toolkit as gt
        mesh = gt.testing.shapes.knot()
        vertices, faces, points = mesh.vertices, mesh.faces, mesh.vertices
        n_vertices, edges, lengths = 3, [[0, 1], [1, 2]], [0.5, 2.0]
        import nibabel, numpy
        with open("lh.V1_exvivo.label", "w") as file:
            file.write("#!ascii label\\n2\\n5 0 0 0 0\\n6 0 0 0 0\\n")
        regions = numpy.arange(mesh.n_vertices) > 500
        colours = numpy.array([[1, 2, 3, 0], [4, 5, 6, 0]])
        nibabel.freesurfer.write_annot(
            "lh.aparc.annot", regions.astype(int), colours, ["cortex", "unknown"]
        )
    """
    page = (DOCS / "getting_started.md").read_text(encoding="utf-8")
    code = "\n".join([textwrap.dedent(prelude), *blocks(page, "python")])
    finished = run_python(code, tmp_path)
    assert finished.returncode == 0, finished.stderr
    assert (tmp_path / "distance.png").exists()


GUIDES = {
    "point_clouds.md": (),
    "graphs.md": (),
    "many_sources.md": (),
    "scikit_learn.md": (),
    "objects.md": ("nilearn", "open3d", "pyvista", "trimesh"),
}
"""Pages, and the packages that they need."""


@pytest.mark.slow
@pytest.mark.parametrize("name", GUIDES)
def test_a_guide_runs_from_top_to_bottom(name, tmp_path):
    for package in GUIDES[name]:
        pytest.importorskip(package)
    page = (DOCS / name).read_text(encoding="utf-8")
    finished = run_python("\n".join(blocks(page, "python")), tmp_path)
    assert finished.returncode == 0, finished.stderr


def test_the_page_on_plugins_shows_a_kind_of_domain_that_works(tmp_path):
    page = (DOCS / "plugins.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"^```{literalinclude} (.*)$", page, flags=re.MULTILINE)
    shutil.copytree((DOCS / shown).parent, tmp_path / "package_name")
    section = page.partition("## A kind of domain of its own")[2].partition("## A linear solver")[0]
    code = "\n".join(blocks(section, "python"))
    finished = run_python(code, tmp_path)
    assert finished.returncode == 0, finished.stderr
    shown = re.findall(r"^print\(.*\)  # (.*)$", code, flags=re.MULTILINE)
    assert finished.stdout.splitlines() == shown
    assert (tmp_path / "ring.csv").exists()


@pytest.mark.slow
@pytest.mark.parametrize("script", sorted(DOCS.glob("examples/plot_*.py")), ids=lambda p: p.stem)
def test_a_gallery_script_runs_in_another_folder(script, tmp_path):
    finished = run_python(script.read_text(encoding="utf-8"), tmp_path)
    assert finished.returncode == 0, finished.stderr


def shown_commands():
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8"), "(?:bash|console|sh)"):
            for line in block.splitlines():
                found = re.search(
                    r"(?:^|&& )(?:\.venv/bin/)?geodesic-toolkit +([a-z].*)", line.split("#")[0]
                )
                if found:
                    yield pytest.param(found[1].split(), id=f"{page.stem}: {found[1].strip()}")


@pytest.mark.parametrize("words", list(shown_commands()))
def test_a_command_shown_in_the_documentation_has_these_options(words):
    import typer

    from geodesic_toolkit.cli.extensions import commands
    from geodesic_toolkit.cli.program import app

    program = typer.main.get_command(app)
    if words[0] in commands.install_hints and words[0] not in commands:
        pytest.skip(f"the plugin that has {words[0]} is not installed")
    command = program.get_command(None, words[0])
    assert command is not None
    known = {
        option
        for parameter in command.params
        for option in (*parameter.opts, *parameter.secondary_opts)
    }
    assert {word.split("=")[0] for word in words if word.startswith("--")} <= known


def test_the_two_commands_of_the_readme_set_up_first_and_ci_runs_the_second():
    lines = [line for block in blocks(README, "bash") for line in block.splitlines()]
    main_job, tests = (line for line in lines if line.startswith("bash tools/setup.sh"))
    assert main_job == "bash tools/setup.sh && .venv/bin/geodesic-toolkit demo"
    assert (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()[-1] == tests
    for page in ("CONTRIBUTING.md", "docs/getting_started.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert main_job in text or tests in text


@pytest.mark.parametrize("script", ["tools/setup.sh", ".ci/run"])
def test_a_shell_script_is_sound_and_can_be_executed(script):
    path = ROOT / script
    assert os.access(path, os.X_OK)
    subprocess.run(["bash", "-n", str(path)], check=True)


def test_setup_refuses_what_it_does_not_know():
    finished = subprocess.run(
        ["bash", str(ROOT / "tools" / "setup.sh"), "everything"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 1
    assert "usage: bash tools/setup.sh [dev]" in finished.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_to_files_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_the_version_is_the_same_everywhere():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\nversion: {gt.__version__}\n" in citation
    assert f"## [{gt.__version__}]" in changelog


# -- every public name is documented ---------------------------------------------------------------


def public_objects():
    """Yield every public class and function with the name that people call it by."""
    for module_name in ("", *SUBMODULES):
        path = f"geodesic_toolkit.{module_name}".rstrip(".")
        module = importlib.import_module(path)
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isclass(value) or inspect.isfunction(value):
                yield f"{path}.{name}", value


def methods_of(kind):
    """Yield the public methods that a class brings, but not those whose contract it inherits."""
    for name, value in vars(kind).items():
        plain = value.__func__ if isinstance(value, classmethod | staticmethod) else value
        inherited = any(hasattr(base, name) for base in kind.__mro__[1:])
        if not name.startswith("_") and inspect.isfunction(plain) and not inherited:
            yield name, plain


OBJECTS = list(public_objects())
METHODS = [
    (f"{path}.{name}", method)
    for path, kind in OBJECTS
    if inspect.isclass(kind)
    for name, method in methods_of(kind)
]
ELSEWHERE = re.compile(r"Parameters(\s+and\s+errors)?\s+are\s+those\s+of")
SECTIONS = {
    "PR01",  # a parameter without a word
    "PR02",  # a word on a parameter that there is not
    "RT01",  # nothing about what is returned
    "GL07",  # sections out of order
    "GL08",  # no docstring
    "YD01",  # nothing about what is yielded
    "EX01",  # no example
}


def complaints(path):
    """Return the codes of what numpydoc misses in a docstring."""
    validate = pytest.importorskip("numpydoc.validate")
    return {code for code, _ in validate.validate(path)["errors"]} & SECTIONS


def raised_in(function):
    """Return the names of this project's errors in the ``raise`` statements of the function."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    calls = [
        node.exc.func
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call)
    ]
    return {call.id for call in calls if isinstance(call, ast.Name) and hasattr(gt.errors, call.id)}


def written_constructors(kind):
    """Return the constructors in the source, not those that dataclasses generate."""
    found = [vars(kind)[name] for name in ("__init__", "__post_init__") if name in vars(kind)]
    return [function for function in found if function.__code__.co_filename != "<string>"]


@pytest.mark.parametrize("module_name", ["", *SUBMODULES])
def test_every_public_name_is_on_the_api_page(module_name):
    pages = (DOCS / "api" / "index.rst", DOCS / "messages.md")  # errors have a page of their own
    page = "".join(path.read_text(encoding="utf-8") for path in pages)
    module = importlib.import_module(f"geodesic_toolkit.{module_name}".rstrip("."))
    if f".. automodule:: {module.__name__}" in page:
        return
    missing = [name for name in module.__all__ if not re.search(rf"(?<!\w){name}(?!\w)", page)]
    assert not missing


@pytest.mark.slow
@pytest.mark.parametrize(("path", "value"), OBJECTS, ids=[path for path, _ in OBJECTS])
def test_a_public_class_or_function_is_documented(path, value):
    missing = complaints(path)
    if ELSEWHERE.search(value.__doc__):
        missing -= {"PR01"}
    if inspect.isclass(value):
        missing -= {"RT01", "YD01"}  # said by its methods
        if issubclass(value, Exception) or inspect.isabstract(value):
            missing -= {"EX01"}  # an error is shown where it is raised; of a contract there is none
        if "Attributes\n" in value.__doc__ and "Parameters\n" not in value.__doc__:
            missing -= {
                "PR01",
                "EX01",
            }  # the record that something returns, which users do not construct
    assert not missing
    for function in written_constructors(value) if inspect.isclass(value) else [value]:
        assert not [error for error in raised_in(function) if error not in value.__doc__]


@pytest.mark.parametrize(("path", "method"), METHODS, ids=[path for path, _ in METHODS])
def test_a_public_method_is_documented(path, method):
    missing = complaints(path) - {"EX01"}
    takes_nothing = len(inspect.signature(method).parameters) <= 1
    if takes_nothing or ELSEWHERE.search(method.__doc__):
        missing -= {"PR01", "RT01"}
    assert not missing
    if not ELSEWHERE.search(method.__doc__):
        assert not [error for error in raised_in(method) if error not in method.__doc__]
