"""Check of the node numbers in Gmsh's .msh files, before meshio reads them.

Nodes may be numbered with gaps, and meshio makes a table as long as the largest number: one flipped
bit would fill the memory of the machine. It also does not compare the announced number of nodes
with the actual one.
"""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import ReadError

__all__ = ["check_node_numbers"]

MAX_NUMBERS_PER_NODE = 1000
"""Largest plausible node number per node, beyond a million; larger numbers mean damage."""

FORMAT = re.compile(rb"\$MeshFormat\s+(\d)(?:\.(\d))?\s+([01])\s+(\d+)")
NODES = re.compile(rb"^\$Nodes\s*?\n", re.MULTILINE)
NUMBERED = np.dtype([("number", "<i4"), ("position", "<f8", 3)])


def check_node_numbers(data: bytes) -> None:
    """Raise a `ReadError` if the number of nodes, or a node number, is not plausible."""
    try:
        numbers = [block for block in _node_numbers(data) if len(block)]
    except ReadError:
        raise
    except (ValueError, IndexError, OverflowError) as error:
        raise ReadError(f"the nodes are cut off or damaged ({error})") from error
    count = sum(map(len, numbers))
    largest = max((int(block.max()) for block in numbers), default=0)
    if largest > MAX_NUMBERS_PER_NODE * count + 1_000_000:
        raise ReadError(f"node {largest} among {count} nodes: their numbers are damaged")


def _node_numbers(data: bytes) -> Iterator[IntArray]:
    """Yield the numbers of the nodes, block by block; for versions 2 and 4, text and binary."""
    form, nodes = FORMAT.search(data), NODES.search(data)
    if form is None or nodes is None:
        return
    major, minor = int(form[1]), int(form[2] or 1)  # "4" is 4.1
    body = data[nodes.end() :]
    size = np.dtype(f"<u{int(form[4])}")
    if form[3] == b"0":
        yield from _of_text(body.partition(b"$EndNodes")[0].split(), major, minor)
    elif major == 2:
        count, _, rows = body.partition(b"\n")
        yield _taken(rows, 0, NUMBERED, int(count))["number"].astype(np.int64)
    else:
        yield from _of_binary(body, minor, size)


def _of_text(words: list[bytes], major: int, minor: int) -> Iterator[IntArray]:
    if major == 2:
        yield _integers(words[1 : 1 + 4 * int(words[0]) : 4])
        return
    at, total = 4 if minor else 2, 0
    for _ in range(int(words[0])):
        count = int(words[at + 3])
        at, total = at + 4, total + count
        yield _integers(words[at : at + count] if minor else words[at : at + 4 * count : 4])
        at += 4 * count
    _check_total(int(words[1]), total)


def _of_binary(body: bytes, minor: int, size: np.dtype[Any]) -> Iterator[IntArray]:
    at, total = (4 if minor else 2) * size.itemsize, 0
    blocks, announced = _taken(body, 0, size, 2).tolist()
    for _ in range(blocks):
        count = int(_taken(body, at + 12, size, 1)[0])
        at, total = at + 12 + size.itemsize, total + count
        if minor:
            yield _taken(body, at, size, count).astype(np.int64)
            at += count * (size.itemsize + 3 * 8)
        else:
            yield _taken(body, at, NUMBERED, count)["number"].astype(np.int64)
            at += count * NUMBERED.itemsize
    _check_total(announced, total)


def _check_total(announced: int, total: int) -> None:
    """Raise if announced nodes are missing: meshio would invent some."""
    if announced != total:
        raise ReadError(f"{announced} nodes are announced, but {total} follow")


def _taken(data: bytes, at: int, kind: np.dtype[Any], count: int) -> NDArray[Any]:
    """Return `count` items of `kind`; a ValueError if the data end before."""
    return np.frombuffer(data, kind, count, at)


def _integers(words: list[bytes]) -> IntArray:
    return np.array([int(word) for word in words], dtype=np.int64)
