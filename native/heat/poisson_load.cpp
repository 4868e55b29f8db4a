#include "heat/poisson_load.hpp"

#include <bit>
#include <cmath>

namespace geodesic {
namespace {

constexpr double kLog2 = 0.693147180559945309417232121458;
constexpr double kMinHeatDifference = 1e-300;  // smaller differences of heat count as zero
// If heat differs by less than this share of itself over a triangle, its direction is rounding,
// which differs between solves of a block and of a single column. Rounding is 1e-16, and 1e-11
// where the logarithm of heat is -1e5; slopes are 1e-1, and 1e-5 with a million times the time
// step.
constexpr double kMinRelativeSlope = 1e-11;
constexpr Row kZeroExponent = -(1 << 30);  // power of two that stands for no heat at all,
constexpr Row kMaxExponent = 1 << 30;      // and the largest; their difference is still a Row
constexpr Index kTrianglesPerBlock =
    64;  // triangles whose differences stay in the first level of cache

// 2^n, n <= 0, and 0 where that is not a normal number.
double two_to(Row power) {
  const std::int64_t upper = std::max<std::int64_t>(std::int64_t{power} + 1023, 0);
  return std::bit_cast<double>(upper << 52);
}

// The terms of the first and the second difference of heat on a triangle in the load of its
// corners.
//
// With the inverse frame (p, q, r) the gradient is (p du, q du + r dv). Its direction does not
// change if the differences are divided by the larger one, and then nothing underflows.
inline void turn(double& du, double& dv, double p, double q, double r, double area) {
  const double scale = 1 / std::max(std::max(std::abs(du), std::abs(dv)), kMinHeatDifference);
  const double x = p * (du * scale), y = q * (du * scale) + r * (dv * scale);
  const double weight = -area / std::sqrt(std::max(x * x + y * y, kMinHeatDifference));
  du = weight * (p * x + q * y);
  dv = weight * (r * y);
}

// u as fractions * 2^powers, of log u: doubles of any range. Without heat the fraction is 0, and
// otherwise it is at least 1 and less than 2.
struct Split {
  Array<double> fractions;
  Array<Row> powers;

  explicit Split(std::span<const double> logarithms)
      : fractions(count(logarithms)), powers(count(logarithms)) {
    for (Index v = 0; v < fractions.size(); ++v) {
      const double power = logarithms[v] / kLog2;
      if (power <= kZeroExponent) {
        fractions[v] = 0.0;
        powers[v] = kZeroExponent;
      } else {  // NaN stays NaN
        const double whole = std::floor(power);
        fractions[v] = std::exp((power - whole) * kLog2);
        powers[v] = std::isnan(whole) ? kZeroExponent
                                      : static_cast<Row>(std::min<double>(whole, kMaxExponent));
      }
    }
  }
};

// Heat as it is, or times powers of two where there are any.
struct Heat {
  const double* values;
  const Row* powers;  // or null

  // Differences to the first corner at the places i, j, k of a table; 0 where they are rounding.
  void differences(Index i, Index j, Index k, double& du, double& dv) const {
    double origin = values[i];
    if (powers) {
      const Row top = std::max({powers[i], powers[j], powers[k]});
      origin *= two_to(powers[i] - top);
      du = values[j] * two_to(powers[j] - top) - origin;
      dv = values[k] * two_to(powers[k] - top) - origin;
    } else {
      du = values[j] - origin;
      dv = values[k] - origin;
    }
    const double least = kMinRelativeSlope * std::abs(origin);
    const double slope = std::max(std::abs(du), std::abs(dv)) > least ? 1.0 : 0.0;
    du *= slope;
    dv *= slope;
  }
};

// One column. Triangles a few at a time: divisions and roots are vectorised in a loop of their own,
// apart from vertices that triangles share.
void add_column(const Triangles& triangles, const Heat& heat, double* load) {
  const Index n_faces = count(triangles.measure);
  double first[kTrianglesPerBlock], second[kTrianglesPerBlock];
  for (Index begin = 0; begin < n_faces; begin += kTrianglesPerBlock) {
    const Index together = std::min(kTrianglesPerBlock, n_faces - begin);
    const Index* const corner = triangles.faces.data() + 3 * begin;
    const double* const frame = triangles.frames.data() + 3 * begin;
    for (Index c = 0; c < together; ++c)
      heat.differences(corner[3 * c], corner[3 * c + 1], corner[3 * c + 2], first[c], second[c]);
    for (Index c = 0; c < together; ++c)
      turn(first[c], second[c], frame[3 * c], frame[3 * c + 1], frame[3 * c + 2],
           triangles.measure[begin + c]);
    for (Index c = 0; c < together; ++c) {
      load[corner[3 * c]] -= first[c] + second[c];
      load[corner[3 * c + 1]] += first[c];
      load[corner[3 * c + 2]] += second[c];
    }
  }
}

// N columns of a table of rows `stride` apart, on one triangle.
template <int N>
void add_columns(const Triangles& triangles, Index f, const Heat& heat, double* loads,
                 Index stride) {
  const Index* const corner = triangles.faces.data() + 3 * f;
  const double* const frame = triangles.frames.data() + 3 * f;
  const Index i = corner[0] * stride, j = corner[1] * stride, k = corner[2] * stride;
  double first[N], second[N];
  for (int c = 0; c < N; ++c) heat.differences(i + c, j + c, k + c, first[c], second[c]);
  for (int c = 0; c < N; ++c)
    turn(first[c], second[c], frame[0], frame[1], frame[2], triangles.measure[f]);
  for (int c = 0; c < N; ++c) loads[i + c] -= first[c] + second[c];
  for (int c = 0; c < N; ++c) loads[j + c] += first[c];
  for (int c = 0; c < N; ++c) loads[k + c] += second[c];
}

void add_table(const Triangles& triangles, const Heat& heat, double* loads, Index n_columns) {
  for (Index f = 0; f < count(triangles.measure); ++f) {
    Index c = 0;
    const auto add = [&]<int N>() {
      const Heat rest{heat.values + c, heat.powers ? heat.powers + c : nullptr};
      add_columns<N>(triangles, f, rest, loads + c, n_columns);
      c += N;
    };
    while (c + 16 <= n_columns) add.template operator()<16>();
    while (c + 4 <= n_columns) add.template operator()<4>();
    while (c < n_columns) add.template operator()<1>();
  }
}

}  // namespace

Array<double> poisson_load(const Triangles& triangles, std::span<const double> heat,
                           Index n_columns, bool logarithmic) {
  Array<double> loads(count(heat), 0.0);
  const auto add = [&](const Heat& values) {
    if (n_columns == 1)
      add_column(triangles, values, loads.data());
    else
      add_table(triangles, values, loads.data(), n_columns);
  };
  if (logarithmic) {
    const Split split(heat);
    add({split.fractions.data(), split.powers.data()});
  } else {
    add({heat.data(), nullptr});
  }
  return loads;
}

}  // namespace geodesic
