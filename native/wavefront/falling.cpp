#include "wavefront/falling.hpp"

#include <bit>

namespace geodesic {
namespace {

using Key = std::uint64_t;

constexpr int kDigit = 11;  // bits by which keys are sorted in a pass
constexpr Index kDigits = Index{1} << kDigit;

// Sort keys by what is left of their last `skipped` bits: from the last digit to the first.
void sort(Array<Key>& keys, int skipped) {
  Key all = 0, common = ~Key{0};
  for (const Key key : keys) {
    all |= key;
    common &= key;
  }
  const int used = std::bit_width(all ^ common);  // of the bits before these all are the same
  Array<Key> sorted(keys.size());
  for (int shift = skipped; shift < used; shift += kDigit) {
    Array<Row> free(kDigits, 0);
    for (const Key key : keys) ++free[(key >> shift) & (kDigits - 1)];
    Row sum = 0;
    for (Row& place : free) sum += std::exchange(place, sum);
    for (const Key key : keys) sorted[free[(key >> shift) & (kDigits - 1)]++] = key;
    std::swap(keys, sorted);
  }
}

}  // namespace

// Numbers are written into the last bits of the values, so that these can be sorted as they are.
Array<Row> falling(std::span<const double> values) {
  const Index n = count(values);
  const int bits = std::bit_width(static_cast<Key>(std::max<Index>(n - 1, 1)));
  const Key number = (Key{1} << bits) - 1;
  Array<Key> keys(n);
  for (Index v = 0; v < n; ++v) {
    const Key value = std::bit_cast<Key>(-values[v]);
    // As integers, negative values are the wrong way, and behind the others.
    const Key rising = value ^ (value >> 63 ? ~Key{0} : Key{1} << 63);
    keys[v] = (rising & ~number) | static_cast<Key>(v);
  }
  sort(keys, bits);
  Array<Row> order(n);
  for (Index v = 0; v < n; ++v) order[v] = static_cast<Row>(keys[v] & number);
  return order;
}

}  // namespace geodesic
