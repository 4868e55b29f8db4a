#include "triangles/normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "triangles/frames.hpp"
#include "triangles/vector3.hpp"

namespace geodesic {
namespace {

// Sum of normals, as a share of that of their lengths, below which they cancel.
constexpr double kCancelled = 1e-9;

// Number of neighbours above which a vertex has no fit, and adds none to those of others: where
// thousands of edges meet, two rings of each vertex nearby would have thousands.
constexpr Index kMostNeighbours = 64;

// Least number of heights above the number of coefficients, for residuals that say something. The
// same creases keep their normals for 3 and 5; with 5, those at more vertices of triangulations of
// random points have no fit: ellipsoids have twice the tilt.
constexpr Index kSpareHeights = 3;

// Length, as a share of the longest one, below which a neighbour is at the place of the vertex.
constexpr double kSamePlace = 1e-9;

// Norm of a column, as a share of what it was, below which others have explained it.
constexpr double kDependent = 1e-7;

// Squared slope over its variance up to which it is taken for noise. Tuned on 60 creases of 5 to
// 135 degrees in irregular planes, and on ellipsoids, cylinders and tori of 1,000 and 3,500
// vertices, with noise of up to a tenth of the spacing. From 1.5 to 4 the mean tilt is never more
// than that of Max; below, normals beside creases turn (of 31,000: 18 for 1, 4 for 1.5, 1 for 2 and
// 3, 0 for 4), and above, fewer of coarse smooth surfaces are corrected.
constexpr double kNoise = 2.0;

// Squared slope over its variance from which on it is believed as a whole. Tuned with kNoise, as
// twice that.
constexpr double kClear = 4.0;

// Slope above which the plane of the heights is too far from the surface for a fit. Tuned as
// kNoise: 0.1 and 0.3 give smooth surfaces the same normals; beside creases the largest change is
// 0.1 degrees for 0.1, 4 for 0.3 and 26 for 1.
constexpr double kMostSlope = 0.1;

// Slope of rounding.
constexpr double kRounding = 1e-12;

void put(Array<double>& table, Index row, const Vector3& a) {
  table[3 * row] = a.x;
  table[3 * row + 1] = a.y;
  table[3 * row + 2] = a.z;
}

// -- the normals of Max
// ---------------------------------------------------------------------------------

Array<double> weighted_normals(std::span<const double> vertices, std::span<const Index> faces) {
  const Index n = count(vertices) / 3;
  Array<double> normals(3 * n, 0.0), sizes(n, 0.0);
  const auto each = [&](auto take) {
    for (Index f = 0; f < count(faces); f += 3)
      for (int c = 0; c < 3; ++c) {
        const Vector3 here = at(vertices, faces[f + c]);
        const Vector3 u = at(vertices, faces[f + (c + 1) % 3]) - here;
        const Vector3 v = at(vertices, faces[f + (c + 2) % 3]) - here;
        // In two steps: squares of squares of short lengths are 0.
        const double uu = dot(u, u), vv = dot(v, v);
        if (uu > 0 && vv > 0) take(faces[f + c], scaled(scaled(cross(u, v), 1 / uu), 1 / vv));
      }
  };
  each([&](Index v, const Vector3& normal) {
    put(normals, v, sum(at(normals, v), normal));
    sizes[v] += length(normal);
  });
  Array<bool> cancel(n, false);
  bool any = false;
  for (Index v = 0; v < n; ++v) {
    const Vector3 normal = at(normals, v);
    cancel[v] = sizes[v] > 0 && !(length(normal) > kCancelled * sizes[v]);
    any |= cancel[v];
    put(normals, v, unit(normal, {0, 0, 1}));
  }
  if (any)
    each([&](Index v, const Vector3& normal) {
      if (!cancel[v] || !(length(normal) > 0)) return;
      put(normals, v, unit(normal, {0, 0, 1}));
      cancel[v] = false;
    });
  return normals;
}

// -- neighbours
// ---------------------------------------------------------------------------------

// The vertices of the faces about each vertex, and those of the faces about these.
class Rings {
 public:
  Rings(std::span<const Index> faces, Index n)
      : starts_(n + 1, 0), met_at_(n, kNone), is_inside_(n, false) {
    std::vector<Index> begins(n + 1, 0), corners(faces.size());
    for (const Index v : faces) ++begins[v + 1];
    for (Index v = 0; v < n; ++v) begins[v + 1] += begins[v];
    std::vector<Index> ends(begins.begin(), begins.end() - 1);
    for (Index corner = 0; corner < count(faces); ++corner) corners[ends[faces[corner]]++] = corner;
    near_.reserve(2 * faces.size());
    for (Index v = 0; v < n; ++v) {
      met_at_[v] = static_cast<Row>(v);
      for (Index place = begins[v]; place < begins[v + 1]; ++place) {
        const Index first = corners[place] / 3 * 3;
        for (int c = 0; c < 3; ++c) meet(static_cast<Row>(faces[first + c]), v, near_);
      }
      starts_[v + 1] = static_cast<Index>(near_.size());
      is_inside_[v] = size(v) <= begins[v + 1] - begins[v];  // as many edges as faces
    }
    std::ranges::fill(met_at_, kNone);
  }

