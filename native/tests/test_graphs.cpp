// Fronts across the corners of a lattice, with and without a limit.
#include <cmath>
#include <vector>

#include "graphs/fronts.hpp"
#include "tests/check.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr Index kSide = 20;

GraphCorners lattice() {
  std::vector<Index> edges;
  for (Index v = 0; v < kSide * kSide; ++v) {
    if (v % kSide + 1 < kSide) edges.insert(edges.end(), {v, v + 1});
    if (v + kSide < kSide * kSide) edges.insert(edges.end(), {v, v + kSide});
  }
  return corners_of(kSide * kSide, edges, std::vector<double>(edges.size() / 2, 1.0));
}

}  // namespace

TEST(fronts_that_end_at_a_limit_give_the_same_bits_up_to_it) {
  const GraphCorners corners = lattice();
  const Index n = corners.n_vertices();
  const std::vector<Index> begins{0, 1, 3, 4}, vertices{0, 210, 35, 399};
  const std::vector<double> starts{0.0, 1.5, -2.0, 0.0};
  std::vector<double> all(3 * n);
  cross_corners(corners, begins, vertices, starts, all, 1);
  CHECK(std::abs(all[kSide + 1] - std::sqrt(2.0)) < 1e-12);
  for (const double limit : {-1.0, 0.0, 2.5, 100.0}) {
    for (const int n_threads : {1, 2}) {
      const NearRows near = cross_corners_near(corners, begins, vertices, starts,
                                               std::vector<double>(3, limit), n_threads);
      for (Index k = 0; k < 3; ++k) {
        Index i = near.begins[k];
        for (Index v = 0; v < n; ++v) {
          if (all[k * n + v] > limit) continue;
          CHECK(i < near.begins[k + 1] && near.vertices[i] == v);
          CHECK(near.distances[i++] == all[k * n + v]);
        }
        CHECK(i == near.begins[k + 1]);
      }
    }
  }
}
