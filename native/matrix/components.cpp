#include "matrix/checks.hpp"

namespace geodesic {

// The connected component of every vertex, numbered by their first vertices, by union and find.
Array<Index> components(const Pattern& edges) {
  const Index n = edges.size();
  Array<Index> labels(n);
  Index* const first = labels.data();  // an earlier vertex of the same component, until the end
  const auto find = [&](Index v) {
    while (first[v] != v) v = first[v] = first[first[v]];
    return v;
  };
  for (Index v = 0; v < n; ++v) first[v] = v;
  for (Index v = 0; v < n; ++v) {
    for (Row entry = edges.indptr[v]; entry < edges.indptr[v + 1]; ++entry) {
      const Index one = find(v), other = find(edges.indices[entry]);
      first[std::max(one, other)] = std::min(one, other);
    }
  }
  Index count = 0;
  for (Index v = 0; v < n; ++v) first[v] = first[v] == v ? count++ : first[first[v]];
  return labels;
}

}  // namespace geodesic
