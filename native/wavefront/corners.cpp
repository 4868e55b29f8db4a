#include "wavefront/corners.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/processor.hpp"

namespace geodesic {
namespace {

// Maximum number of corners of a vertex that are sorted: the cost grows with its square.
constexpr Index kMaxSortedCorners = 32;

// Share of a length by which two triangles may differ about an edge: more than rounding.
constexpr double kLengthTolerance = 1e-9;

// The same where triangles may disagree about an edge by any share.
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr Index kPrefetchDistance =
    48;  // corners by which memory is asked for: places come in no order

// Edges opposite the corners of an element.
struct Lengths {
  double jk, ki, ij;
};

// A hat function's gradient is 1 / height, and any two of them span 1 / (2 area).
Lengths lengths_of(const Index* element, const double* frame) {
  const double p = frame[0], q = frame[1], r = frame[2], s = q + r;
  const double at_i = std::sqrt(p * p + s * s), at_j = std::sqrt(p * p + q * q), at_k = std::abs(r);
  const double spanned = std::abs(p * r);
  if (spanned > 0) return {at_i / spanned, at_j / spanned, at_k / spanned};
  const Index i = element[0], j = element[1], k = element[2];
  const double length = 1 / std::max({at_i, at_j, at_k});
  return {j != k ? length : 0.0, k != i ? length : 0.0, i != j ? length : 0.0};
}

// Sort the corners of a vertex so that each begins where the last one ended, if one does.
void go_round(std::span<Corner> corners) {
  for (std::size_t c = 1; c + 1 < corners.size(); ++c) {
    for (std::size_t other = c; other < corners.size(); ++other) {
      if (corners[other].a != corners[c - 1].b) continue;
      std::swap(corners[c], corners[other]);
      break;
    }
  }
}

// True if one of `others`, of the same vertex, is the same triangle.
bool among(const Corner& corner, std::span<const Corner> others) {
  return std::ranges::any_of(others, [&](const Corner& other) {
    return (other.a == corner.a && other.b == corner.b) ||
           (other.a == corner.b && other.b == corner.a);
  });
}

}  // namespace

Corners gather_corners(std::span<const Index> elements, std::span<const double> frames, bool stars,
                       Index n_vertices) {
  Corners result{Array<Row>(n_vertices + 1, 0), Array<Row>(n_vertices, 0),
                 Array<Corner>(count(elements))};
  Row *const starts = result.starts.data(), *const ends = result.ends.data();
  const auto is_foreign = [&](Index e) { return stars && frames[e] * frames[e + 2] != 0; };
  for (Index e = 0; e < count(elements); e += 3) {
    const bool foreign = is_foreign(e);
    for (Index c = 0; c < 3; ++c) {
      ++starts[elements[e + c] + 1];
      ends[elements[e + c]] += !(foreign && c > 0);
    }
  }
  Array<Row> free(n_vertices), free_foreign(n_vertices);
  for (Index v = 0; v < n_vertices; ++v) {
    starts[v + 1] += starts[v];
    free[v] = starts[v];
    free_foreign[v] = ends[v] = starts[v] + ends[v];
    if (ends[v] == starts[v]) ends[v] = starts[v + 1];  // no star of its own
  }
  for (Index e = 0; e < count(elements); e += 3) {
    const Index soon = std::min(e + kPrefetchDistance, count(elements) - 3);
    for (Index c = 0; c < 3; ++c) prefetch(&result.around[free[elements[soon + c]]]);
    const Index i = elements[e], j = elements[e + 1], k = elements[e + 2];
    const auto [jk, ki, ij] = lengths_of(&elements[e], &frames[e]);
    Array<Row>& others = is_foreign(e) ? free_foreign : free;
    const auto a = static_cast<std::uint32_t>(i), b = static_cast<std::uint32_t>(j),
               c = static_cast<std::uint32_t>(k);
    result.around[free[i]++] = {b, c, ij, ki, jk};
    result.around[others[j]++] = {c, a, jk, ij, ki};
    result.around[others[k]++] = {a, b, ki, jk, ij};
  }
  for (Index v = 0; v < n_vertices; ++v) {
    const Index own = ends[v] - starts[v];
    if (own <= kMaxSortedCorners)
      go_round({result.around.data() + starts[v], static_cast<std::size_t>(own)});
  }
  return result;
}

void close_rims(Corners& corners, std::span<const bool> boundary, bool edges_agree) {
  const auto around = [&](Index v) {
    return std::span(corners.around.data() + corners.starts[v],
                     corners.around.data() + corners.starts[v + 1]);
  };
  // Flips may leave several edges between the same ends, and they differ in their lengths.
  const double tolerance = edges_agree ? kLengthTolerance : kInfinity;
  const auto is_side = [tolerance](const Corner& corner, std::uint32_t end, double length) {
    return (corner.a == end && std::abs(corner.to_a - length) <= tolerance * length) ||
           (corner.b == end && std::abs(corner.to_b - length) <= tolerance * length);
  };
  for (Index v = 0; v < corners.n_vertices(); ++v) {
    for (Corner& corner : around(v)) {
      if (!boundary[corner.a] || !boundary[corner.b]) continue;
      const auto sides = std::ranges::count_if(around(corner.a), [&](const Corner& other) {
        return is_side(other, corner.b, corner.edge);
      });
      if (sides == 1) corner.edge = -corner.edge;
    }
  }
}

void add_missed_triangles(Corners& corners) {
  for (Index v = 0; v < corners.n_vertices(); ++v) {
    Corner* const begin = corners.around.data() + corners.starts[v];
    Corner* const end = corners.around.data() + corners.starts[v + 1];
    Corner* own = corners.around.data() + corners.ends[v];  // behind its last one
    for (Corner* corner = own; corner != end; ++corner) {
      if (among(*corner, {begin, own}) ||
          !(among(*corner, {own, corner}) || among(*corner, {corner + 1, end})))
        continue;
      std::swap(*corner, *own);
      ++own;
    }
    corners.ends[v] = static_cast<Row>(own - corners.around.data());
  }
}

}  // namespace geodesic
