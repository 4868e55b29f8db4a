#include "wavefront/bearings.hpp"

#include <cmath>
#include <limits>

#include "core/angles.hpp"
#include "core/processor.hpp"
#include "triangles/measures.hpp"

namespace geodesic {
namespace {

Index next(Index corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
Index previous(Index corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

constexpr Index kPrefetchDistance = 12;  // corners of prefetch distance: vertices come in no order

// The angle of (x, y), in (-pi, pi].
double signed_angle(double x, double y) { return std::copysign(angle(x, std::abs(y)), y); }

}  // namespace

Directions directions_of(std::span<const Index> elements, std::span<const double> lengths,
                         std::span<const double> turns, std::span<const bool> mirrored,
                         std::span<const Index> twin) {
  const Index n_corners = count(elements);
  Directions result{Array<double>(n_corners), Array<double>(n_corners)};
  const Array<double> angles = corner_angles(lengths);
  Array<double> bisectors(n_corners);
  for (Index c = 0; c < n_corners; ++c) bisectors[c] = signed_angle(turns[2 * c], turns[2 * c + 1]);
  for (Index f = 0; f < n_corners; f += 3) {
    const double inside[3] = {angles[f] / 2, kPi - angles[f + 1] / 2,
                              kPi + angles[f] + angles[f + 2] / 2};
    for (Index c = 0; c < 3; ++c)
      bisectors[f + c] = (mirrored[f / 3] ? -inside[c] : inside[c]) - bisectors[f + c];
  }
  // From bisector to bisector the frame turns by half of both angles, scaled.
  const auto scale_at = [&](Index corner, bool is_mirrored) {
    if (twin.empty()) return 1.0;
    for (const Index side : {next(corner), previous(corner)}) {
      const Index mate = twin[side];
      if (mate < 0 || mate / 3 == corner / 3) continue;
      const Index other = elements[next(mate)] == elements[corner] ? next(mate) : previous(mate);
      const double between = (angles[corner] + angles[other]) / 2;
      if (!(between > 0)) continue;
      double turn = bisectors[other] - bisectors[corner];
      if ((side == previous(corner)) != is_mirrored) turn = -turn;
      return (turn - 2 * kPi * std::floor(turn / (2 * kPi))) / between;
    }
    return 1.0;
  };
  for (Index corner = 0; corner < n_corners; ++corner) {
    const bool is_mirrored = mirrored[corner / 3];
    const double scale = is_mirrored ? -scale_at(corner, true) : scale_at(corner, false);
    result.angles[previous(corner)] = bisectors[corner] - scale * angles[corner] / 2;
    result.scales[previous(corner)] = scale;
  }
  return result;
}

// Stars have the same triangle several times, measured differently: each bearing goes to the corner
// whose lengths are most like its own, among those that have none yet.
Array<Bearing> bearings_of(const Corners& corners, std::span<const Index> elements,
                           std::span<const double> lengths, std::span<const double> flat,
                           const DirectionsView& directions) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  Array<Bearing> bearings(corners.around.size(), Bearing{kNoNumber, kNoNumber});
  const Array<double> angles = corner_angles(flat);
  for (Index corner = 0; corner < count(elements); ++corner) {
    const Row soon =
        corners.starts[elements[std::min(corner + kPrefetchDistance, count(elements) - 1)]];
    for (Index k = 0; k < 6; k += 2) prefetch(corners.around.data() + soon + k);
    prefetch(bearings.data() + soon);
    const Index v = elements[corner];
    const auto a = static_cast<std::uint32_t>(elements[next(corner)]);
    const auto b = static_cast<std::uint32_t>(elements[previous(corner)]);
    double least = std::numeric_limits<double>::infinity();
    Row found = kNone;
    for (Row place = corners.starts[v]; place < corners.starts[v + 1]; ++place) {
      const Corner& its = corners.around[place];
      if (its.a != a || its.b != b || !std::isnan(bearings[place].turn)) continue;
      const double off = std::abs(its.to_a - lengths[previous(corner)]) +
                         std::abs(its.to_b - lengths[next(corner)]);
      if (found != kNone && !(off < least)) continue;
      least = off;
      found = place;
    }
    if (found == kNone) continue;
    const Index half = previous(corner);  // which leaves the corner
    bearings[found] = {directions.angles[half], directions.scales[half] * angles[corner]};
  }
  return bearings;
}

}  // namespace geodesic
