#include "linear/front.hpp"

#include <algorithm>
#include <cmath>

#include "core/vectors.hpp"

namespace geodesic::front {
namespace {

constexpr Index kTileColumns = 4;                     // columns of a tile
constexpr int kTileRegisters = 2;                     // registers of rows of a tile
constexpr Index kTileRows = kTileRegisters * kLanes;  // rows of a tile
// Columns of a tile of which one in `Every` is computed: B' has them within the rows of a tile.
template <int Every>
constexpr Index kTile = kTileColumns * Every <= kTileRows ? kTileColumns : kTileRows / Every;
constexpr Index kChunkColumns = 128;   // columns whose products are summed up at once
constexpr Index kSlabRows = 128;       // rows that stay in the second level of cache
constexpr Index kMinPackedRows = 320;  // rows from which on they are copied together before use

// Subtract A B' from a tile of `width` columns at `target`, `Every` apart; where `fresh`, the tile
// counts as zero.
//
// A[i, c] is a[c * step + i], B[j, c] is b[c * step + j], for `depth` columns c.
template <int N, int Every, class Rows>
GT_INLINE void subtract_tile(double* target, Index stride, const double* a, const double* b,
                             Index step, Index depth, Index width, bool fresh, Rows rows) {
  constexpr Index kColumns = kTile<Every>;
  Register sums[kColumns][N];
  for (int k = 0; k < kColumns; ++k)
    for (int v = 0; v < N; ++v) sums[k][v] = Register::zeros();
  Index places[kColumns];
  for (int k = 0; k < kColumns; ++k) places[k] = k < width ? k * Every : 0;
  for (Index c = 0; c < depth; ++c, a += step, b += step) {
    Register values[N];
    for (int v = 0; v < N; ++v) values[v] = rows.load(a + v * kLanes);
    for (int k = 0; k < kColumns; ++k) {
      const Register factor = Register::spread(b[places[k]]);  // not past the end of B
      for (int v = 0; v < N; ++v) sums[k][v] = sums[k][v] + factor * values[v];
    }
  }
  for (int k = 0; k < kColumns; ++k) {
    if (k >= width) break;
    for (int v = 0; v < N; ++v) {
      double* const where = target + k * Every * stride + v * kLanes;
      const Register before = fresh ? Register::zeros() : rows.load(where);
      rows.store(where, before - sums[k][v]);
    }
  }
}

// Copy columns that are `height` apart into blocks of kTileRows rows, so that a tile reads
// contiguous memory.
void pack(double* workspace, const double* source, Index height, Index n_rows, Index depth) {
  for (Index top = 0; top < n_rows; top += kTileRows) {
    const Index count = std::min(kTileRows, n_rows - top);
    for (Index c = 0; c < depth; ++c)
      std::copy_n(source + c * height + top, count, workspace + top * depth + c * kTileRows);
  }
}

// Subtract B B' from the lower triangle of the first columns of C; where `fresh`, C counts as zero.
//
// B has `depth` columns, `height` apart, C has `n_columns`, `stride` apart; both have `n_rows`.
// Entries of C above the diagonal are overwritten. Only columns [0, to) of C are updated, of which
// one in `Every`.
template <int Every>
void subtract_products(double* target, Index stride, Index n_rows, Index to, const double* source,
                       Index height, Index depth, bool fresh, double* workspace) {
  constexpr Index kStride = kTile<Every> * Every;
  Index step = height, scale = 1, beyond = kStride - 1;
  if (n_rows > kMinPackedRows && to > kTileColumns * Every) {
    pack(workspace, source, height, n_rows, depth);
    source = workspace;
    step = kTileRows;
    scale = depth;
    beyond = kTileRows - 1;
  }
  for (Index top = 0; top < n_rows; top += kSlabRows) {
    const Index bottom = std::min(top + kSlabRows, n_rows);
    for (Index j = 0; j < std::min(to, bottom); j += kStride) {
      const Index width = std::min((to - j) / Every, kTile<Every>);
      const Index begin = j & ~beyond;  // of the piece that column j of B' is in; powers of two
      const double* const b = source + begin * scale + (j & beyond);
      Index i = std::max(top, begin);
      for (; i + kTileRows <= bottom; i += kTileRows)
        subtract_tile<kTileRegisters, Every>(target + j * stride + i, stride, source + i * scale, b,
                                             step, depth, width, fresh, Whole{});
      const double* a = source + i * scale;
      for (; i < bottom; i += kLanes, a += kLanes)
        subtract_tile<1, Every>(target + j * stride + i, stride, a, b, step, depth, width, fresh,
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

// Write the odd columns of pairs [c, c + count) of a panel: i times the even ones.
void turn_columns(double* panel, Index height, Index c, Index count) {
  for (Index j = c; j < c + count; j += 2) {
    const double* const even = panel + j * height;
    double* const odd = panel + (j + 1) * height;
    for (Index i = c; i < height; i += 2) {
      odd[i] = -even[i + 1];
      odd[i + 1] = even[i];
    }
  }
}

template <int Every>
Index eliminate_every(double* panel, double* update, Index height, Index width, double* workspace) {
  for (Index begin = 0; begin < width; begin += kChunkColumns) {
    const Index end = std::min(begin + kChunkColumns, width);
    for (Index c = begin; c <= end; c += kTileColumns) {
      const Index count = c < end ? std::min(end - c, kTileColumns) : width - end;
      const Index depth = c - begin;
      if (depth > 0)
        subtract_products<Every>(panel + c * height + c, height, height - c, count,
                                 panel + begin * height + c, height, depth, false, workspace);
      if (c == end) break;
      if constexpr (Every == 2) turn_columns(panel, height, c, count);
      const Index failed = eliminate_columns(panel, height, c, count);
      if (failed != kNone) return failed;
    }
  }
  const Index below = height - width;
  for (Index begin = 0; begin < width; begin += kChunkColumns)
    subtract_products<Every>(update, below, below, below, panel + begin * height + width, height,
                             std::min(kChunkColumns, width - begin), begin == 0, workspace);
  return kNone;
}

}  // namespace

Index packed_size(Index tallest) {
  return tallest > kMinPackedRows ? kChunkColumns * (tallest + kTileRows) : 0;
}

Index eliminate(double* panel, double* update, Index height, Index width, bool in_pairs,
                double* workspace) {
  return in_pairs ? eliminate_every<2>(panel, update, height, width, workspace)
                  : eliminate_every<1>(panel, update, height, width, workspace);
}

}  // namespace geodesic::front
