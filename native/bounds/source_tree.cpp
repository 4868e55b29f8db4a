#include "bounds/source_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace geodesic {
namespace {

// Number of positions in a leaf.
constexpr Index kLeafSize = 8;

}  // namespace

SourceTree::SourceTree(const SourceValues& starts)
    : starts_(starts), order_(static_cast<std::size_t>(starts.size())) {
  std::iota(order_.begin(), order_.end(), Index{0});
  nodes_.push_back({{}, {}, 0, 0, starts.size(), kNone});
  for (std::size_t node = 0; node < nodes_.size(); ++node) divide(static_cast<Index>(node));
}

void SourceTree::divide(Index index) {
  Node node = nodes_[index];
  node.least = std::numeric_limits<double>::infinity();
  std::fill_n(node.low, 3, node.least);
  std::fill_n(node.high, 3, -node.least);
  for (Index i = node.begin; i < node.end; ++i) {
    const double* const place = &starts_.positions[3 * order_[i]];
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis] = std::min(node.low[axis], place[axis]);
      node.high[axis] = std::max(node.high[axis], place[axis]);
    }
    node.least = std::min(node.least, starts_.distances[order_[i]]);
  }
  if (node.end - node.begin > kLeafSize) {
    int widest = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (node.high[axis] - node.low[axis] > node.high[widest] - node.low[widest]) widest = axis;
    const Index middle = (node.begin + node.end) / 2;
    const auto coordinate = [&](Index place) { return starts_.positions[3 * place + widest]; };
    std::ranges::nth_element(order_.begin() + node.begin, order_.begin() + middle,
                             order_.begin() + node.end, {}, coordinate);
    node.left = static_cast<Index>(nodes_.size());
    nodes_.push_back({{}, {}, 0, node.begin, middle, kNone});
    nodes_.push_back({{}, {}, 0, middle, node.end, kNone});
  }
  nodes_[index] = node;
}

double SourceTree::from(Index place, const double* point) const {
  const double* const at = &starts_.positions[3 * place];
  const double x = point[0] - at[0], y = point[1] - at[1], z = point[2] - at[2];
  return starts_.distances[place] + std::sqrt(x * x + y * y + z * z);
}

double SourceTree::bound(const Node& node, const double* point) const {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside =
        std::max({node.low[axis] - point[axis], point[axis] - node.high[axis], 0.0});
    sum += outside * outside;
  }
  return node.least + std::sqrt(sum);
}

double SourceTree::straight(const double* point, double enough) {
  double best = std::numeric_limits<double>::infinity();
  visit(0, point, enough, best);
  return best;
}

void SourceTree::visit(Index index, const double* point, double enough, double& best) {
  const Node& node = nodes_[index];
  if (node.left == kNone) {
    for (Index i = node.begin; i < node.end; ++i) {
      const double here = from(order_[i], point);
      if (here < best) best = here, last_ = order_[i];
    }
    return;
  }
  double near = bound(nodes_[node.left], point), far = bound(nodes_[node.left + 1], point);
  Index first = node.left, second = node.left + 1;
  if (far < near) std::swap(near, far), std::swap(first, second);
  if (near < best) visit(first, point, enough, best);
  if (far < best && best > enough) visit(second, point, enough, best);
}

}  // namespace geodesic
