#include "wavefront/falling.hpp"

#include <bit>

namespace geodesic {
namespace {

using Key = std::uint64_t;

constexpr int kMaxBitsOfDigit =
    12;  // of a digit by which keys are sorted in a pass: a table stays in L1

// Bits of a number that are not looked at: of u those behind 2^-22 of it, and of its logarithm, of
// up to 2^10, those behind 2^-22. A front comes from one to the other in a millionth of an edge.
constexpr int kIgnoredBitsOfHeat = 30, kIgnoredBitsOfLogarithm = 20;

// An integer that rises as a number falls.
Key falling_key(double value) {
  const Key bits = std::bit_cast<Key>(value);
  return bits >> 63 ? bits : ~bits & ~(Key{1} << 63);
}

// The least and the largest key of numbers.
struct Range {
  Key least = ~Key{0}, most = 0;
  void add(Key key) {
    least = std::min(least, key);
    most = std::max(most, key);
  }
};

// Sort keys by their bits [first, end), from the last digit to the first.
void sort(std::span<Key> keys, int first, int end, Array<Key>& workspace) {
  const int n_digits = (end - first + kMaxBitsOfDigit - 1) / kMaxBitsOfDigit;
  if (n_digits <= 0) return;
  const int bits = (end - first + n_digits - 1) / n_digits;
  const Index size = Index{1} << bits;
  Array<Row> free(n_digits * size, 0);
  for (const Key key : keys)
    for (int digit = 0; digit < n_digits; ++digit)
      ++free[digit * size + (key >> (first + digit * bits) & (size - 1))];
  std::span<Key> from = keys, to = std::span<Key>(workspace).first(keys.size());
  for (int digit = 0; digit < n_digits; ++digit) {
    Row* const place = free.data() + digit * size;
    Row sum = 0;
    for (Index value = 0; value < size; ++value) sum += std::exchange(place[value], sum);
    const int shift = first + digit * bits;
    for (const Key key : from) to[place[key >> shift & (size - 1)]++] = key;
    std::swap(from, to);
  }
  if (from.data() != keys.data()) std::ranges::copy(from, keys.begin());
}

}  // namespace

// Numbers of rows are written into the last bits of the keys, so that these can be sorted as they
// are.
Array<Row> falling(const HeatTable& heat, Index begin, Index end) {
  const Index n = heat.n_rows(), n_columns = end - begin;
  const int number_bits = std::bit_width(static_cast<Key>(std::max<Index>(n - 1, 1)));
  const int rest =
      std::max(heat.logarithmic ? kIgnoredBitsOfLogarithm : kIgnoredBitsOfHeat, number_bits);
  const Key number = (Key{1} << number_bits) - 1, one = Key{1} << rest;
  Array<Range> ranges(n_columns, Range{});
  for (Index row = 0; row < n; ++row) {
    const double* const values = heat.values.data() + row * heat.n_columns + begin;
    for (Index c = 0; c < n_columns; ++c)
      if (heat.is_heat(values[c])) ranges[c].add(falling_key(values[c]));
  }
  for (Range& range : ranges) {
    range.least &= ~(one - 1);
    range.most = range.most < range.least ? one : range.most - range.least + one;
  }
  Array<Key> keys(n_columns * n), workspace(n);
  for (Index row = 0; row < n; ++row) {
    const double* const values = heat.values.data() + row * heat.n_columns + begin;
    for (Index c = 0; c < n_columns; ++c) {
      const auto [least, most] = ranges[c];
      const Key key = heat.is_heat(values[c]) ? falling_key(values[c]) - least : most;
      keys[c * n + row] = (key & ~(one - 1)) | static_cast<Key>(row);
    }
  }
  Array<Row> order(n_columns * n);
  for (Index c = 0; c < n_columns; ++c) {
    const std::span<Key> own(keys.data() + c * n, static_cast<std::size_t>(n));
    sort(own, rest, std::bit_width(ranges[c].most), workspace);
    for (Index rank = 0; rank < n; ++rank)
      order[c * n + rank] = static_cast<Row>(own[rank] & number);
  }
  return order;
}

}  // namespace geodesic
