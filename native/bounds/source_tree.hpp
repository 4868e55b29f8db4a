// Source positions in space, arranged in a tree to be searched for the nearest.
#pragma once

#include <limits>
#include <vector>

#include "core/array.hpp"

namespace geodesic {

// Source positions, (P, 3), and the distance at each.
struct SourceValues {
  std::span<const double> positions, distances;
  Index size() const { return count(distances); }
};

// A k-d tree: J. L. Bentley, Multidimensional binary search trees used for associative searching,
// 1975, https://doi.org/10.1145/361002.361007. A node knows the box around its places, and the
// least distance that is read in it.
class SourceTree {
 public:
  explicit SourceTree(const SourceValues& starts);

  // The least of what the straight lines from all places read at a point, or the first found that
  // is not above `enough`.
  double straight(const double* point, double enough);

  // True if the straight line from the last nearest source reads at most `enough` at a point. For a
  // point close to the last one that is often so.
  bool last_reads_at_most(double enough, const double* point) const {
    const double* const at = &starts_.positions[3 * last_];
    const double x = point[0] - at[0], y = point[1] - at[1], z = point[2] - at[2];
    const double beyond = enough - starts_.distances[last_];
    return beyond >= 0 && beyond * beyond >= x * x + y * y + z * z;
  }

 private:
  struct Node {
    double low[3], high[3], least;
    Index begin, end, left;  // children at left and left + 1; none in a leaf
  };

  void divide(Index node);
  double from(Index place, const double* point) const;
  double bound(const Node& node, const double* point) const;
  void visit(Index node, const double* point, double enough, double& best);

  SourceValues starts_;
  std::vector<Index> order_;
  std::vector<Node> nodes_;
  Index last_ = 0;
};

}  // namespace geodesic
