#include <cmath>
#include <limits>

#include "matrix/checks.hpp"

namespace geodesic {
namespace {

// Part of a row's absolute sum from which on L 1 or L - L' is not 0.
constexpr double kMaxRelativeRowSum = 1e-8;
constexpr double kGoldenRatio =
    0.6180339887498949;  // its multiples, without whole parts, are as random

}  // namespace

// True if a matrix is finite, symmetric, kills constants and has no negative diagonal. Symmetry is
// checked on one vector without a pattern, which L and L' take to the same.
bool is_sound(const MatrixView& matrix) {
  const Index n = matrix.size();
  const auto probe = [](Index v) {
    const double multiple = static_cast<double>(v) * kGoldenRatio;
    return multiple - std::floor(multiple);
  };
  Array<double> skew(n, 0.0), scale(n, 0.0);
  for (Index v = 0; v < n; ++v) {
    const double at_v = probe(v);
    double total = 0.0;
    for (Row entry = matrix.indptr[v]; entry < matrix.indptr[v + 1]; ++entry) {
      const Row head = matrix.indices[entry];
      const double value = matrix.data[entry];
      if (head == v && value < 0) return false;
      total += value;
      scale[v] += std::abs(value);
      skew[v] += value * probe(head);
      skew[head] -= value * at_v;
    }
    const double limit = kMaxRelativeRowSum * scale[v];
    if (!(std::abs(total) <= limit && limit < std::numeric_limits<double>::infinity()))
      return false;
  }
  for (Index v = 0; v < n; ++v)
    if (!(std::abs(skew[v]) <= kMaxRelativeRowSum * scale[v])) return false;
  return true;
}

}  // namespace geodesic
