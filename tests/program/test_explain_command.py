"""The command explain, and the page of errors and warnings that it prints."""

import json

import pytest
from command_line import fails, run, run_process

from geodesic_toolkit import errors

ROOTS = {"GeodesicError", "GeodesicWarning", "PluginError"}


@pytest.mark.parametrize("name", sorted(set(errors.__all__) - ROOTS))
def test_every_error_and_warning_has_a_cause_and_a_cure(name):
    out = run("explain", name).stdout
    assert "\n\nCause: " in out
    assert "\n\nCure: " in out
    assert "``" not in out
    assert ":func:" not in out


def test_the_list_names_every_error_and_warning():
    lines = run("explain").stdout.splitlines()
    assert [line.split()[0] for line in lines] == errors.__all__


def test_the_name_at_the_end_of_a_message_can_be_explained():
    failed = run("explain", "BaseException")
    fails(failed, 2, "BaseException", "[InvalidOptionError]")
    name = failed.stderr.rstrip().rpartition("[")[2].rstrip("]")
    assert run("explain", name).stdout.startswith("An option has a value")


def test_json_has_the_same_text():
    content = json.loads(run("explain", "ReadError", "--json").stdout)
    assert content["messages"] == {"ReadError": run("explain", "ReadError").stdout.rstrip("\n")}


def test_texts_that_python_has_dropped_are_not_replaced_by_others():
    done = run_process("explain", "InvalidSourceError", PYTHONOPTIMIZE="2")
    assert (done.returncode, done.stdout) == (2, "")
    assert "-OO" in done.stderr
