// The order in which a front reaches vertices, from the heat.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Heat of several sources, by columns of a table: u, or its logarithm.
struct HeatTable {
  std::span<const double> values;
  Index n_columns;
  bool logarithmic;

  Index n_rows() const { return n_columns ? count(values) / n_columns : 0; }
  // True if a value is that of a vertex which heat reaches.
  bool is_heat(double value) const {
    return value > (logarithmic ? -kMost : 0.0) && value <= kMost;
  }
  bool reaches(Index row, Index column) const { return is_heat(values[row * n_columns + column]); }

  static constexpr double kMost = 0x1.fffffffffffffp1023;
};

// The order in which each of the columns [begin, end) decreases, to six digits of u, and then by
// row; one column after the other. Rows that heat does not reach are last.
Array<Row> falling(const HeatTable& heat, Index begin, Index end);

}  // namespace geodesic
