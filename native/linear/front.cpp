#include "linear/front.hpp"

#include <algorithm>
#include <cmath>

#include "core/vectors.hpp"

namespace geodesic::front {
namespace {

constexpr Index kAcross = 4;                // columns of a tile
constexpr int kVectors = 2;                 // registers of rows of a tile
constexpr Index kTall = kVectors * kLanes;  // rows of a tile
constexpr Index kChunk = 128;               // columns whose products are summed up at once
constexpr Index kSlab = 128;                // rows that stay in the second level of cache
constexpr Index kPacked = 320;  // rows from which on they are copied together before use

// Subtract products A B' from a tile of `width` columns at `target`, zero before where `fresh`.
//
// A[i, c] is a[c * step + i], B[j, c] is b[c * step + j], for `depth` columns c.
template <int N, class Rows>
GT_INLINE void subtract_tile(double* target, Index stride, const double* a, const double* b,
                             Index step, Index depth, Index width, bool fresh, Rows rows) {
  Register sums[kAcross][N];
  for (int k = 0; k < kAcross; ++k)
    for (int v = 0; v < N; ++v) sums[k][v] = Register::zeros();
  const Index places[kAcross] = {0, width > 1 ? 1 : 0, width > 2 ? 2 : 0, width > 3 ? 3 : 0};
  for (Index c = 0; c < depth; ++c, a += step, b += step) {
    Register values[N];
    for (int v = 0; v < N; ++v) values[v] = rows.load(a + v * kLanes);
    for (int k = 0; k < kAcross; ++k) {
      const Register factor = Register::spread(b[places[k]]);  // not past the end of B
      for (int v = 0; v < N; ++v) sums[k][v] = sums[k][v] + factor * values[v];
    }
  }
  for (int k = 0; k < kAcross; ++k) {
    if (k >= width) break;
    for (int v = 0; v < N; ++v) {
      double* const where = target + k * stride + v * kLanes;
      const Register before = fresh ? Register::zeros() : rows.load(where);
      rows.store(where, before - sums[k][v]);
    }
  }
}

// Copy columns, `height` apart, so that what a tile reads is in one piece: rows by kTall.
void pack(double* room, const double* source, Index height, Index n_rows, Index depth) {
  for (Index top = 0; top < n_rows; top += kTall) {
    const Index count = std::min(kTall, n_rows - top);
    for (Index c = 0; c < depth; ++c)
      std::copy_n(source + c * height + top, count, room + top * depth + c * kTall);
  }
}

// Subtract B B' from the lower triangle of the first columns of C, of zero where `fresh`.
//
// B has `depth` columns, `height` apart, C has `n_columns`, `stride` apart; both have `n_rows`.
// What lies above the diagonal of C is spoilt. Of C, columns from `from` to `to` only.
void subtract_products(double* target, Index stride, Index n_rows, Index from, Index to,
                       const double* source, Index height, Index depth, bool fresh, double* room) {
  Index step = height, scale = 1, beyond = kAcross - 1;
  if (n_rows > kPacked && to - from > kAcross) {
    pack(room, source, height, n_rows, depth);
    source = room;
    step = kTall;
    scale = depth;
    beyond = kTall - 1;
  }
  for (Index top = 0; top < n_rows; top += kSlab) {
    const Index bottom = std::min(top + kSlab, n_rows);
    for (Index j = from; j < std::min(to, bottom); j += kAcross) {
      const Index width = std::min(to - j, kAcross);
      const Index begin = j & ~beyond;  // of the piece that column j of B' is in; powers of two
      const double* const b = source + begin * scale + (j & beyond);
      Index i = std::max(top, begin);
      for (; i + kTall <= bottom; i += kTall)
        subtract_tile<kVectors>(target + j * stride + i, stride, source + i * scale, b, step, depth,
                                width, fresh, Whole{});
      const double* a = source + i * scale;
      for (; i < bottom; i += kLanes, a += kLanes)
        subtract_tile<1>(target + j * stride + i, stride, a, b, step, depth, width, fresh,
                         First(bottom - i));
    }
  }
}

// Eliminate K columns from c on; return the first one with a pivot <= 0, or kNone.
template <int K>
Index eliminate_columns(double* panel, Index height, Index c) {
  double* columns[K];
  for (int j = 0; j < K; ++j) columns[j] = panel + (c + j) * height + c;
  for (int j = 0; j < K; ++j) {
    for (int i = j; i < K; ++i) {
      double value = columns[j][i];
      for (int k = 0; k < j; ++k) value -= columns[k][i] * columns[k][j];
      if (i > j)
        value *= columns[j][j];
      else if (value > 0)
        value = 1 / std::sqrt(value);
      else  // nor is NaN
        return c + j;
      columns[j][i] = value;
    }
  }
  Register lower[K][K];
  for (int j = 0; j < K; ++j)
    for (int i = 0; i <= j; ++i) lower[j][i] = Register::spread(columns[i][j]);
  const auto divide = [&](Index k, auto rows) {
    Register solved[K];
    for (int j = 0; j < K; ++j) {
      Register value = rows.load(columns[j] + k);
      for (int i = 0; i < j; ++i) value = value - lower[j][i] * solved[i];
      solved[j] = value * lower[j][j];
      rows.store(columns[j] + k, solved[j]);
    }
  };
  const Index end = height - c;
  Index k = K;
  for (; k + kLanes <= end; k += kLanes) divide(k, Whole{});
  if (k < end) divide(k, First(end - k));
  return kNone;
}

Index eliminate_columns(double* panel, Index height, Index c, Index count) {
  switch (count) {
    case 1:
      return eliminate_columns<1>(panel, height, c);
    case 2:
      return eliminate_columns<2>(panel, height, c);
    case 3:
      return eliminate_columns<3>(panel, height, c);
    default:
      return eliminate_columns<4>(panel, height, c);
  }
}

}  // namespace

Index packed_size(Index tallest) { return tallest > kPacked ? kChunk * (tallest + kTall) : 0; }

Index eliminate(double* panel, double* update, Index height, Index width, double* room) {
  for (Index begin = 0; begin < width; begin += kChunk) {
    const Index end = std::min(begin + kChunk, width);
    for (Index c = begin; c <= end; c += kAcross) {
      const Index count = c < end ? std::min(end - c, kAcross) : width - end;
      const Index depth = c - begin;
      if (depth > 0)
        subtract_products(panel + c * height + c, height, height - c, 0, count,
                          panel + begin * height + c, height, depth, false, room);
      if (c == end) break;
      const Index failed = eliminate_columns(panel, height, c, count);
      if (failed != kNone) return failed;
    }
  }
  const Index below = height - width;
  for (Index begin = 0; begin < width; begin += kChunk)
    subtract_products(update, below, below, 0, below, panel + begin * height + width, height,
                      std::min(kChunk, width - begin), begin == 0, room);
  return kNone;
}

}  // namespace geodesic::front
