// The order in which a front reaches vertices, from the heat.
#pragma once

#include <vector>

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

// Integers that rise as the heat of a column falls, to six digits of u, and then by row.
struct FallingKeys {
  using Key = std::uint64_t;

  FallingKeys(const HeatTable& heat, Index begin, Index end);

  std::span<Key> column(Index c) {
    return {keys.data() + c * n_rows, static_cast<std::size_t>(n_rows)};
  }

  Index n_rows;
  int rest;                // the bits, from the lowest, that do not count
  Key number;              // the bits of the row
  Array<Key> keys, mosts;  // of each column; the largest key of it, that of rows without heat
  Array<bool> are_heat;    // whether heat reaches all rows of a column
};

// The same order of one column, slice by slice, for those who need only its beginning.
class FallingSlices {
 public:
  // Begin with a column, which stays as it is.
  void begin(std::span<const FallingKeys::Key> column, FallingKeys::Key most,
             FallingKeys::Key number);

  // Add so many rows of those that follow to the order, or a few more, or all that are left.
  void add(Index size);

  std::span<const Row> order() const { return order_; }
  bool is_whole() const { return order_.size() == column_.size(); }

 private:
  static constexpr int kBitsOfBucket = 10;

  Index bucket(FallingKeys::Key key) const { return static_cast<Index>(key >> shift_); }

  std::span<const FallingKeys::Key> column_;
  FallingKeys::Key number_ = 0;
  int shift_ = 0;
  Index next_ = 0;  // the first bucket whose rows are not in the order
  std::vector<Row> sizes_, order_;
  std::vector<FallingKeys::Key> slice_;
};

}  // namespace geodesic
