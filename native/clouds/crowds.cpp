#include "clouds/crowds.hpp"

#include <stdexcept>

#include "core/threads.hpp"

namespace geodesic {
namespace {

// The i-th and the 4 i-th nearest neighbours are compared, for these i. Lines are found by the last
// two pairs only: the pair of the second and the eighth neighbour would take surfaces of lines 3
// spacings apart for lines.
constexpr Index kNearerNeighbours[] = {2, 4, 10};
constexpr Index kFirstPairOfLines = 1;
constexpr std::size_t kPairs = std::size(kNearerNeighbours);

// Squared ratio of their distances from which on a point lies on a line: on surfaces it is 4, on
// lines 16. Measured, as the share of points that this finds: 0 to 1 % of clouds that sample
// surfaces evenly or at random (noise of a third of the spacing included), all points of scan lines
// 5 to 40 times as far apart as their points. From 2.8^2 to 3.6^2 neither changes by more than a
// hundredth.
constexpr double kMinSquaredRatioOfLines = 3.2 * 3.2;

// The same for heaps, which may be arbitrarily small; on lines the ratio is at most 16.
constexpr double kMinSquaredRatioOfHeaps = 4.5 * 4.5;

// Numbers of nearest points, the point itself included, of which the majority must be on a line, or
// in a heap.
constexpr Index kPointsAlongLines = 32, kPointsInHeaps = 9;

// The findings of the pairs of a point, one bit each.
using Signs = std::uint8_t;
constexpr Signs line_sign(std::size_t pair) { return static_cast<Signs>(1U << pair); }
constexpr Signs heap_sign(std::size_t pair) { return static_cast<Signs>(1U << (kPairs + pair)); }

double squared_distance(const Cloud& cloud, Index a, Index b) {
  const Vector3 step = at(cloud.points, b) - at(cloud.points, a);
  return dot(step, step);
}

Index pairs_within(Index width) {
  return std::count_if(std::begin(kNearerNeighbours), std::end(kNearerNeighbours),
                       [&](Index nearer) { return 4 * nearer <= width; });
}

Signs signs_of(const Cloud& cloud, Index point) {
  const std::span<const Index> near = cloud.around(point);
  Signs signs = 0;
  for (std::size_t pair = 0; pair < static_cast<std::size_t>(pairs_within(cloud.width)); ++pair) {
    const Index number = kNearerNeighbours[pair];
    const double nearer = squared_distance(cloud, point, near[number - 1]);
    const double farther = squared_distance(cloud, point, near[4 * number - 1]);
    if (farther > kMinSquaredRatioOfLines * nearer && pair >= kFirstPairOfLines)
      signs |= line_sign(pair);
    if (farther > kMinSquaredRatioOfHeaps * nearer) signs |= heap_sign(pair);
  }
  return signs;
}

// True if most of the points around a point have the given sign.
bool agreed(const Cloud& cloud, std::span<const Signs> signs, Index point, Signs sign,
            Index around) {
  const auto near = cloud.around(point).first(std::min(around - 1, cloud.width));
  Index votes = (signs[point] & sign) != 0;
  for (const Index other : near) votes += (signs[other] & sign) != 0;
  return 2 * votes > count(near) + 1;
}

double reach_of(const Cloud& cloud, std::span<const Signs> signs, Index point) {
  for (auto pair = static_cast<std::size_t>(pairs_within(cloud.width)); pair-- > 0;) {
    if (agreed(cloud, signs, point, heap_sign(pair), kPointsInHeaps) ||
        agreed(cloud, signs, point, line_sign(pair), kPointsAlongLines)) {
      const Index last = cloud.around(point)[4 * kNearerNeighbours[pair] - 1];
      return std::sqrt(squared_distance(cloud, point, last));
    }
  }
  return 0.0;
}

}  // namespace

Array<double> crowd_reaches(const Cloud& cloud, int n_threads) {
  check_neighbours(cloud, n_threads);
  Array<Signs> signs(cloud.size());
  in_pieces(cloud.size(), kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) signs[v] = signs_of(cloud, v);
  });
  Array<double> reaches(cloud.size());
  in_pieces(cloud.size(), kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) reaches[v] = reach_of(cloud, signs, v);
  });
  return reaches;
}

Array<bool> thinned(const Cloud& cloud, std::span<const double> radii) {
  check_neighbours(cloud, 1);
  Array<bool> kept(cloud.size());
  for (Index v = 0; v < cloud.size(); ++v) kept[v] = radii[v] == 0;
  for (Index v = 0; v < cloud.size(); ++v) {
    if (radii[v] == 0) continue;
    const auto near = cloud.around(v);
    kept[v] = std::ranges::none_of(near, [&](Index other) {
      return kept[other] && squared_distance(cloud, v, other) < radii[v] * radii[v];
    });
  }
  return kept;
}

}  // namespace geodesic
