// Connected components by union and find.
//
// R. E. Tarjan, J. van Leeuwen, Worst-case Analysis of Set Union Algorithms, J. ACM 31, 1984,
// https://doi.org/10.1145/62.2160
#include "matrix/checks.hpp"

namespace geodesic {
namespace {

// Trees of vertices, whose roots are the first vertices of their components.
class Forest {
 public:
  explicit Forest(Index n) : first_(n) {
    for (Index v = 0; v < n; ++v) first_[v] = v;
  }
  void join(Index a, Index b) {
    const Index one = find(a), other = find(b);
    first_[std::max(one, other)] = std::min(one, other);
  }
  // The number of each vertex's component; the forest is used up.
  Array<Index> labels() {
    Index known = 0;
    for (Index v = 0; v < first_.size(); ++v)
      first_[v] = first_[v] == v ? known++ : first_[first_[v]];
    return std::move(first_);
  }

 private:
  Index find(Index v) {
    while (first_[v] != v) v = first_[v] = first_[first_[v]];
    return v;
  }
  Array<Index> first_;  // an earlier vertex of the same component
};

}  // namespace

Array<Index> components(const Pattern& edges) {
  Forest forest(edges.size());
  for (Index v = 0; v < edges.size(); ++v)
    for (Row entry = edges.indptr[v]; entry < edges.indptr[v + 1]; ++entry)
      forest.join(v, edges.indices[entry]);
  return forest.labels();
}

Array<Index> components(std::span<const Index> edges, Index n_vertices) {
  Forest forest(n_vertices);
  for (Index e = 0; e < count(edges); e += 2) forest.join(edges[e], edges[e + 1]);
  return forest.labels();
}

}  // namespace geodesic
