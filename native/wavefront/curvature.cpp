#include "wavefront/curvature.hpp"

#include "core/angles.hpp"

namespace geodesic {
namespace {

constexpr Index kTrianglesPerBlock = 64;  // triangles whose angles stay in the first level of cache
constexpr double kRoot3 = 1.73205080756887729353;

// A defect and the area that it belongs to.
struct Bend {
  double defect = 0.0, area = 0.0;
};

// K from the bends of vertices and of what is around them.
Array<double> curvature_of(const Array<Bend>& own, const Array<Bend>& around, double coarse) {
  Array<double> curvature(own.size());
  for (Index v = 0; v < own.size(); ++v) {
    const double mean = around[v].area > 0 ? around[v].defect / around[v].area : 0.0;
    const double spread = std::abs(mean) * own[v].area * 2 / kRoot3;  // K h^2 if equilateral
    curvature[v] = mean / (1 + spread / coarse);
  }
  return curvature;
}

// True if each of the corners begins where the last one ended.
bool all_the_way_round(std::span<const Corner> corners) {
  if (corners.empty()) return false;
  std::uint32_t last = corners.back().b;
  bool together = true;
  for (const Corner& corner : corners) {
    together &= corner.a == last;
    last = corner.b;
  }
  return together;
}

}  // namespace

Array<double> angle_defects(std::span<const Index> elements, std::span<const double> frames,
                            std::span<const bool> boundary) {
  Array<double> defects(count(boundary));
  for (Index v = 0; v < defects.size(); ++v) defects[v] = boundary[v] ? kPi : 2 * kPi;
  double first[kTrianglesPerBlock], second[kTrianglesPerBlock];
  for (Index begin = 0; begin < count(elements); begin += 3 * kTrianglesPerBlock) {
    const Index together = std::min(kTrianglesPerBlock, count(elements) / 3 - begin / 3);
    const double* const frame = frames.data() + begin;
    for (Index c = 0; c < together; ++c) {
      const double p = frame[3 * c], q = frame[3 * c + 1], r = frame[3 * c + 2];
      // An angle is pi minus what the other two hat gradients enclose.
      first[c] = angle(-q * r, std::abs(p * r));
      second[c] = angle((q + r) * r, std::abs(p * r));
    }
    const Index* const corner = elements.data() + begin;
    for (Index c = 0; c < together; ++c) {
      defects[corner[3 * c]] -= first[c];
      defects[corner[3 * c + 1]] -= second[c];
      defects[corner[3 * c + 2]] -= kPi - first[c] - second[c];
    }
  }
  return defects;
}

Array<double> curvatures(std::span<const Index> elements, std::span<const double> measure,
                         std::span<const double> defects, const Corners& corners,
                         std::span<const bool> boundary, double coarse) {
  const Index n = corners.n_vertices();
  Array<Bend> own(n, Bend{}), around(n);
  Array<bool> closed(n);
  Array<Row> seen(n, kNone);
  for (Index e = 0; e < count(elements); ++e) own[elements[e]].area += measure[e / 3] / 3;
  const auto corners_of = [&](Index v) {
    return std::span(corners.around.data() + corners.starts[v],
                     corners.around.data() + corners.starts[v + 1]);
  };
  for (Index v = 0; v < n; ++v) {
    const auto mine = corners_of(v);
    Index neighbours = count(mine);
    closed[v] = all_the_way_round(mine);
    if (!closed[v] && !boundary[v]) {
      neighbours = 0;
      for (const Corner& corner : mine) {
        for (const std::uint32_t other : {corner.a, corner.b}) {
          neighbours += static_cast<Index>(other) != v && seen[other] != v;
          seen[other] = static_cast<Row>(v);
        }
      }
    }
    // Where sheets meet there is no angle to fall short of: more faces than neighbours.
    const bool flat = boundary[v] || count(mine) > neighbours || own[v].area == 0;
    own[v].defect = flat ? 0.0 : defects[v];
  }
  for (Index v = 0; v < n; ++v) {
    const auto mine = corners_of(v);
    const auto faces = static_cast<double>(mine.size());
    const double twice = closed[v] ? 2.0 : 1.0;  // each neighbour is one's a and another's b
    Bend sum{faces * own[v].defect, faces * own[v].area};
    for (const Corner& corner : mine) {
      sum.defect += twice * own[corner.a].defect;
      sum.area += twice * own[corner.a].area;
      if (closed[v]) continue;
      sum.defect += own[corner.b].defect;
      sum.area += own[corner.b].area;
    }
    around[v] = sum;
  }
  return curvature_of(own, around, coarse);
}

Array<double> star_curvatures(std::span<const Index> elements, std::span<const double> frames,
                              std::span<const bool> boundary, double coarse) {
  const Index n = count(boundary);
  Array<Bend> own(n, Bend{}), around(n, Bend{});
  for (Index e = 0; e < count(elements); e += 3) {
    const double p = frames[e], q = frames[e + 1], r = frames[e + 2], spanned = std::abs(p * r);
    if (!(spanned > 0)) continue;
    own[elements[e]].defect += angle(-q * r, spanned);
    own[elements[e]].area += 1 / (6 * spanned);
  }
  for (Index v = 0; v < n; ++v) {
    const bool flat = boundary[v] || own[v].area == 0;
    own[v].defect = flat ? 0.0 : 2 * kPi - own[v].defect;
  }
  for (Index e = 0; e < count(elements); e += 3) {
    if (frames[e] * frames[e + 2] == 0) continue;
    for (Index c = 0; c < 3; ++c) {
      around[elements[e]].defect += own[elements[e + c]].defect;
      around[elements[e]].area += own[elements[e + c]].area;
    }
  }
  return curvature_of(own, around, coarse);
}

}  // namespace geodesic
