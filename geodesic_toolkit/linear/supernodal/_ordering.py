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
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._pointers import keep as keep_alive
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = ["Elimination", "minimum_degree"]

HELPERS = "a66f349ab98391e9"
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
    eliminate, kind = (_eliminated, np.int32) if narrow else (_eliminated_by_long, np.int64)
    fields = np.empty(FIELDS * n + 64, dtype=kind)
    aligned = -(fields.ctypes.data // fields.itemsize) % (64 // fields.itemsize)
    node = fields[aligned : aligned + FIELDS * n].reshape(n, FIELDS)  # no row on two cache lines
    links = np.full(6 * n + 1, NONE, dtype=np.int32)
    order, starts = np.empty(n, dtype=np.int32), np.zeros(n + 1, dtype=np.int32)
    heights, parents = np.empty(n, dtype=np.int32), np.empty(n, dtype=np.int32)
    n_groups, n_full = eliminate(
        indptr, indices, lists, node, links, np.iinfo(kind).max, order, starts, heights, parents
    )
    return Elimination(
        order, starts[: n_groups + 1], heights[:n_groups], parents[:n_groups], n_full
    )


def _eliminate(  # noqa: PLR0912, PLR0915, PLR0917 - its steps share a dozen arrays
    indptr: IntArray,
    indices: IndexArray,
    storage: IndexArray,
    fields: NDArray[Any],
    links: IndexArray,
    highest: int,
    vertices: IndexArray,
    starts: IndexArray,
    heights: IndexArray,
    parents: IndexArray,
) -> tuple[int, int]:
    """Write an `Elimination`, and return how many groups it has and how many vertices are full.

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
    vertices, starts, heights, parents : ndarray of shape (N,) or, `starts`, (N + 1,)
        Receive the fields of an `Elimination`; `starts` is zero before.
    """
    n = indptr.size - 1
    nnz = indptr[n]
    # Through pointers: an index of an array may be negative, and looking at it each time takes a
    # third of all.
    node, lists, neighbours = pointer(fields), pointer(storage), pointer(indices)
    head, bucket = pointer(links), pointer(links[n + 1 :])  # the first vertex of a degree, a hash
    bucket_next, hashes = pointer(links[2 * n + 1 :]), pointer(links[3 * n + 1 :])
    last_member, next_member = pointer(links[4 * n + 1 :]), pointer(links[5 * n + 1 :])
    order, ordered, n_groups = pointer(vertices), 0, 0

    end = np.int64(0)
    for i in range(n):
        its = shifted(node, FIELDS * i)
        last_member[i] = i
        its[START] = end
        for p in range(indptr[i], indptr[i + 1]):
            if neighbours[p] != i:
                lists[end] = neighbours[p]
                end += 1
        its[LENGTH] = its[DEGREE] = end - its[START]
        its[SIZE], its[ELEMENTS], its[MARK] = 1, 0, 1
        its[AFTER], its[BEFORE] = NONE, NONE
    # Rows that are nearly full belong at the end whatever the rest does, and are dear to update.
    full = max(16, np.int64(10 * math.sqrt(n)))
    eliminated = 0
    n_full = 0
    for i in range(n - 1, -1, -1):
        its = shifted(node, FIELDS * i)
        if its[DEGREE] > full:
            n_full += 1
            eliminated += 1
            its[SIZE] = 0
            order[n - n_full] = i
        else:
            follower = head[its[DEGREE]]
            its[AFTER] = follower
            if follower != NONE:
                node[FIELDS * follower + BEFORE] = i
            head[its[DEGREE]] = i

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
        own = shifted(node, FIELDS * pivot)
        follower = own[AFTER]  # the next pivot, most of the time
        upcoming = shifted(node, FIELDS * np.int64(follower))
        head[least] = follower
        if follower != NONE:
            upcoming[BEFORE] = NONE
            prefetch(upcoming)
        pivot_size = own[SIZE]
        eliminated += pivot_size
        own[SIZE] = -pivot_size

        # -- its element Lₚ: its variables, and those of its elements, which it absorbs ------------
        begin, count = own[START], own[ELEMENTS]
        needed = np.int64(own[LENGTH] - count)
        for p in range(begin, begin + count):
            needed += node[FIELDS * lists[p] + LENGTH]
        if end + needed > storage.size:
            live = np.int64(0)
            for i in range(n):
                live += node[FIELDS * i + LENGTH]
            moved = np.empty(live + needed + nnz, np.int32)
            end = np.int64(0)
            for i in range(n):
                its = shifted(node, FIELDS * i)
                old = its[START]
                its[START] = end
                for p in range(old, old + its[LENGTH]):
                    moved[end] = lists[p]
                    end += 1
            storage, lists = moved, pointer(moved)
        first, members = end, 0
        for q in range(count + 1):
            last = q == count
            e = pivot if last else lists[own[START] + q]
            element = shifted(node, FIELDS * e)
            begin = element[START]
            for p in range(begin + count if last else begin, begin + element[LENGTH]):
                i = lists[p]
                its = shifted(node, FIELDS * i)
                size = its[SIZE]
                if size > 0:
                    members += size
                    its[SIZE] = -size
                    lists[end] = i
                    end += 1
                    prefetch(shifted(lists, np.int64(its[START])))
                    before, after = its[BEFORE], its[AFTER]
                    if before != NONE:
                        node[FIELDS * before + AFTER] = after
                    else:
                        head[its[DEGREE]] = after
                    if after != NONE:
                        node[FIELDS * after + BEFORE] = before
            if not last:
                element[MARK], element[LENGTH], element[ABSORBER] = 0, 0, pivot
        own[ELEMENTS], own[START], own[LENGTH] = 0, first, end - first

        # -- |Lₑ \ Lₚ| for every element e that touches Lₚ -----------------------------------------
        epoch += 1
        if follower != NONE:
            prefetch(shifted(lists, np.int64(upcoming[START])))
        for k in range(first, end):
            its = shifted(node, FIELDS * lists[k])
            size = -its[SIZE]
            for p in range(its[START], its[START] + its[ELEMENTS]):
                element = shifted(node, FIELDS * lists[p])
                left = element[MARK]
                if left >= epoch:
                    element[MARK] = left - size
                elif left != 0:
                    element[MARK] = element[DEGREE] + epoch - size

        # -- new lists and approximate degrees of the members --------------------------------------
        for k in range(first, end):
            i = lists[k]
            its = shifted(node, FIELDS * i)
            begin, stop = its[START], its[START] + its[LENGTH]
            variables = begin + its[ELEMENTS]
            outside, fold, keep = 0, np.int64(0), begin
            for p in range(begin, variables):
                e = lists[p]
                element = shifted(node, FIELDS * e)
                left = element[MARK]
                if left > epoch:
                    outside += left - epoch
                    fold += e
                    lists[keep] = e
                    keep += 1
                elif left != 0:  # all of e lies in the new element: absorb it
                    element[MARK], element[LENGTH], element[ABSORBER] = 0, 0, pivot
            kept = keep - begin
            for p in range(variables, stop):
                j = lists[p]
                size = node[FIELDS * j + SIZE]
                if size > 0:
                    outside += size
                    fold += j
                    lists[keep] = j
                    keep += 1
            if keep == begin:  # nothing but the new element: eliminated along with the pivot
                size = its[SIZE]
                pivot_size -= size
                eliminated -= size
                members += size
                its[SIZE], its[LENGTH] = 0, 0
                next_member[last_member[pivot]] = i
                last_member[pivot] = last_member[i]
                continue
            its[DEGREE] = min(its[DEGREE], outside)
            # The new element goes first. Its place was that of an element or a variable which is
            # there no longer, as it brought i into Lₚ.
            if keep > begin + kept:
                lists[keep] = lists[begin + kept]
            if kept > 0:
                lists[begin + kept] = lists[begin]
            lists[begin] = pivot
            its[ELEMENTS], its[LENGTH] = kept + 1, keep - begin + 1
            key = (fold + pivot) & mask
            hashes[i], bucket_next[i] = key, bucket[key]
            bucket[key] = i
        own[DEGREE] = members
        largest = max(largest, members)

        if follower != NONE:
            for p in range(upcoming[START], upcoming[START] + upcoming[LENGTH]):
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
                its = shifted(node, FIELDS * i)
                length, count = its[LENGTH], its[ELEMENTS]
                for p in range(its[START] + 1, its[START] + length):
                    node[FIELDS * lists[p] + MARK] = epoch
                previous, j = i, bucket_next[i]
                while j != NONE:
                    other = shifted(node, FIELDS * j)
                    same = other[LENGTH] == length and other[ELEMENTS] == count
                    if same:
                        for p in range(other[START] + 1, other[START] + length):
                            if node[FIELDS * lists[p] + MARK] != epoch:
                                same = False
                                break
                    following = bucket_next[j]
                    if same:
                        its[SIZE] += other[SIZE]
                        other[SIZE], other[LENGTH] = 0, 0
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
        for k in range(first, first + own[LENGTH]):
            i = lists[k]
            its = shifted(node, FIELDS * i)
            size = -its[SIZE]
            if size == 0:
                continue
            its[SIZE] = size
            degree = max(min(its[DEGREE] + members, n - eliminated) - size, 0)
            following = head[degree]
            its[DEGREE], its[AFTER], its[BEFORE] = degree, following, NONE
            if following != NONE:
                node[FIELDS * following + BEFORE] = i
            head[degree] = i
            least = min(least, degree)
            lists[end] = i
            end += 1
        own[LENGTH], own[SIZE] = end - first, pivot_size
        if end == first:
            own[MARK] = 0
        own[ABSORBER], own[NUMBER] = NONE, n_groups
        v = pivot
        while v != NONE:
            order[ordered] = v
            ordered += 1
            v = next_member[v]
        n_groups += 1
        starts[n_groups] = ordered

    after = n_groups if n_full else NONE  # what is full takes over from all that is left
    for g in range(n_groups):
        if g + AHEAD < n_groups:
            prefetch(shifted(node, FIELDS * np.int64(order[starts[g + AHEAD]])))
        element = shifted(node, FIELDS * order[starts[g]])
        heights[g] = element[SIZE] + element[DEGREE]
        absorber = element[ABSORBER]
        parents[g] = after if absorber == NONE else node[FIELDS * absorber + NUMBER]
    if n_full:
        heights[n_groups], parents[n_groups] = n_full, NONE
        n_groups += 1
        starts[n_groups] = n
    keep_alive((storage,))
    return n_groups, n_full


_new = types.int32[::1]
_eliminated = kernel(
    types.UniTuple(types.int64, 2)(
        _starts, _indices, _new, types.int32[:, ::1], _new, types.int64, *(_new,) * 4
    )
)(_eliminate)
_eliminated_by_long = kernel()(_eliminate)  # compiled when it is called, if ever
