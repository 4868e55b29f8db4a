#include "wavefront/falling.hpp"

#include <bit>

namespace geodesic {
namespace {

using Key = FallingKeys::Key;

constexpr std::size_t at(Index i) { return static_cast<std::size_t>(i); }

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
FallingKeys::FallingKeys(const HeatTable& heat, Index begin, Index end)
    : n_rows(heat.n_rows()),
      keys((end - begin) * n_rows),
      mosts(end - begin),
      are_heat(end - begin, true) {
  const Index n_columns = end - begin;
  const int number_bits = std::bit_width(static_cast<Key>(std::max<Index>(n_rows - 1, 1)));
  rest = std::max(heat.logarithmic ? kIgnoredBitsOfLogarithm : kIgnoredBitsOfHeat, number_bits);
  number = (Key{1} << number_bits) - 1;
  const Key one = Key{1} << rest;
  Array<Range> ranges(n_columns, Range{});
  for (Index row = 0; row < n_rows; ++row) {
    const double* const values = heat.values.data() + row * heat.n_columns + begin;
    for (Index c = 0; c < n_columns; ++c)
      if (heat.is_heat(values[c]))
        ranges[c].add(falling_key(values[c]));
      else
        are_heat[c] = false;
  }
  for (Index c = 0; c < n_columns; ++c) {
    Range& range = ranges[c];
    range.least &= ~(one - 1);
    range.most = range.most < range.least ? one : range.most - range.least + one;
    mosts[c] = range.most;
  }
  for (Index row = 0; row < n_rows; ++row) {
    const double* const values = heat.values.data() + row * heat.n_columns + begin;
    for (Index c = 0; c < n_columns; ++c) {
      const auto [least, most] = ranges[c];
      const Key key = heat.is_heat(values[c]) ? falling_key(values[c]) - least : most;
      keys[c * n_rows + row] = (key & ~(one - 1)) | static_cast<Key>(row);
    }
  }
}

Array<Row> falling(const HeatTable& heat, Index begin, Index end) {
  FallingKeys keys(heat, begin, end);
  const Index n = keys.n_rows, n_columns = end - begin;
  Array<Key> workspace(n);
  Array<Row> order(n_columns * n);
  for (Index c = 0; c < n_columns; ++c) {
    const std::span<Key> own = keys.column(c);
    sort(own, keys.rest, std::bit_width(keys.mosts[c]), workspace);
    for (Index rank = 0; rank < n; ++rank)
      order[c * n + rank] = static_cast<Row>(own[at(rank)] & keys.number);
  }
  return order;
}

void FallingSlices::begin(std::span<const Key> column, Key most, Key number) {
  column_ = column, number_ = number, next_ = 0;
  shift_ = std::max(static_cast<int>(std::bit_width(most)) - kBitsOfBucket, 0);
  sizes_.assign(at(bucket(most | number) + 1), 0);
  order_.clear();
  for (const Key key : column) ++sizes_[at(bucket(key))];
}

void FallingSlices::add(Index size) {
  const Index first = next_;
  Index found = 0;
  while (next_ < static_cast<Index>(sizes_.size()) && found < size) found += sizes_[at(next_++)];
  if (next_ == first) return;
  const Key low = static_cast<Key>(first) << shift_;
  const Key span = (static_cast<Key>(next_ - first) << shift_) - 1;  // 2^64 - 1 at most
  slice_.clear();
  for (const Key key : column_)
    if (key - low <= span) slice_.push_back(key);
  std::ranges::sort(slice_);
  for (const Key key : slice_) order_.push_back(static_cast<Row>(key & number_));
}

}  // namespace geodesic
