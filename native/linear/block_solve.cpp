// Forward and back substitution through the supernodes, for a block of right-hand sides, which
// share the reading of the factor.
#include <algorithm>

#include "core/processor.hpp"
#include "core/vectors.hpp"
#include "core/workspace.hpp"
#include "linear/substitution.hpp"

namespace geodesic {
namespace {

using Line = Pack<kBlock>;  // a row of a block

constexpr int kStrip = 2 * kLanes;  // columns of a block at a time
using Strip = Pack<kStrip>;

// A solve of a block. It is always full inside; missing columns are zero.
template <class T>
class BlockSolve {
 public:
  BlockSolve(const Analysis& analysis, const T* panels)
      : its_(analysis),
        panels_(panels),
        workspace_(kBlock * its_.n_vertices()),
        x_(workspace_.data()) {}

  bool solve(const double* b, double* x, Index stride, Index n_columns) {
    take(b, stride, n_columns);
    for (Index s = 0; s < its_.n_supernodes(); ++s) {
      const double* const own = x_ + kBlock * its_.first[s];
      bool touched = false;
      for (Index j = 0; j < kBlock * its_.width(s); ++j) touched |= own[j] != 0.0;
      if (touched) forward(s);
    }
    for (Index s = its_.n_supernodes() - 1; s >= 0; --s) backward(s);
    return give(x, stride, n_columns);
  }

 private:
  GT_INLINE double* line(Index row) { return x_ + kBlock * row; }

  // One strip of the block at a time: registers hold five rows of it.
  GT_INLINE void forward(Index s) {
    const Index width = its_.width(s), height = its_.height(s);
    const T* const panel = panels_ + its_.panels[s];
    const Row* const rows = its_.rows_of(s);
    Index c = 0;
    for (; c + 4 <= width; c += 4)
      for (int begin = 0; begin < kBlock; begin += kStrip)
        forward_four(panel + c * height + c, height, rows + c, height - c, begin);
    for (; c < width; ++c) {
      const T* const p = panel + c * height + c;
      const Line x0 = Line::load(line(rows[c])) * Line::spread_from(p + 0);
      x0.store(line(rows[c]));
      for (Index i = 1; i < height - c; ++i) {
        double* const where = line(rows[c + i]);
        (Line::load(where) - Line::spread_from(p + i) * x0).store(where);
      }
    }
  }

  GT_INLINE void forward_four(const T* p, Index height, const Row* rows, Index count, int begin) {
    const T *const q = p + height, *const r = q + height, *const t = r + height;
    double* const x = line(rows[0]) + begin;
    const Strip x0 = Strip::load(x) * Strip::spread_from(p + 0);
    const Strip x1 =
        (Strip::load(x + kBlock) - Strip::spread_from(p + 1) * x0) * Strip::spread_from(q + 1);
    const Strip x2 = (Strip::load(x + 2 * kBlock) - Strip::spread_from(p + 2) * x0 -
                      Strip::spread_from(q + 2) * x1) *
                     Strip::spread_from(r + 2);
    const Strip x3 = (Strip::load(x + 3 * kBlock) - Strip::spread_from(p + 3) * x0 -
                      Strip::spread_from(q + 3) * x1 - Strip::spread_from(r + 3) * x2) *
                     Strip::spread_from(t + 3);
    x0.store(x);
    x1.store(x + kBlock);
    x2.store(x + 2 * kBlock);
    x3.store(x + 3 * kBlock);
    for (Index i = 4; i < count; ++i) {
      double* const where = line(rows[i]) + begin;
      Strip row = Strip::load(where);
      row = row - Strip::spread_from(p + i) * x0;
      row = row - Strip::spread_from(q + i) * x1;
      row = row - Strip::spread_from(r + i) * x2;
      row = row - Strip::spread_from(t + i) * x3;
      row.store(where);
    }
  }

  GT_INLINE void backward(Index s) {
    const Index width = its_.width(s), height = its_.height(s);
    const T* const panel = panels_ + its_.panels[s];
    const Row* const rows = its_.rows_of(s);
    Index c = width;
    while (c >= 4) {
      c -= 4;
      for (int begin = 0; begin < kBlock; begin += kStrip)
        backward_four(panel + c * height + c, height, rows + c, height - c, begin);
    }
    while (c > 0) {
      --c;
      const T* const p = panel + c * height + c;
      Line x0 = Line::load(line(rows[c]));
      for (Index i = 1; i < height - c; ++i)
        x0 = x0 - Line::spread_from(p + i) * Line::load(line(rows[c + i]));
      (x0 * Line::spread_from(p + 0)).store(line(rows[c]));
    }
  }

  GT_INLINE void backward_four(const T* p, Index height, const Row* rows, Index count, int begin) {
    const T *const q = p + height, *const r = q + height, *const t = r + height;
    double* const x = line(rows[0]) + begin;
    Strip x0 = Strip::load(x), x1 = Strip::load(x + kBlock), x2 = Strip::load(x + 2 * kBlock);
    Strip x3 = Strip::load(x + 3 * kBlock);
    for (Index i = 4; i < count; ++i) {
      const Strip row = Strip::load(line(rows[i]) + begin);
      x0 = x0 - Strip::spread_from(p + i) * row;
      x1 = x1 - Strip::spread_from(q + i) * row;
      x2 = x2 - Strip::spread_from(r + i) * row;
      x3 = x3 - Strip::spread_from(t + i) * row;
    }
    x3 = x3 * Strip::spread_from(t + 3);
    x2 = (x2 - Strip::spread_from(r + 3) * x3) * Strip::spread_from(r + 2);
    x1 = (x1 - Strip::spread_from(q + 2) * x2 - Strip::spread_from(q + 3) * x3) *
         Strip::spread_from(q + 1);
    x0 = (x0 - Strip::spread_from(p + 1) * x1 - Strip::spread_from(p + 2) * x2 -
          Strip::spread_from(p + 3) * x3) *
         Strip::spread_from(p + 0);
    x0.store(x);
    x1.store(x + kBlock);
    x2.store(x + 2 * kBlock);
    x3.store(x + 3 * kBlock);
  }

  void take(const double* b, Index stride, Index n_columns) {
    for (Index j = 0; j < its_.n_vertices(); ++j) {
      const double* const from = b + its_.order[j] * stride;
      if (n_columns == kBlock) {
        Line::load(from).store(line(j));
      } else {
        std::copy_n(from, n_columns, line(j));
        std::fill_n(line(j) + n_columns, kBlock - n_columns, 0.0);
      }
    }
  }

  bool give(double* x, Index stride, Index n_columns) {
    Line nothing = Line::zeros();
    for (Index j = 0; j < its_.n_vertices(); ++j) {
      const Line row = Line::load(line(j));
      nothing = nothing - row * Line::zeros();  // stays 0 if that is finite
      double* const to = x + its_.order[j] * stride;
      if (n_columns == kBlock)
        row.store(to);
      else
        std::copy_n(line(j), n_columns, to);
    }
    return nothing.sum() == 0.0;
  }

  const Analysis& its_;
  const T* const panels_;
  Workspace workspace_;
  double* const x_;
};

}  // namespace

template <class T>
bool solve_block(const Analysis& analysis, const T* panels, const double* b, double* x,
                 Index stride, Index n_columns) {
  const FlushSubnormals flush;
  return BlockSolve<T>(analysis, panels).solve(b, x, stride, n_columns);
}

template bool solve_block(const Analysis&, const double*, const double*, double*, Index, Index);
template bool solve_block(const Analysis&, const Half*, const double*, double*, Index, Index);

}  // namespace geodesic
