#include "heat/connection.hpp"

#include <algorithm>
#include <cmath>

#include "core/processor.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 6;  // elements, or entries of a pattern, of prefetch distance
constexpr Index kFarther = 16;          // entries, where little is done for each
constexpr Index kPrefetched = 8;        // entries of a row that are asked for: most have seven

// Entries of a row that are counted at once, without a branch that depends on what they are.
constexpr Index kAtOnce = 16;

// Where the entry (row, column) is, or -1.
Index place_of(const Pattern& pattern, Index row, Index column) {
  const Index begin = pattern.indptr[row], n = pattern.indptr[row + 1] - begin;
  const Row* const entries = pattern.indices.data() + begin;
  const Row wanted = static_cast<Row>(column);
  Index found = 0;
  if (n > kAtOnce || begin + kAtOnce > count(pattern.indices)) {
    found = std::lower_bound(entries, entries + n, wanted) - entries;
  } else {
    Row smaller = 0;
    for (Row k = 0; k < kAtOnce; ++k) smaller += (entries[k] < wanted) & (k < n);
    found = smaller;
  }
  return found < n && entries[found] == wanted ? begin + found : -1;
}

// Add to a complex number by conj(one) other, times a real one.
void add(double* sum, const double* one, const double* other, double by) {
  sum[0] += by * (one[0] * other[0] + one[1] * other[1]);
  sum[1] += by * (one[0] * other[1] - one[1] * other[0]);
}

// Fill in the entries left of the diagonal; return whether each has its mirror image. Rows visited
// in order meet those of each column in order.
bool mirror(const Pattern& pattern, const Array<Index>& diagonal, Array<double>& entries) {
  const Index n_entries = count(pattern.indices);
  Array<Index> place(pattern.size());
  for (Index v = 0; v < pattern.size(); ++v) place[v] = diagonal[v] + 1;
  for (Index row = 0; row < pattern.size(); ++row)
    for (Index k = pattern.indptr[row]; k < pattern.indptr[row + 1]; ++k) {
      if (pattern.indices[k] >= row) break;
      const Row column = pattern.indices[k];
      prefetch(&entries[2 * place[pattern.indices[std::min(k + kFarther, n_entries - 1)]]]);
      const Index other = place[column]++;
      if (other >= pattern.indptr[column + 1] || pattern.indices[other] != row) return false;
      entries[2 * k] = entries[2 * other];
      entries[2 * k + 1] = -entries[2 * other + 1];
    }
  for (Index v = 0; v < pattern.size(); ++v)
    if (place[v] != pattern.indptr[v + 1]) return false;
  return true;
}

}  // namespace

std::optional<Array<double>> connection_laplacian(const Pattern& pattern,
                                                  std::span<const Index> elements,
                                                  std::span<const double> frames,
                                                  std::span<const double> measure,
                                                  std::span<const double> turns) {
  Array<double> entries(2 * count(pattern.indices), 0.0);
  Array<Index> diagonal(pattern.size());
  for (Index v = 0; v < pattern.size(); ++v) {
    diagonal[v] = place_of(pattern, v, v);
    if (diagonal[v] < 0) return std::nullopt;
  }
  for (Index e = 0; e < count(measure); ++e) {
    for (const Index soon : elements.subspan(
             static_cast<std::size_t>(3 * std::min(e + kPrefetchDistance, count(measure) - 1)),
             3)) {
      const Row begin = pattern.indptr[soon];
      prefetch(pattern.indices.data() + begin);
      for (Index k = 0; k < kPrefetched; k += 4) prefetch(entries.data() + 2 * (begin + k));
    }
    const Index* const corner = elements.data() + 3 * e;
    const double p = frames[3 * e], q = frames[3 * e + 1], r = frames[3 * e + 2];
    const double gradient[3][2] = {{-p, -q - r}, {p, q}, {0.0, r}};
    const double* const own = turns.data() + 6 * e;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        const double product = gradient[i][0] * gradient[j][0] + gradient[i][1] * gradient[j][1];
        const bool is_upper = corner[i] <= corner[j];  // in half of all cases: no branch
        const Index low = is_upper ? corner[i] : corner[j], high = is_upper ? corner[j] : corner[i];
        const Index place = low == high ? diagonal[low] : place_of(pattern, low, high);
        if (place < 0) return std::nullopt;
        double sum[2] = {0, 0};
        add(sum, own + 2 * i, own + 2 * j, measure[e] * product);
        entries[2 * place] += low == high && i != j ? 2 * sum[0] : sum[0];
        entries[2 * place + 1] += low == high ? 0.0 : is_upper ? sum[1] : -sum[1];
      }
  }
  if (!mirror(pattern, diagonal, entries)) return std::nullopt;
  return entries;
}

Array<double> edge_turns(const Pattern& pattern, std::span<const Index> elements, int size,
                         std::span<const double> turns) {
  Array<double> sums(2 * count(pattern.indices), 0.0);
  for (Index first = 0; first < count(elements); first += size)
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j) {
        const Index place = place_of(pattern, elements[first + i], elements[first + j]);
        if (place >= 0)
          add(&sums[2 * place], &turns[2 * (first + i)], &turns[2 * (first + j)], 1.0);
      }
  return sums;
}

Matrix real_form(const Pattern& pattern, std::span<const double> entries,
                 std::span<const double> scale, std::span<const double> diagonal) {
  const Index n = pattern.size(), n_entries = count(pattern.indices);
  Matrix result{Array<Row>(2 * n + 1), Array<Row>(4 * n_entries), Array<double>(4 * n_entries)};
  Row place = 0;
  for (Index i = 0; i < n; ++i)
    for (int part = 0; part < 2; ++part) {
      result.indptr[2 * i + part] = place;
      for (Row k = pattern.indptr[i]; k < pattern.indptr[i + 1]; ++k) {
        const Row column = pattern.indices[k];
        const double more = column == i ? diagonal[i] : 0.0;
        const double real = scale[i] * entries[2 * k] + more;
        const double imaginary = column == i ? 0.0 : scale[i] * entries[2 * k + 1];
        result.indices[place] = 2 * column;
        result.data[place++] = part ? imaginary : real;
        result.indices[place] = 2 * column + 1;
        result.data[place++] = part ? real : -imaginary;
      }
    }
  result.indptr[2 * n] = place;
  return result;
}

// Squares of small numbers would be 0.
Polar polar_form(std::span<const double> pairs) {
  const Index n = count(pairs) / 2;
  Polar result{Array<double>(n), Array<double>(2 * n)};
  for (Index k = 0; k < n; ++k) {
    const double real = pairs[2 * k], imaginary = pairs[2 * k + 1];
    const double one = std::abs(real), other = std::abs(imaginary);
    const double most = one > other ? one : other, per_most = 1 / (most > 0 ? most : 1.0);
    const double x = real * per_most, y = imaginary * per_most;
    const double size = std::sqrt(x * x + y * y), per_size = 1 / (size > 0 ? size : 1.0);
    result.sizes[k] = most * size;
    result.directions[2 * k] = x * per_size;
    result.directions[2 * k + 1] = y * per_size;
  }
  return result;
}

}  // namespace geodesic
