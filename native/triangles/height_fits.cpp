#include "triangles/height_fits.hpp"

namespace geodesic {
namespace {

// Least number of heights above the number of coefficients, for residuals that say something. The
// same creases keep their normals for 3 and 5; with 5, those at more vertices of triangulations of
// random points have no fit: ellipsoids have twice the tilt.
constexpr double kSpareHeights = 3;

// Squared length, as a share of that of the longest step, below which a neighbour is at the place
// of the vertex.
constexpr double kSamePlace = 1e-18;

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

}  // namespace

void HeightFits::add(const Plane& plane, std::span<const double> vertices, Index v,
                     std::span<const Row> near) {
  planes_[used_] = plane;
  const Vector3 here = at(vertices, v);
  n_rows_ = std::max(n_rows_, count(near));
  if (steps_.size() < static_cast<std::size_t>(3 * kAtOnce * n_rows_))
    steps_.resize(static_cast<std::size_t>(3 * kAtOnce * n_rows_));
  double* to = steps_.data() + used_;
  for (const Row other : near) {
    const Vector3 step = at(vertices, other) - here;
    to[0] = step.x;
    to[kAtOnce] = step.y;
    to[2 * kAtOnce] = step.z;
    to += 3 * kAtOnce;
  }
  n_near_[used_++] = count(near);
}

HeightFits::Slopes HeightFits::fit() {
  const Lanes n_rows = write_terms();
  Normal normal = products();
  Lanes inverse[kTerms];
  const Lanes n_spare = n_rows - eliminate(normal, inverse) - Lanes::spread(2);
  Fit its{normal.of[kX][kX], normal.of[kX][kY], normal.of[kY][kY], {}, {}, {}};
  const Lanes xz = normal.of[kX][kZ], yz = normal.of[kY][kZ];
  its.determinant = its.xx * its.yy - its.xy * its.xy;
  its.a = (its.yy * xz - its.xy * yz) / its.determinant;
  its.b = (its.xx * yz - its.xy * xz) / its.determinant;
  const Lanes squared = its.a * its.a + its.b * its.b;
  const Lanes variance =
      variance_of(its, normal, inverse, n_spare) + Lanes::spread(kRounding * kRounding);
  const Lanes none = Lanes::zeros(), one = Lanes::spread(1), noise = Lanes::spread(kNoise);
  Lanes share = (squared / variance - noise) / (Lanes::spread(kClear) - noise);
  share = choose(share, one, share, one);
  // Where a comparison is one with NaN, too, the slope is not known.
  share = choose(Lanes::spread(kSpareHeights - 0.5), n_spare, share, none);
  share = choose(Lanes::spread(kDependent) * its.xx * its.yy, its.determinant, share, none);
  share = choose(noise * variance, squared, share, none);
  share = choose(squared, Lanes::spread(kMostSlope * kMostSlope), share, none);
  const Lanes a = choose(none, share, share * its.a, none);
  const Lanes b = choose(none, share, share * its.b, none);
  Slopes result;
  for (int lane = 0; lane < used_; ++lane)
    result.of[lane] = sum(scaled(planes_[lane].x, a[lane]), scaled(planes_[lane].y, b[lane]));
  used_ = n_rows_ = 0;
  return result;
}

// The longest coordinate of the steps of each lane, so that squares of lengths are numbers, in
// whatever unit; 1 where all are zero.
HeightFits::Lanes HeightFits::longest() const {
  Lanes most = Lanes::zeros();
  for (Index k = 0; k < 3 * n_rows_; ++k) {
    const Lanes along = size(Lanes::load(&steps_[static_cast<std::size_t>(kAtOnce * k)]));
    most = choose(most, along, along, most);
  }
  return choose(Lanes::zeros(), most, most, Lanes::spread(1));
}

// Return how many neighbours each lane has.
HeightFits::Lanes HeightFits::write_terms() {
  for (int lane = 0; lane < kAtOnce; ++lane)
    for (Index k = 3 * (lane < used_ ? n_near_[lane] : 0); k < 3 * n_rows_; ++k)
      steps_[static_cast<std::size_t>(kAtOnce * k + lane)] = 0.0;
  if (static_cast<Index>(rows_.size()) < n_rows_) rows_.resize(static_cast<std::size_t>(n_rows_));
  const auto from = [&](auto part) {
    return Lanes::of([&](int lane) { return lane < used_ ? part(planes_[lane]) : 0.0; });
  };
  const Lanes scale = Lanes::spread(1) / longest(), none = Lanes::zeros();
  const Lanes x[3] = {from([](const Plane& its) { return its.x.x; }) * scale,
                      from([](const Plane& its) { return its.x.y; }) * scale,
                      from([](const Plane& its) { return its.x.z; }) * scale};
  const Lanes y[3] = {from([](const Plane& its) { return its.y.x; }) * scale,
                      from([](const Plane& its) { return its.y.y; }) * scale,
                      from([](const Plane& its) { return its.y.z; }) * scale};
  const Lanes z[3] = {from([](const Plane& its) { return its.normal.x; }) * scale,
                      from([](const Plane& its) { return its.normal.y; }) * scale,
                      from([](const Plane& its) { return its.normal.z; }) * scale};
  Lanes n_rows = none;
  for (Index k = 0; k < n_rows_; ++k) {
    const double* const step = &steps_[static_cast<std::size_t>(3 * kAtOnce * k)];
    const Lanes p = Lanes::load(step), q = Lanes::load(step + kAtOnce),
                r = Lanes::load(step + 2 * kAtOnce);
    const auto along = [&](const Lanes(&axis)[3]) {
      return p * axis[0] + q * axis[1] + r * axis[2];
    };
    const Lanes u = along(x), v = along(y), height = along(z);
    const Lanes rr =
        (p * scale) * (p * scale) + (q * scale) * (q * scale) + (r * scale) * (r * scale);
    const Lanes limit = Lanes::spread(kSamePlace), one = Lanes::spread(1);
    const Lanes is_there = choose(limit, rr, one, none);
    const Lanes weight = choose(limit, rr, one / rr, none), uu = u * u, vv = v * v;
    const Lanes three = Lanes::spread(3), of_u = u * weight, of_v = v * weight;
    n_rows = n_rows + is_there;
    rows_[static_cast<std::size_t>(k)] = {
        {is_there, (uu - vv) * weight, u * of_v, u * is_there, v * is_there,
         of_u * (uu - three * vv), of_v * (three * uu - vv), of_u, of_v, height * weight},
        weight,
        rr};
  }
  return n_rows;
}

// Sums of products of some columns with others, which stay in registers: all of them, as compilers
// keep those of a triangle in memory.
template <int kFirst, int kLast, int kBegin, int kEnd>
void HeightFits::add_products(Normal& normal) const {
  Lanes sums[kLast - kFirst][kEnd - kBegin];
  for (int i = kFirst; i < kLast; ++i)
    for (int j = kBegin; j < kEnd; ++j) sums[i - kFirst][j - kBegin] = Lanes::zeros();
  for (Index k = 0; k < n_rows_; ++k) {
    const Lanes* const row = rows_[static_cast<std::size_t>(k)].of;
    for (int i = kFirst; i < kLast; ++i)
      for (int j = kBegin; j < kEnd; ++j)
        sums[i - kFirst][j - kBegin] = sums[i - kFirst][j - kBegin] + row[i] * row[j];
  }
  for (int i = kFirst; i < kLast; ++i)
    for (int j = kBegin; j < kEnd; ++j) normal.of[i][j] = sums[i - kFirst][j - kBegin];
}

HeightFits::Normal HeightFits::products() const {
  Normal normal;
  add_products<0, 5, 0, 5>(normal);
  add_products<0, 5, 5, 10>(normal);
  add_products<5, 10, 5, 10>(normal);
  return normal;
}

// Take the part along each term from all columns behind; return the number of terms. The inverses
// of the diagonal are 0 for terms that are left out.
HeightFits::Lanes HeightFits::eliminate(Normal& normal, Lanes (&inverse)[kTerms]) {
  const Lanes none = Lanes::zeros(), one = Lanes::spread(1);
  Lanes n_terms = none, least[kTerms];
  for (int k = 0; k < kTerms; ++k)
    least[k] = Lanes::spread(kDependent * kDependent) * normal.of[k][k];
  for (int k = 0; k < kTerms; ++k) {
    const Lanes own = normal.of[k][k];
    inverse[k] = choose(least[k], own, one / own, none);
    n_terms = n_terms + choose(least[k], own, one, none);
    for (int i = k + 1; i < kZ; ++i) {
      const Lanes share = normal.of[k][i] * inverse[k];
      for (int j = i; j < kColumns; ++j)
        normal.of[i][j] = normal.of[i][j] - share * normal.of[k][j];
    }
  }
  return n_terms;
}

// The variance of a slope, by residuals of heights, all of which are taken to be as uncertain.
HeightFits::Lanes HeightFits::variance_of(const Fit& its, const Normal& normal,
                                          const Lanes (&inverse)[kTerms],
                                          const Lanes& n_spare) const {
  Lanes of_height[kTerms], of_a[kTerms], of_b[kTerms];  // coefficients of the terms
  for (int k = kTerms - 1; k >= 0; --k) {
    const Lanes* const own = normal.of[k];
    Lanes height = own[kZ] - its.a * own[kX] - its.b * own[kY];
    Lanes a = its.yy * own[kX] - its.xy * own[kY], b = its.xx * own[kY] - its.xy * own[kX];
    for (int m = k + 1; m < kTerms; ++m) {
      height = height - own[m] * of_height[m];
      a = a - own[m] * of_a[m];
      b = b - own[m] * of_b[m];
    }
    of_height[k] = height * inverse[k];
    of_a[k] = a * inverse[k];
    of_b[k] = b * inverse[k];
  }
  Lanes residual = Lanes::zeros(), squares = residual;
  for (Index row = 0; row < n_rows_; ++row) {
    const Terms& terms = rows_[static_cast<std::size_t>(row)];
    const Lanes x = terms.of[kX], y = terms.of[kY];
    Lanes height = terms.of[kZ] - its.a * x - its.b * y;
    Lanes a = its.yy * x - its.xy * y, b = its.xx * y - its.xy * x;
    for (int k = 0; k < kTerms; ++k) {
      height = height - of_height[k] * terms.of[k];
      a = a - of_a[k] * terms.of[k];
      b = b - of_b[k] * terms.of[k];
    }
    height = height * terms.square;
    a = a * terms.weight;
    b = b * terms.weight;
    residual = residual + height * height;
    squares = squares + a * a + b * b;
  }
  return residual / n_spare * squares / (its.determinant * its.determinant);
}

}  // namespace geodesic
