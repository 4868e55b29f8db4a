"""The command ``check``: its report on a back end, and its exit status."""

import json

import pytest
from command_line import run
from wrong_operators import Mutant, Rude
from wrong_solvers import Modest, WrongSolver

import geodesic_toolkit as gt
from geodesic_toolkit.testing.linear_solver import SOLVER_LAWS


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["cotan", "operator:cotan", "geodesic-toolkit:cotan", "supernodal", "superlu", "solver:cg"],
)
def test_the_command_shows_every_law_and_leaves_with_0(name):
    result = run("check", name)
    assert result.exit_code == 0
    assert "recipe_is_frozen_data" in result.stdout
    assert "laws as expected" in result.stdout


def test_the_command_prints_one_json_object():
    content = json.loads(run("check", "superlu", "--json").stdout)
    assert content["ok"]
    assert content["kind"] == "solver"
    assert [row["law"] for row in content["laws"]] == [law.__name__ for law in SOLVER_LAWS]


@pytest.fixture
def registered(register):
    register(gt.operators, "twice", Mutant)
    register(gt.operators, "rude", Rude)
    register(gt.solvers, "twice", WrongSolver)
    register(gt.solvers, "modest", Modest)


def test_the_command_leaves_with_1_where_a_law_is_broken(registered):
    result = run("check", "rude")
    assert result.exit_code == 1
    assert "other_domains_are_refused_by_name is broken: 3 (at most 0)" in result.stdout


def test_the_command_shows_an_unexpected_success(registered):
    result = run("check", "modest")
    assert result.exit_code == 1
    assert "holds unexpectedly" in result.stdout


def test_the_command_asks_which_where_an_operator_and_a_solver_share_a_name(registered):
    result = run("check", "twice")
    assert result.exit_code == 2
    assert "operator:twice or solver:twice" in result.stderr


@pytest.mark.parametrize("name", ["nothing", "operator:nothing", "solver:nothing", "nobody:cotan"])
def test_the_command_says_what_there_is_when_the_name_is_unknown(name):
    result = run("check", name)
    assert result.exit_code == 2
    assert "nothing" in result.stderr or "nobody" in result.stderr
