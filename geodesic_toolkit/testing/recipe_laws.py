"""Laws of every recipe, of operators and of solvers."""

import copy
import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.travel import arrivals

__all__ = ["RECIPE_LAWS", "Recipe", "faults"]


class Recipe(Protocol):
    """A subject of checks, which holds the recipe under test."""

    @property
    def recipe(self) -> Any:
        """The operator or solver."""


def faults(found: Sequence[str]) -> Measured:
    """Return the number of faults as a measurement with bound 0, and their text."""
    return Measured(float(len(found)), 0.0, "; ".join(found))


def recipe_is_frozen_data(subject: Recipe) -> Iterable[Measured]:
    """The recipe is a frozen dataclass of options with defaults, and has its DOIs in references."""
    kind, found = type(subject.recipe), []
    how: Any = getattr(kind, "__dataclass_params__", None)
    if how is None:
        found.append(f"{kind.__name__} is not a dataclass")
    elif not how.frozen:
        found.append(f"{kind.__name__} is not frozen")
    try:
        kind()
    except TypeError as error:
        found.append(f"{kind.__name__}() does not work: {error}")
    references = kind.references
    if not (
        isinstance(references, tuple) and all(str(doi).startswith("10.") for doi in references)
    ):
        found.append(
            f'references must be a tuple of DOIs such as "10.1145/...", not {references!r}'
        )
    yield faults(found)


def equal_recipes_are_equal(subject: Recipe) -> Iterable[Measured]:
    """Two recipes with the same options are equal and have the same hash."""
    recipe, found = subject.recipe, []
    if dataclasses.is_dataclass(recipe) and not isinstance(recipe, type):
        twin = dataclasses.replace(recipe)
    else:
        twin = copy.copy(recipe)
    if twin != recipe:
        found.append(f"{twin!r} differs from {recipe!r}")
    elif hash(twin) != hash(recipe):
        found.append("equal recipes have different hashes")
    yield faults(found)


def recipe_survives_pickling(subject: Recipe) -> Iterable[Measured]:
    """Pickle and deepcopy keep the class and the options of the recipe."""
    recipe, found = subject.recipe, []
    for way, arrived in arrivals(recipe).items():
        if type(arrived) is not type(recipe) or _options(arrived) != _options(recipe):
            found.append(f"{way} turns {recipe!r} into {arrived!r}")
    yield faults(found)


def repr_says_what_it_is(subject: Recipe) -> Iterable[Measured]:
    """The repr has the name of the class and every option that differs from its default."""
    recipe, text = subject.recipe, repr(subject.recipe)
    wanted = [type(recipe).__name__]
    if dataclasses.is_dataclass(recipe):
        wanted += [
            f"{option.name}={getattr(recipe, option.name)!r}"
            for option in dataclasses.fields(recipe)
            if option.repr and getattr(recipe, option.name) != option.default
        ]
    yield faults([f"{part!r} is not in {text!r}" for part in wanted if part not in text])


def _options(recipe: Any) -> dict[str, Any]:
    if not dataclasses.is_dataclass(recipe):
        return dict(getattr(recipe, "__dict__", {}))
    return {option.name: getattr(recipe, option.name) for option in dataclasses.fields(recipe)}


RECIPE_LAWS = (
    recipe_is_frozen_data,
    equal_recipes_are_equal,
    recipe_survives_pickling,
    repr_says_what_it_is,
)
