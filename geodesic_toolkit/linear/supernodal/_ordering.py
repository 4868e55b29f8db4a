"""Approximate minimum degree: an order of elimination that keeps the factor sparse.

P. R. Amestoy, T. A. Davis, I. S. Duff, *An Approximate Minimum Degree Ordering Algorithm*, SIAM J.
Matrix Anal. Appl. 17, 1996, https://doi.org/10.1137/S0895479894278952

Eliminating a vertex joins its neighbours into a clique. The quotient graph stores a clique as one
*element*, the list of its members, instead of all its edges; a vertex then has a list of elements
and a list of *variables* (neighbours that no element covers yet). Variables that became
indistinguishable are merged and eliminated together.

An element is what the column of the factor has below its diagonal, and it lasts until another one
absorbs it. So the order comes with the tree in which columns hand down what is left of them, and
with the number of their rows, and neither has to be found anew from the pattern.
"""

import math
from typing import NamedTuple

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = ["Elimination", "minimum_degree"]

HELPERS = "5b7e21d9922a23a1"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

NONE = -1

AHEAD = 16
"""Groups by which memory is asked for ahead."""

HIGHEST = np.iinfo(np.int32).max
"""Where a list may begin, at the most, and a mark end, for fields of 32 bits to hold them."""

# The fields of a vertex, which is a variable, an element later on, or gone. One row of memory holds
# them: visits come in no order, and memory is what they wait for. What is visited soon is fetched
# ahead.
START = 0  # of its list
LENGTH = (
    1  # of its list: a variable's elements come first, then its variables; an element's members
)
ELEMENTS = 2  # how many of them are elements
SIZE = 3  # vertices that a variable stands for: 0 once absorbed, < 0 in the current element
DEGREE = 4  # approximate degree of a variable; an element's number of vertices
MARK = 5  # of an element: epoch + |Lₑ \ Lₚ|, or 0 once absorbed
AFTER, BEFORE = 6, 7  # its neighbours in the list of variables of one degree
FIELDS = 8
ABSORBER, NUMBER = AFTER, ELEMENTS  # of an element: what has absorbed it; its place in the order

_starts = types.Array(types.int64, 1, "C", readonly=True)
_indices = types.Array(types.int32, 1, "C", readonly=True)


class Elimination(NamedTuple):
    """An order of elimination, in groups of vertices that are eliminated together.

    Attributes
    ----------
    order : ndarray of shape (N,), int32
        The vertices.
    starts : ndarray of shape (G + 1,), int32
        Group g is ``order[starts[g]:starts[g + 1]]``.
    heights : ndarray of shape (G,), int32
        Rows of the factor in the first column of each group, its diagonal included, without those
        of vertices that are set aside as full: the last group.
    parents : ndarray of shape (G,), int32
        The group that takes over what the elimination of a group leaves, -1 where nothing is left.
        Its rows are among those of that group.
    n_full : int
        Vertices that were set aside.
    """

    order: IndexArray
    starts: IndexArray
    heights: IndexArray
    parents: IndexArray
    n_full: int


