"""Copies of objects by pickle and by deepcopy."""

import copy
import pickle
from typing import TypeVar

__all__ = ["arrivals"]

Copied = TypeVar("Copied")


def arrivals(original: Copied) -> dict[str, Copied]:
    """Return copies of an object, by the method of copying: "pickle" and "deepcopy"."""
    by_pickle: Copied = pickle.loads(pickle.dumps(original))  # noqa: S301 - made here
    return {"pickle": by_pickle, "deepcopy": copy.deepcopy(original)}
