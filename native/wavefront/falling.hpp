// The order in which a front comes to vertices, as heat tells it.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Heat of several sources, by columns of a table: u, or its logarithm.
struct HeatTable {
  std::span<const double> values;
  Index n_columns;
  bool logarithmic;

  Index n_rows() const { return n_columns ? count(values) / n_columns : 0; }
  // Whether a value is that of a vertex to which heat comes.
  bool is_heat(double value) const {
    return value > (logarithmic ? -kMost : 0.0) && value <= kMost;
  }
  bool reaches(Index row, Index column) const { return is_heat(values[row * n_columns + column]); }

  static constexpr double kMost = 0x1.fffffffffffffp1023;
};

// The order in which each of the columns [begin, end) falls as far as six digits of u tell, and
// then by number; one after the other. Rows to which no heat comes are the last.
Array<Row> falling(const HeatTable& heat, Index begin, Index end);

}  // namespace geodesic