  // The vertices of both rings of a vertex; none on the boundary, where slopes are extrapolated,
  // and where too many edges meet.
  std::span<const Row> of(Index v) {
    both_.clear();
    if (!is_inside_[v] || size(v) > kMostNeighbours) return both_;
    met_at_[v] = static_cast<Row>(v);
    for (Index k = starts_[v]; k < starts_[v + 1]; ++k) meet(near_[k], v, both_);
    for (Index k = starts_[v]; k < starts_[v + 1]; ++k) {
      const Row near = near_[k];
      if (size(near) > kMostNeighbours) continue;
      for (Index j = starts_[near]; j < starts_[near + 1]; ++j) meet(near_[j], v, both_);
    }
    return both_;
  }

 private:
  Index size(Index v) const { return starts_[v + 1] - starts_[v]; }
  void meet(Row other, Index v, std::vector<Row>& into) {
    if (met_at_[other] == v) return;
    met_at_[other] = static_cast<Row>(v);
    into.push_back(other);
  }

  Array<Index> starts_;
  Array<Row> met_at_;  // the vertex in whose rings each one was met last
  Array<bool> is_inside_;
  std::vector<Row> near_, both_;
};

// -- fits
// ---------------------------------------------------------------------------------

// Heights above a plane through a vertex as a polynomial of third degree, by least squares.
//
// Rows have the weight 1 / r^2. In terms of r^2, the squared distance in space, heights of a sphere
// are one term, and a fit on a sphere is exact. Terms but the slope are eliminated one by one.
class HeightFit {
 public:
  // The slope along the axes x and y as far as it is certain.
  Vector3 slope(std::span<const Vector3> steps, const Vector3& x, const Vector3& y,
                const Vector3& normal) {
    rows_.clear();
    for (const Vector3& step : steps) add(step, x, y, normal);
    const Index n_spare = static_cast<Index>(rows_.size()) - eliminate() - 2;
    if (n_spare < kSpareHeights) return {0, 0, 0};
    const Plane plane = fitted_plane();
    if (!(plane.determinant > kDependent * plane.xx * plane.yy)) return {0, 0, 0};
    const double squared = plane.a * plane.a + plane.b * plane.b;
    const double variance = variance_of(plane, n_spare) + kRounding * kRounding;
    if (!(squared > kNoise * variance && squared < kMostSlope * kMostSlope)) return {0, 0, 0};
    const double share = std::min((squared / variance - kNoise) / (kClear - kNoise), 1.0);
    return sum(scaled(x, share * plane.a), scaled(y, share * plane.b));
  }

 private:
  static constexpr int kTerms = 7, kX = 7, kY = 8, kZ = 9, kWeight = 10;
  using Terms = std::array<double, 11>;

