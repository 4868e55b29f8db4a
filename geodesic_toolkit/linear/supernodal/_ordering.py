"""Approximate minimum degree: an order of elimination that keeps the factor sparse.

P. R. Amestoy, T. A. Davis, I. S. Duff, *An Approximate Minimum Degree Ordering Algorithm*, SIAM J.
Matrix Anal. Appl. 17, 1996, https://doi.org/10.1137/S0895479894278952

Eliminating a vertex joins its neighbours into a clique. The quotient graph stores a clique as one
*element*, the list of its members, instead of all its edges; a vertex then has a list of elements
and a list of *variables* (neighbours that no element covers yet). Variables that became
indistinguishable are merged and eliminated together.
"""

import math

import numba
import numpy as np
from numba import types

from geodesic_toolkit._typing import IntArray

__all__ = ["minimum_degree"]

NONE = -1

_starts = types.Array(types.int64, 1, "C", readonly=True)
_indices = types.Array(types.int32, 1, "C", readonly=True)


@numba.njit(  # type: ignore[untyped-decorator]
    types.int32[::1](_starts, _indices), cache=True, nogil=True, error_model="numpy"
)
def minimum_degree(indptr: IntArray, indices: IntArray) -> IntArray:
    """Return the vertices of a symmetric pattern in an order of elimination with little fill.

    Parameters
    ----------
    indptr : ndarray of shape (N + 1,), int64
    indices : ndarray of shape (nnz,), int32
        Both halves of the pattern; the diagonal may be there.

    Returns
    -------
    ndarray of shape (N,), int32
    """
    n = indptr.size - 1
    nnz = indptr[n]
    lists = np.empty(2 * nnz + 2 * n + 64, np.int32)
    start, length = np.empty(n, np.int64), np.zeros(n, np.int32)
    n_elements = np.zeros(n, np.int32)  # the first part of a variable's list
    size = np.ones(n, np.int32)  # of a supervariable: 0 once absorbed, < 0 in the current element
    degree = np.empty(n, np.int32)  # of an element: the size of its members
    mark = np.ones(n, np.int64)  # of an element: epoch + |Lₑ \ Lₚ|, or 0 once absorbed
    head, after, before = (
        np.full(n + 1, NONE, np.int32),
        np.full(n, NONE, np.int32),
        np.full(n, NONE, np.int32),
    )
    bucket, bucket_next, hashes = (
        np.full(n, NONE, np.int32),
        np.full(n, NONE, np.int32),
        np.zeros(n, np.int32),
    )
    last_member, next_member = np.arange(n).astype(np.int32), np.full(n, NONE, np.int32)
    order, ordered = np.empty(n, np.int32), 0

    end = np.int64(0)
    for i in range(n):
        start[i] = end
        for p in range(indptr[i], indptr[i + 1]):
            if indices[p] != i:
                lists[end] = indices[p]
                end += 1
        length[i] = end - start[i]
        degree[i] = length[i]
    # Rows that are nearly full belong at the end whatever the rest does, and are dear to update.
    full = max(16, int(10 * math.sqrt(n)))
    eliminated = 0
    n_full = 0
    for i in range(n - 1, -1, -1):
        if degree[i] > full:
            n_full += 1
            eliminated += 1
            size[i] = 0
            order[n - n_full] = i
        else:
            follower = head[degree[i]]
            after[i] = follower
            if follower != NONE:
                before[follower] = i
            head[degree[i]] = i

    epoch, least, largest = np.int64(2), 0, 0
    while eliminated < n:
        # -- the pivot: a variable of the least degree ---------------------------------------------
        while head[least] == NONE:
            least += 1
        pivot = head[least]
        head[least] = after[pivot]
        if after[pivot] != NONE:
            before[after[pivot]] = NONE
        pivot_size = size[pivot]
        eliminated += pivot_size
        size[pivot] = -pivot_size

        # -- its element Lₚ: its variables, and those of its elements, which it absorbs ------------
        needed = np.int64(length[pivot] - n_elements[pivot])
        for p in range(start[pivot], start[pivot] + n_elements[pivot]):
            needed += length[lists[p]]
        if end + needed > lists.size:
            live = np.int64(0)
            for i in range(n):
                live += length[i]
            moved = np.empty(live + needed + nnz, np.int32)
            end = np.int64(0)
            for i in range(n):
                old = start[i]
                start[i] = end
                for p in range(old, old + length[i]):
                    moved[end] = lists[p]
                    end += 1
            lists = moved
        first, members = end, 0
        for q in range(n_elements[pivot] + 1):
            own = q == n_elements[pivot]
            e = pivot if own else lists[start[pivot] + q]
            begin = start[e] + (n_elements[pivot] if own else 0)
            for p in range(begin, start[e] + length[e]):
                i = lists[p]
                own_size = size[i]
                if own_size > 0:
                    members += own_size
                    size[i] = -own_size
                    lists[end] = i
                    end += 1
                    if before[i] != NONE:
                        after[before[i]] = after[i]
                    else:
                        head[degree[i]] = after[i]
                    if after[i] != NONE:
                        before[after[i]] = before[i]
            if not own:
                mark[e], length[e] = 0, 0
        n_elements[pivot] = 0
        start[pivot], length[pivot] = first, end - first

        # -- |Lₑ \ Lₚ| for every element e that touches Lₚ -----------------------------------------
        epoch += 1
        for k in range(first, end):
            i = lists[k]
            own_size = -size[i]
            for p in range(start[i], start[i] + n_elements[i]):
                e = lists[p]
                left = mark[e]
                if left >= epoch:
                    mark[e] = left - own_size
                elif left != 0:
                    mark[e] = degree[e] + epoch - own_size

        # -- new lists and approximate degrees of the members --------------------------------------
        for k in range(first, end):
            i = lists[k]
            begin, stop = start[i], start[i] + length[i]
            variables = begin + n_elements[i]
            outside, fold, keep = 0, np.int64(0), begin
            for p in range(begin, variables):
                e = lists[p]
                left = mark[e]
                if left > epoch:
                    outside += left - epoch
                    fold += e
                    lists[keep] = e
                    keep += 1
                elif left != 0:  # all of e lies in the new element: absorb it
                    mark[e], length[e] = 0, 0
            kept = keep - begin
            for p in range(variables, stop):
                j = lists[p]
                own_size = size[j]
                if own_size > 0:
                    outside += own_size
                    fold += j
                    lists[keep] = j
                    keep += 1
            if keep == begin:  # nothing but the new element: eliminated along with the pivot
                pivot_size -= size[i]
                eliminated -= size[i]
                members += size[i]
                size[i], length[i] = 0, 0
                next_member[last_member[pivot]] = i
                last_member[pivot] = last_member[i]
                continue
            degree[i] = min(degree[i], outside)
            # The new element goes first. Its place was that of an element or a variable which is
            # there no longer, as it brought i into Lₚ.
            if keep > begin + kept:
                lists[keep] = lists[begin + kept]
            if kept > 0:
                lists[begin + kept] = lists[begin]
            lists[begin] = pivot
            n_elements[i], length[i] = kept + 1, keep - begin + 1
            hashes[i] = (fold + pivot) % n
            bucket_next[i] = bucket[hashes[i]]
            bucket[hashes[i]] = i
        degree[pivot] = members
        largest = max(largest, members)

        # -- members with equal lists become one variable ------------------------------------------
        epoch += largest + 1  # past every mark that this pivot has left
        for k in range(first, end):
            if size[lists[k]] == 0:
                continue
            key = hashes[lists[k]]
            i = bucket[key]
            bucket[key] = NONE
            while i != NONE and bucket_next[i] != NONE:
                epoch += 1
                for p in range(start[i] + 1, start[i] + length[i]):
                    mark[lists[p]] = epoch
                previous, j = i, bucket_next[i]
                while j != NONE:
                    same = length[j] == length[i] and n_elements[j] == n_elements[i]
                    if same:
                        for p in range(start[j] + 1, start[j] + length[j]):
                            if mark[lists[p]] != epoch:
                                same = False
                                break
                    following = bucket_next[j]
                    if same:
                        size[i] += size[j]
                        size[j], length[j] = 0, 0
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
        for k in range(first, first + length[pivot]):
            i = lists[k]
            if size[i] == 0:
                continue
            size[i] = -size[i]
            degree[i] = max(0, min(degree[i] + members, n - eliminated) - size[i])
            follower = head[degree[i]]
            after[i], before[i] = follower, NONE
            if follower != NONE:
                before[follower] = i
            head[degree[i]] = i
            least = min(least, degree[i])
            lists[end] = i
            end += 1
        length[pivot] = end - first
        size[pivot] = pivot_size
        if length[pivot] == 0:
            mark[pivot] = 0
        v = pivot
        while v != NONE:
            order[ordered] = v
            ordered += 1
            v = next_member[v]
    return order
