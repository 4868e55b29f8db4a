// Disjoint sets of numbers, united one after the other.
//
// R. E. Tarjan, J. van Leeuwen, Worst-case Analysis of Set Union Algorithms, J. ACM 31, 1984,
// https://doi.org/10.1145/62.2160
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Trees of numbers, whose roots are the least numbers of their sets.
class DisjointSets {
 public:
  explicit DisjointSets(Index n) : earlier_(n) {
    for (Index i = 0; i < n; ++i) earlier_[i] = i;
  }

  // The least number of a set.
  Index find(Index i) {
    while (earlier_[i] != i) i = earlier_[i] = earlier_[earlier_[i]];
    return i;
  }

  // False where both are in one set already.
  bool unite(Index a, Index b) {
    const Index one = find(a), other = find(b);
    earlier_[std::max(one, other)] = std::min(one, other);
    return one != other;
  }

  // The number of each one's set, in the order of their least numbers; the trees are used up.
  Array<Index> labels() {
    Index known = 0;
    for (Index i = 0; i < earlier_.size(); ++i)
      earlier_[i] = earlier_[i] == i ? known++ : earlier_[earlier_[i]];
    return std::move(earlier_);
  }

 private:
  Array<Index> earlier_;  // another number of the same set
};

}  // namespace geodesic