  void add(const Vector3& step, const Vector3& x, const Vector3& y, const Vector3& normal) {
    const double u = dot(step, x), v = dot(step, y), rr = dot(step, step), weight = 1 / rr;
    rows_.push_back({1.0, (u * u - v * v) * weight, u * v * weight, u, v,
                     u * (u * u - 3 * v * v) * weight, v * (3 * u * u - v * v) * weight, u * weight,
                     v * weight, dot(step, normal) * weight, weight});
  }

  // Heights a x + b y by least squares, and the sums of squares that give a and b.
  struct Plane {
    double xx = 0, xy = 0, yy = 0, determinant = 0, a = 0, b = 0;
  };

  Plane fitted_plane() const {
    Plane its;
    double xz = 0, yz = 0;
    for (const Terms& row : rows_) {
      its.xx += row[kX] * row[kX];
      its.xy += row[kX] * row[kY];
      its.yy += row[kY] * row[kY];
      xz += row[kX] * row[kZ];
      yz += row[kY] * row[kZ];
    }
    its.determinant = its.xx * its.yy - its.xy * its.xy;
    its.a = (its.yy * xz - its.xy * yz) / its.determinant;
    its.b = (its.xx * yz - its.xy * xz) / its.determinant;
    return its;
  }

  // The variance of a slope, by residuals of heights, all of which are taken to be as uncertain.
  double variance_of(const Plane& its, Index n_spare) const {
    double residual = 0, squares = 0;
    for (const Terms& row : rows_) {
      const double height = (row[kZ] - its.a * row[kX] - its.b * row[kY]) / row[kWeight];
      const double of_a = (its.yy * row[kX] - its.xy * row[kY]) * row[kWeight];
      const double of_b = (its.xx * row[kY] - its.xy * row[kX]) * row[kWeight];
      residual += height * height;
      squares += of_a * of_a + of_b * of_b;
    }
    return residual / static_cast<double>(n_spare) * squares / (its.determinant * its.determinant);
  }

  // Take the part along each term from all columns behind; return the number of terms.
  Index eliminate() {
    Index n_terms = 0;
    std::array<double, kTerms> whole{};
    for (const Terms& row : rows_)
      for (int k = 0; k < kTerms; ++k) whole[k] += row[k] * row[k];
    for (int k = 0; k < kTerms; ++k) {
      std::array<double, kWeight> along{};
      for (const Terms& row : rows_)
        for (int j = 0; j < kWeight; ++j) along[j] += row[k] * row[j];
      const double own = along[k];
      if (!(own > kDependent * kDependent * whole[k])) continue;
      ++n_terms;
      for (double& part : along) part /= own;
      for (Terms& row : rows_) {
        const double here = row[k];
        for (int j = 0; j < kWeight; ++j) row[j] -= along[j] * here;
      }
    }
    return n_terms;
  }

  std::vector<Terms> rows_;
};

}  // namespace

Array<double> vertex_normals(std::span<const double> vertices, std::span<const Index> faces) {
  Array<double> normals = weighted_normals(vertices, faces);
  const Array<double> axes = tangent_axes(normals);
  Rings rings(faces, count(vertices) / 3);
  HeightFit fit;
  std::vector<Vector3> steps;
  for (Index v = 0; v < count(vertices) / 3; ++v) {
    steps.clear();
    double longest = 0;  // so that squares of lengths are numbers, in whatever unit
    for (const Row near : rings.of(v)) {
      const Vector3 step = steps.emplace_back(at(vertices, near) - at(vertices, v));
      longest = std::max({longest, std::abs(step.x), std::abs(step.y), std::abs(step.z)});
    }
    if (!(longest > 0)) continue;
    for (Vector3& step : steps) step = scaled(step, 1 / longest);
    std::erase_if(steps, [](const Vector3& step) { return length(step) < kSamePlace; });
    const Vector3 normal = at(normals, v), x = at(axes, v);
    put(normals, v, unit(normal - fit.slope(steps, x, cross(normal, x), normal), normal));
  }
  return normals;
}

}  // namespace geodesic
