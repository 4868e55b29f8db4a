"""Copies that arrive in other places and processes."""

import copy
import pickle
from typing import TypeVar

__all__ = ["arrivals"]

Thing = TypeVar("Thing")


def arrivals(thing: Thing) -> dict[str, Thing]:
    """Return what arrives of a thing, by the way that it takes: "pickle" and "deepcopy"."""
    by_pickle: Thing = pickle.loads(pickle.dumps(thing))  # noqa: S301 - made here
    return {"pickle": by_pickle, "deepcopy": copy.deepcopy(thing)}
