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
    fields = np.empty(8 * n + 64, dtype=kind)
    aligned = -(fields.ctypes.data // fields.itemsize) % (64 // fields.itemsize)
    node = fields[aligned : aligned + 8 * n].reshape(n, 8)  # no row on two cache lines
    return Elimination(*kernel(indptr, indices, lists, node, np.iinfo(kind).max))


def _eliminate(  # noqa: PLR0912, PLR0915 - its steps share a dozen arrays
    indptr: IntArray,
    indices: IndexArray,
    lists: IndexArray,
    node: NDArray[np.signedinteger],
    highest: int,
) -> tuple[IndexArray, IndexArray, IndexArray, IndexArray, int]:
    """Return the fields of an `Elimination`.

    Parameters
    ----------
    indptr, indices : ndarray
        The pattern.
    lists : ndarray
        Room for lists of vertices.
    node : ndarray of shape (N, 8)
        Room for the fields of each vertex.
    highest : int
        The largest number that a field holds.
    """
    n = indptr.size - 1
    nnz = indptr[n]
    head = np.full(n + 1, NONE, np.int32)
    bucket, bucket_next, hashes = (
        np.full(n, NONE, np.int32),
        np.full(n, NONE, np.int32),
        np.zeros(n, np.int32),
    )
    last_member, next_member = np.empty(n, np.int32), np.full(n, NONE, np.int32)
    order, ordered = np.empty(n, np.int32), 0
    starts, n_groups = np.zeros(n + 1, np.int32), 0

    end = np.int64(0)
    for i in range(n):
        last_member[i] = i
        node[i, START] = end
        for p in range(indptr[i], indptr[i + 1]):
            if indices[p] != i:
                lists[end] = indices[p]
                end += 1
        node[i, LENGTH] = node[i, DEGREE] = end - node[i, START]
        node[i, SIZE], node[i, ELEMENTS], node[i, MARK] = 1, 0, 1
        node[i, AFTER], node[i, BEFORE] = NONE, NONE
    # Rows that are nearly full belong at the end whatever the rest does, and are dear to update.
    full = max(16, int(10 * math.sqrt(n)))
    eliminated = 0
    n_full = 0
    for i in range(n - 1, -1, -1):
        if node[i, DEGREE] > full:
            n_full += 1
            eliminated += 1
            node[i, SIZE] = 0
            order[n - n_full] = i
        else:
            follower = head[node[i, DEGREE]]
            node[i, AFTER] = follower
            if follower != NONE:
                node[follower, BEFORE] = i
            head[node[i, DEGREE]] = i

    epoch, least, largest = np.int64(2), 0, 0
    while eliminated < n:
        if epoch > highest - 4 * n:  # no mark of this pivot may be larger
            epoch = np.int64(2)
            for i in range(n):
                node[i, MARK] = node[i, MARK] != 0

        # -- the pivot: a variable of the least degree ---------------------------------------------
        while head[least] == NONE:
            least += 1
        pivot = head[least]
        head[least] = node[pivot, AFTER]
        if node[pivot, AFTER] != NONE:
            node[node[pivot, AFTER], BEFORE] = NONE
        upcoming = np.int64(node[pivot, AFTER])  # the next pivot, most of the time
        if upcoming != NONE:
            prefetch(shifted(pointer(node), 8 * upcoming))
        pivot_size = node[pivot, SIZE]
        eliminated += pivot_size
        node[pivot, SIZE] = -pivot_size

        # -- its element Lₚ: its variables, and those of its elements, which it absorbs ------------
        needed = np.int64(node[pivot, LENGTH] - node[pivot, ELEMENTS])
        for p in range(node[pivot, START], node[pivot, START] + node[pivot, ELEMENTS]):
            needed += node[lists[p], LENGTH]
        if end + needed > lists.size:
            live = np.int64(0)
            for i in range(n):
                live += node[i, LENGTH]
            moved = np.empty(live + needed + nnz, np.int32)
            end = np.int64(0)
            for i in range(n):
                old = node[i, START]
                node[i, START] = end
                for p in range(old, old + node[i, LENGTH]):
                    moved[end] = lists[p]
                    end += 1
            lists = moved
        first, members = end, 0
        for q in range(node[pivot, ELEMENTS] + 1):
            own = q == node[pivot, ELEMENTS]
            e = pivot if own else lists[node[pivot, START] + q]
            begin = node[e, START] + (node[pivot, ELEMENTS] if own else 0)
            for p in range(begin, node[e, START] + node[e, LENGTH]):
                i = lists[p]
                own_size = node[i, SIZE]
                if own_size > 0:
                    members += own_size
                    node[i, SIZE] = -own_size
                    lists[end] = i
                    end += 1
                    prefetch(shifted(pointer(lists), np.int64(node[i, START])))
                    if node[i, BEFORE] != NONE:
                        node[node[i, BEFORE], AFTER] = node[i, AFTER]
                    else:
                        head[node[i, DEGREE]] = node[i, AFTER]
                    if node[i, AFTER] != NONE:
                        node[node[i, AFTER], BEFORE] = node[i, BEFORE]
            if not own:
                node[e, MARK], node[e, LENGTH], node[e, ABSORBER] = 0, 0, pivot
        node[pivot, ELEMENTS] = 0
        node[pivot, START], node[pivot, LENGTH] = first, end - first

        # -- |Lₑ \ Lₚ| for every element e that touches Lₚ -----------------------------------------
        epoch += 1
        if upcoming != NONE:
            prefetch(shifted(pointer(lists), np.int64(node[upcoming, START])))
        for k in range(first, end):
            i = lists[k]
            own_size = -node[i, SIZE]
            for p in range(node[i, START], node[i, START] + node[i, ELEMENTS]):
                e = lists[p]
                left = node[e, MARK]
                if left >= epoch:
                    node[e, MARK] = left - own_size
                elif left != 0:
                    node[e, MARK] = node[e, DEGREE] + epoch - own_size

        # -- new lists and approximate degrees of the members --------------------------------------
        for k in range(first, end):
            i = lists[k]
            begin, stop = node[i, START], node[i, START] + node[i, LENGTH]
            variables = begin + node[i, ELEMENTS]
            outside, fold, keep = 0, np.int64(0), begin
            for p in range(begin, variables):
                e = lists[p]
                left = node[e, MARK]
                if left > epoch:
                    outside += left - epoch
                    fold += e
                    lists[keep] = e
                    keep += 1
                elif left != 0:  # all of e lies in the new element: absorb it
                    node[e, MARK], node[e, LENGTH], node[e, ABSORBER] = 0, 0, pivot
            kept = keep - begin
            for p in range(variables, stop):
                j = lists[p]
                own_size = node[j, SIZE]
                if own_size > 0:
                    outside += own_size
                    fold += j
                    lists[keep] = j
                    keep += 1
            if keep == begin:  # nothing but the new element: eliminated along with the pivot
                pivot_size -= node[i, SIZE]
                eliminated -= node[i, SIZE]
                members += node[i, SIZE]
                node[i, SIZE], node[i, LENGTH] = 0, 0
                next_member[last_member[pivot]] = i
                last_member[pivot] = last_member[i]
                continue
            node[i, DEGREE] = min(node[i, DEGREE], outside)
            # The new element goes first. Its place was that of an element or a variable which is
            # there no longer, as it brought i into Lₚ.
            if keep > begin + kept:
                lists[keep] = lists[begin + kept]
            if kept > 0:
                lists[begin + kept] = lists[begin]
            lists[begin] = pivot
            node[i, ELEMENTS], node[i, LENGTH] = kept + 1, keep - begin + 1
            hashes[i] = (fold + pivot) % n
            bucket_next[i] = bucket[hashes[i]]
            bucket[hashes[i]] = i
        node[pivot, DEGREE] = members
        largest = max(largest, members)

        if upcoming != NONE:
            for p in range(node[upcoming, START], node[upcoming, START] + node[upcoming, LENGTH]):
                prefetch(shifted(pointer(node), 8 * np.int64(lists[p])))

        # -- members with equal lists become one variable ------------------------------------------
        epoch += largest + 1  # past every mark that this pivot has left
        for k in range(first, end):
            if node[lists[k], SIZE] == 0:
                continue
            key = hashes[lists[k]]
            i = bucket[key]
            bucket[key] = NONE
            while i != NONE and bucket_next[i] != NONE:
                epoch += 1
                for p in range(node[i, START] + 1, node[i, START] + node[i, LENGTH]):
                    node[lists[p], MARK] = epoch
                previous, j = i, bucket_next[i]
                while j != NONE:
                    same = (
                        node[j, LENGTH] == node[i, LENGTH]
                        and node[j, ELEMENTS] == node[i, ELEMENTS]
                    )
                    if same:
                        for p in range(node[j, START] + 1, node[j, START] + node[j, LENGTH]):
                            if node[lists[p], MARK] != epoch:
                                same = False
                                break
                    following = bucket_next[j]
                    if same:
                        node[i, SIZE] += node[j, SIZE]
                        node[j, SIZE], node[j, LENGTH] = 0, 0
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
        for k in range(first, first + node[pivot, LENGTH]):
            i = lists[k]
            if node[i, SIZE] == 0:
                continue
            node[i, SIZE] = -node[i, SIZE]
            node[i, DEGREE] = max(0, min(node[i, DEGREE] + members, n - eliminated) - node[i, SIZE])
            follower = head[node[i, DEGREE]]
            node[i, AFTER], node[i, BEFORE] = follower, NONE
            if follower != NONE:
                node[follower, BEFORE] = i
            head[node[i, DEGREE]] = i
            least = min(least, node[i, DEGREE])
            lists[end] = i
            end += 1
        node[pivot, LENGTH] = end - first
        node[pivot, SIZE] = pivot_size
        if node[pivot, LENGTH] == 0:
            node[pivot, MARK] = 0
        node[pivot, ABSORBER], node[pivot, NUMBER] = NONE, n_groups
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
            prefetch(shifted(pointer(node), 8 * np.int64(order[starts[g + AHEAD]])))
        e = order[starts[g]]
        heights[g] = node[e, SIZE] + node[e, DEGREE]
        absorber = node[e, ABSORBER]
        parents[g] = after if absorber == NONE else node[absorber, NUMBER]
    if n_full:
        heights[n_groups], parents[n_groups] = n_full, NONE
        n_groups += 1
        starts[n_groups] = n
    return order, starts[: n_groups + 1], heights[:n_groups], parents[:n_groups], n_full


_options = {"cache": True, "nogil": True, "error_model": "numpy"}
_eliminated = numba.njit(
    types.Tuple((*(types.int32[::1],) * 4, types.int64))(
        _starts, _indices, types.int32[::1], types.int32[:, ::1], types.int64
    ),
    **_options,
)(_eliminate)
_eliminated_by_long = numba.njit(**_options)(_eliminate)  # compiled when it is called, if ever
