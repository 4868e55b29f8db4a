#include <cmath>

#include "matrix/checks.hpp"

namespace geodesic {

// The share of positive entries in the absolute sum of a row without the diagonal, averaged by mass
// over so many rings. Only what lies right of the diagonal is looked at.
Array<double> obtuse_excess(const MatrixView& matrix, std::span<const double> mass, Index rings) {
  struct Sum {
    double excess, area;
  };
  const Index n = matrix.size();
  Array<Sum> sums(n, {0.0, 0.0}), wider(n);
  const auto for_each_edge = [&](Index v, auto&& visit) {
    for (Row entry = matrix.indptr[v]; entry < matrix.indptr[v + 1]; ++entry)
      if (matrix.indices[entry] > v) visit(matrix.indices[entry], entry);
  };
  for (Index v = 0; v < n; ++v) {
    for_each_edge(v, [&](Row head, Row entry) {
      const double weight = matrix.data[entry];
      for (const Index end : {v, static_cast<Index>(head)}) {
        sums[end].excess += std::max(weight, 0.0);
        sums[end].area += std::abs(weight);
      }
    });
  }
  for (Index v = 0; v < n; ++v) {
    const auto [positive, absolute] = sums[v];
    sums[v] = {absolute > 0 ? positive / absolute * mass[v] : 0.0, mass[v]};
  }
  for (Index ring = 0; ring < rings; ++ring) {
    std::copy(sums.begin(), sums.end(), wider.begin());
    for (Index v = 0; v < n; ++v) {
      Sum own = wider[v];
      const Sum before = sums[v];
      for_each_edge(v, [&](Row head, Row) {
        own.excess += sums[head].excess;
        own.area += sums[head].area;
        wider[head].excess += before.excess;
        wider[head].area += before.area;
      });
      wider[v] = own;
    }
    std::swap(sums, wider);
  }
  Array<double> mean(n);
  for (Index v = 0; v < n; ++v) mean[v] = sums[v].area > 0 ? sums[v].excess / sums[v].area : 0.0;
  return mean;
}

}  // namespace geodesic
