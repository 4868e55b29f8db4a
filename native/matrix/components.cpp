// Connected components of the vertices that edges join.
#include "core/disjoint_sets.hpp"
#include "matrix/checks.hpp"

namespace geodesic {

Array<Index> components(const Pattern& edges) {
  DisjointSets sets(edges.size());
  for (Index v = 0; v < edges.size(); ++v)
    for (Row entry = edges.indptr[v]; entry < edges.indptr[v + 1]; ++entry)
      sets.unite(v, edges.indices[entry]);
  return sets.labels();
}

Array<Index> components(std::span<const Index> edges, Index n_vertices) {
  DisjointSets sets(n_vertices);
  for (Index e = 0; e < count(edges); e += 2) sets.unite(edges[e], edges[e + 1]);
  return sets.labels();
}

}  // namespace geodesic