def minimum_degree(indptr: IntArray, indices: IndexArray) -> Elimination:
    """Return an order of elimination of a symmetric pattern that brings little fill.

    Parameters
    ----------
    indptr : ndarray of shape (N + 1,), int64
    indices : ndarray of shape (nnz,), int32
        Both halves of the pattern; the diagonal may be there.
    """
    n, nnz = len(indptr) - 1, len(indices)
    # NumPy asks the system for large pages, which visits in no order need most; Numba does not.
    lists = np.empty(2 * nnz + 2 * n + 64, dtype=np.int32)
    narrow = len(lists) < HIGHEST
    kernel, kind = (_eliminated, np.int32) if narrow else (_eliminated_by_long, np.int64)
    fields = np.empty(FIELDS * n + 64, dtype=kind)
    aligned = -(fields.ctypes.data // fields.itemsize) % (64 // fields.itemsize)
    node = fields[aligned : aligned + FIELDS * n].reshape(n, FIELDS)  # no row on two cache lines
    links = np.full(6 * n + 1, NONE, dtype=np.int32)
    *found, _ = kernel(indptr, indices, lists, node, links, np.iinfo(kind).max)
    return Elimination(*found)


def _eliminate(  # noqa: PLR0912, PLR0915, PLR0917 - its steps share a dozen arrays
    indptr: IntArray,
    indices: IndexArray,
    storage: IndexArray,
    fields: NDArray[np.signedinteger],
    links: IndexArray,
    highest: int,
) -> tuple[IndexArray, IndexArray, IndexArray, IndexArray, int, IndexArray]:
    """Return the fields of an `Elimination`, and the room for lists, which so lives until the end.

    Parameters
    ----------
    indptr, indices : ndarray
        The pattern.
    storage : ndarray
        Room for lists of vertices.
    fields : ndarray of shape (N, FIELDS)
        Room for the fields of each vertex.
    links : ndarray of shape (6 N + 1,), int32
        Lists of vertices that are linked from one to the next, all empty: NONE everywhere.
    highest : int
        The largest number that a field holds.
    """
    n = indptr.size - 1
    nnz = indptr[n]
    # Through pointers: an index of an array may be negative, and looking at it each time takes a
    # third of all.
    node, lists, neighbours = pointer(fields), pointer(storage), pointer(indices)
    head, bucket = pointer(links), pointer(links[n + 1 :])  # the first vertex of a degree, a hash
    bucket_next, hashes = pointer(links[2 * n + 1 :]), pointer(links[3 * n + 1 :])
    last_member, next_member = pointer(links[4 * n + 1 :]), pointer(links[5 * n + 1 :])
    vertices, ordered = np.empty(n, np.int32), 0
    order = pointer(vertices)
    starts, n_groups = np.zeros(n + 1, np.int32), 0

    end = np.int64(0)
    for i in range(n):
        last_member[i] = i
        node[FIELDS * i + START] = end
        for p in range(indptr[i], indptr[i + 1]):
            if neighbours[p] != i:
                lists[end] = neighbours[p]
                end += 1
        node[FIELDS * i + LENGTH] = node[FIELDS * i + DEGREE] = end - node[FIELDS * i + START]
        node[FIELDS * i + SIZE], node[FIELDS * i + ELEMENTS], node[FIELDS * i + MARK] = 1, 0, 1
        node[FIELDS * i + AFTER], node[FIELDS * i + BEFORE] = NONE, NONE
    # Rows that are nearly full belong at the end whatever the rest does, and are dear to update.
    full = max(16, int(10 * math.sqrt(n)))
    eliminated = 0
    n_full = 0
    for i in range(n - 1, -1, -1):
        if node[FIELDS * i + DEGREE] > full:
            n_full += 1
            eliminated += 1
            node[FIELDS * i + SIZE] = 0
            order[n - n_full] = i
        else:
            follower = head[node[FIELDS * i + DEGREE]]
            node[FIELDS * i + AFTER] = follower
            if follower != NONE:
                node[FIELDS * follower + BEFORE] = i
            head[node[FIELDS * i + DEGREE]] = i

    mask = 1
    while 2 * mask <= n:
        mask *= 2
    mask -= 1
    epoch, least, largest = np.int64(2), 0, 0
    while eliminated < n:
        if epoch > highest - 4 * n:  # no mark of this pivot may be larger
            epoch = np.int64(2)
            for i in range(n):
                node[FIELDS * i + MARK] = node[FIELDS * i + MARK] != 0

        # -- the pivot: a variable of the least degree ---------------------------------------------
        while head[least] == NONE:
            least += 1
        pivot = head[least]
        head[least] = node[FIELDS * pivot + AFTER]
        if node[FIELDS * pivot + AFTER] != NONE:
            node[FIELDS * node[FIELDS * pivot + AFTER] + BEFORE] = NONE
        upcoming = np.int64(node[FIELDS * pivot + AFTER])  # the next pivot, most of the time
        if upcoming != NONE:
            prefetch(shifted(node, FIELDS * upcoming))
        pivot_size = node[FIELDS * pivot + SIZE]
        eliminated += pivot_size
        node[FIELDS * pivot + SIZE] = -pivot_size

        # -- its element Lₚ: its variables, and those of its elements, which it absorbs ------------
        needed = np.int64(node[FIELDS * pivot + LENGTH] - node[FIELDS * pivot + ELEMENTS])
        for p in range(
            node[FIELDS * pivot + START],
            node[FIELDS * pivot + START] + node[FIELDS * pivot + ELEMENTS],
        ):
            needed += node[FIELDS * lists[p] + LENGTH]
        if end + needed > storage.size:
            live = np.int64(0)
            for i in range(n):
                live += node[FIELDS * i + LENGTH]
            moved = np.empty(live + needed + nnz, np.int32)
            end = np.int64(0)
            for i in range(n):
                old = node[FIELDS * i + START]
                node[FIELDS * i + START] = end
                for p in range(old, old + node[FIELDS * i + LENGTH]):
                    moved[end] = lists[p]
                    end += 1
            storage, lists = moved, pointer(moved)
        first, members = end, 0
        for q in range(node[FIELDS * pivot + ELEMENTS] + 1):
            own = q == node[FIELDS * pivot + ELEMENTS]
            e = pivot if own else lists[node[FIELDS * pivot + START] + q]
            begin = node[FIELDS * e + START] + (node[FIELDS * pivot + ELEMENTS] if own else 0)
            for p in range(begin, node[FIELDS * e + START] + node[FIELDS * e + LENGTH]):
                i = lists[p]
                own_size = node[FIELDS * i + SIZE]
                if own_size > 0:
                    members += own_size
                    node[FIELDS * i + SIZE] = -own_size
                    lists[end] = i
                    end += 1
                    prefetch(shifted(lists, np.int64(node[FIELDS * i + START])))
                    if node[FIELDS * i + BEFORE] != NONE:
                        node[FIELDS * node[FIELDS * i + BEFORE] + AFTER] = node[FIELDS * i + AFTER]
                    else:
                        head[node[FIELDS * i + DEGREE]] = node[FIELDS * i + AFTER]
                    if node[FIELDS * i + AFTER] != NONE:
                        node[FIELDS * node[FIELDS * i + AFTER] + BEFORE] = node[FIELDS * i + BEFORE]
            if not own:
                node[FIELDS * e + MARK], node[FIELDS * e + LENGTH], node[FIELDS * e + ABSORBER] = (
                    0,
                    0,
                    pivot,
                )
        node[FIELDS * pivot + ELEMENTS] = 0
        node[FIELDS * pivot + START], node[FIELDS * pivot + LENGTH] = first, end - first

        # -- |Lₑ \ Lₚ| for every element e that touches Lₚ -----------------------------------------
        epoch += 1
        if upcoming != NONE:
            prefetch(shifted(lists, np.int64(node[FIELDS * upcoming + START])))
        for k in range(first, end):
            i = lists[k]
            own_size = -node[FIELDS * i + SIZE]
            for p in range(
                node[FIELDS * i + START], node[FIELDS * i + START] + node[FIELDS * i + ELEMENTS]
            ):
                e = lists[p]
                left = node[FIELDS * e + MARK]
                if left >= epoch:
                    node[FIELDS * e + MARK] = left - own_size
                elif left != 0:
                    node[FIELDS * e + MARK] = node[FIELDS * e + DEGREE] + epoch - own_size

        # -- new lists and approximate degrees of the members --------------------------------------
        for k in range(first, end):
            i = lists[k]
            begin, stop = (
                node[FIELDS * i + START],
                node[FIELDS * i + START] + node[FIELDS * i + LENGTH],
            )
            variables = begin + node[FIELDS * i + ELEMENTS]
            outside, fold, keep = 0, np.int64(0), begin
            for p in range(begin, variables):
                e = lists[p]
                left = node[FIELDS * e + MARK]
                if left > epoch:
                    outside += left - epoch
                    fold += e
                    lists[keep] = e
                    keep += 1
                elif left != 0:  # all of e lies in the new element: absorb it
                    (
                        node[FIELDS * e + MARK],
                        node[FIELDS * e + LENGTH],
                        node[FIELDS * e + ABSORBER],
                    ) = 0, 0, pivot
            kept = keep - begin
            for p in range(variables, stop):
                j = lists[p]
                own_size = node[FIELDS * j + SIZE]
                if own_size > 0:
                    outside += own_size
                    fold += j
                    lists[keep] = j
                    keep += 1
            if keep == begin:  # nothing but the new element: eliminated along with the pivot
                pivot_size -= node[FIELDS * i + SIZE]
                eliminated -= node[FIELDS * i + SIZE]
                members += node[FIELDS * i + SIZE]
                node[FIELDS * i + SIZE], node[FIELDS * i + LENGTH] = 0, 0
                next_member[last_member[pivot]] = i
                last_member[pivot] = last_member[i]
                continue
            node[FIELDS * i + DEGREE] = min(node[FIELDS * i + DEGREE], outside)
            # The new element goes first. Its place was that of an element or a variable which is
            # there no longer, as it brought i into Lₚ.
            if keep > begin + kept:
                lists[keep] = lists[begin + kept]
            if kept > 0:
                lists[begin + kept] = lists[begin]
            lists[begin] = pivot
            node[FIELDS * i + ELEMENTS], node[FIELDS * i + LENGTH] = kept + 1, keep - begin + 1
            hashes[i] = (fold + pivot) & mask
            bucket_next[i] = bucket[hashes[i]]
            bucket[hashes[i]] = i
        node[FIELDS * pivot + DEGREE] = members
        largest = max(largest, members)

        if upcoming != NONE:
            for p in range(
                node[FIELDS * upcoming + START],
                node[FIELDS * upcoming + START] + node[FIELDS * upcoming + LENGTH],
            ):
                prefetch(shifted(node, FIELDS * np.int64(lists[p])))

        # -- members with equal lists become one variable ------------------------------------------
        epoch += largest + 1  # past every mark that this pivot has left
        for k in range(first, end):
            if node[FIELDS * lists[k] + SIZE] == 0:
                continue
            key = hashes[lists[k]]
            i = bucket[key]
            bucket[key] = NONE
            while i != NONE and bucket_next[i] != NONE:
                epoch += 1
                for p in range(
                    node[FIELDS * i + START] + 1,
                    node[FIELDS * i + START] + node[FIELDS * i + LENGTH],
                ):
                    node[FIELDS * lists[p] + MARK] = epoch
                previous, j = i, bucket_next[i]
                while j != NONE:
                    same = (
                        node[FIELDS * j + LENGTH] == node[FIELDS * i + LENGTH]
                        and node[FIELDS * j + ELEMENTS] == node[FIELDS * i + ELEMENTS]
                    )
                    if same:
                        for p in range(
                            node[FIELDS * j + START] + 1,
                            node[FIELDS * j + START] + node[FIELDS * j + LENGTH],
                        ):
                            if node[FIELDS * lists[p] + MARK] != epoch:
                                same = False
                                break
                    following = bucket_next[j]
                    if same:
                        node[FIELDS * i + SIZE] += node[FIELDS * j + SIZE]
                        node[FIELDS * j + SIZE], node[FIELDS * j + LENGTH] = 0, 0
                        next_member[last_member[i]] = j
                        last_member[i] = last_member[j]
                        bucket_next[previous] = following
                    else:
                        previous = j
                    j = following
                i = bucket_next[i]
        epoch += 1

        # -- back into the lists of degrees; out with the pivot ------------------------------------
        end = first
        for k in range(first, first + node[FIELDS * pivot + LENGTH]):
            i = lists[k]
            if node[FIELDS * i + SIZE] == 0:
                continue
            node[FIELDS * i + SIZE] = -node[FIELDS * i + SIZE]
            node[FIELDS * i + DEGREE] = max(
                0,
                min(node[FIELDS * i + DEGREE] + members, n - eliminated) - node[FIELDS * i + SIZE],
            )
            follower = head[node[FIELDS * i + DEGREE]]
            node[FIELDS * i + AFTER], node[FIELDS * i + BEFORE] = follower, NONE
            if follower != NONE:
                node[FIELDS * follower + BEFORE] = i
            head[node[FIELDS * i + DEGREE]] = i
            least = min(least, node[FIELDS * i + DEGREE])
            lists[end] = i
            end += 1
        node[FIELDS * pivot + LENGTH] = end - first
        node[FIELDS * pivot + SIZE] = pivot_size
        if node[FIELDS * pivot + LENGTH] == 0:
            node[FIELDS * pivot + MARK] = 0
        node[FIELDS * pivot + ABSORBER], node[FIELDS * pivot + NUMBER] = NONE, n_groups
        v = pivot
        while v != NONE:
            order[ordered] = v
            ordered += 1
            v = next_member[v]
        n_groups += 1
        starts[n_groups] = ordered

    heights, parents = np.empty(n_groups + 1, np.int32), np.empty(n_groups + 1, np.int32)
    after = n_groups if n_full else NONE  # what is full takes over from all that is left
    for g in range(n_groups):
        if g + AHEAD < n_groups:
            prefetch(shifted(node, FIELDS * np.int64(order[starts[g + AHEAD]])))
        e = order[starts[g]]
        heights[g] = node[FIELDS * e + SIZE] + node[FIELDS * e + DEGREE]
        absorber = node[FIELDS * e + ABSORBER]
        parents[g] = after if absorber == NONE else node[FIELDS * absorber + NUMBER]
    if n_full:
        heights[n_groups], parents[n_groups] = n_full, NONE
        n_groups += 1
        starts[n_groups] = n
    starts, heights, parents = starts[: n_groups + 1], heights[:n_groups], parents[:n_groups]
    return vertices, starts, heights, parents, n_full, storage


_options = {"cache": True, "nogil": True, "error_model": "numpy"}
_eliminated = numba.njit(
    types.Tuple((*(types.int32[::1],) * 4, types.int64, types.int32[::1]))(
        _starts, _indices, types.int32[::1], types.int32[:, ::1], types.int32[::1], types.int64
    ),
    **_options,
)(_eliminate)
_eliminated_by_long = numba.njit(**_options)(_eliminate)  # compiled when it is called, if ever
