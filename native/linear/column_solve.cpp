// Forward and back substitution through the supernodes, for one right-hand side.
//
// A solve reads the factor twice and does little with it, so it is as fast as memory is. Where the
// right-hand side is zero in all of a supernode's subtree, so is the solution of L y = b, and the
// forward substitution skips it: heat from one vertex touches only the path from there to the root.
#include <algorithm>

#include "core/processor.hpp"
#include "core/vectors.hpp"
#include "core/workspace.hpp"
#include "linear/substitution.hpp"

namespace geodesic {
namespace {

using Four = Pack<4>;  // rows of a list
constexpr int kRows = kLanes < 4 ? 4 : kLanes;
using Rows = Pack<kRows>;  // rows that lie together

constexpr Index kMaxColumnsInPlace =
    4;  // columns of a supernode up to which x is worked on where it is
constexpr Index kPrefetchDistance = 1024;  // numbers of a factor that are asked for ahead
constexpr Index kCachedBytes = 1 << 20;  // bytes of a factor that stays in the cache between solves

// Up to four columns of a panel; where fewer are left, the first of them stands for the others.
template <class T>
struct Columns {
  const T* at[4];

  GT_INLINE Columns(const T* first, Index height, Index count) {
    for (Index k = 0; k < 4; ++k) at[k] = first + (k < count ? k : 0) * height;
  }
  GT_INLINE Columns(const Columns& other, Index down) {
    for (int k = 0; k < 4; ++k) at[k] = other.at[k] + down;
  }
};

// Prefetch the numbers of a factor `ahead` of a position, which may lie behind its end; 0 disables
// prefetching.
template <class T>
GT_INLINE void fetch(const T* begin, Index count, Index ahead) {
  if (ahead == 0) return;
  constexpr Index kLine = 64 / sizeof(T);
  for (Index k = ahead; k < ahead + count; k += kLine) prefetch(begin + k);
}

// Solve with a triangle of up to four columns, x[0, count) in place; the others come out as 0.
template <class T>
GT_INLINE void forward_four(double* x, Index count, const Columns<T>& l, double (&y)[4]) {
  const auto [p, q, r, s] = l.at;
  y[0] = x[0] * p[0];
  y[1] = y[2] = y[3] = 0.0;
  x[0] = y[0];
  if (count > 1) x[1] = y[1] = (x[1] - p[1] * y[0]) * q[1];
  if (count > 2) x[2] = y[2] = (x[2] - p[2] * y[0] - q[2] * y[1]) * r[2];
  if (count > 3) x[3] = y[3] = (x[3] - p[3] * y[0] - q[3] * y[1] - r[3] * y[2]) * s[3];
}

// Solve with the transposed triangle; `below` are the products of the rows below it.
template <class T>
GT_INLINE void backward_four(double* x, Index count, const Columns<T>& l,
                             const double (&below)[4]) {
  const auto [p, q, r, s] = l.at;
  double x1 = 0.0, x2 = 0.0, x3 = 0.0, x0 = x[0] - below[0];
  if (count > 3) {
    x3 = (x[3] - below[3]) * s[3];
    x[3] = x3;
    x0 -= p[3] * x3;
  }
  if (count > 2) {
    x2 = x[2] - below[2];
    if (count > 3) x2 -= r[3] * x3;
    x2 *= r[2];
    x[2] = x2;
    x0 -= p[2] * x2;
  }
  if (count > 1) {
    x1 = x[1] - below[1];
    if (count > 2) x1 -= q[2] * x2;
    if (count > 3) x1 -= q[3] * x3;
    x1 *= q[1];
    x[1] = x1;
    x0 -= p[1] * x1;
  }
  x[0] = x0 * p[0];
}

// Subtract multiples of four columns from x[0, count), and spoil up to kPaddingRows - 1 numbers
// behind.
template <class T>
GT_INLINE void minus_columns(double* x, Index count, const Columns<T>& l, const double (&y)[4]) {
  Rows multiples[4];
  for (int k = 0; k < 4; ++k) multiples[k] = Rows::spread(y[k]);
  for (Index i = 0; i < count; i += kRows) {
    Rows rows = Rows::load(x + i);
    for (int k = 0; k < 4; ++k) rows = rows - Rows::load(l.at[k] + i) * multiples[k];
    rows.store(x + i);
  }
}

// Sums of products with four columns. By name: GCC keeps an array of them in memory.
template <class T, class Values>
struct FourSums {
  Values p = Values::zeros(), q = p, r = p, s = p;

  GT_INLINE void add(const Columns<T>& l, Index i, const Values& values) {
    p = p + Values::load(l.at[0] + i) * values;
    q = q + Values::load(l.at[1] + i) * values;
    r = r + Values::load(l.at[2] + i) * values;
    s = s + Values::load(l.at[3] + i) * values;
  }
  GT_INLINE void write(double (&dots)[4]) const {
    dots[0] = p.sum();
    dots[1] = q.sum();
    dots[2] = r.sum();
    dots[3] = s.sum();
  }
};

// The dot products of x[0, count), with kPaddingRows - 1 zeros behind, and four columns.
template <class T>
GT_INLINE void dot_columns(const double* x, Index count, const Columns<T>& l, double (&dots)[4]) {
  FourSums<T, Rows> sums;
  for (Index i = 0; i < count; i += kRows) sums.add(l, i, Rows::load(x + i));
  sums.write(dots);
}

// Visit a list of rows of x, four at a time: work(i, row), where row(lane) is the row at place
// i + lane. Behind the end of the list that is a spare row.
template <class Work>
GT_INLINE void for_rows(const Row* rows, Index count, Row spare, Work work) {
  Index i = 0;
  for (; i + 4 <= count; i += 4) work(i, [rows, i](int lane) { return rows[i + lane]; });
  if (i < count) work(i, [=](int lane) { return i + lane < count ? rows[i + lane] : spare; });
}

// Subtract multiples of four columns from x at listed rows, and something from the spare row.
template <class T>
GT_INLINE void minus_rows(double* x, const Row* rows, Index count, Row spare, const Columns<T>& l,
                          const double (&y)[4]) {
  Four multiples[4];
  for (int k = 0; k < 4; ++k) multiples[k] = Four::spread(y[k]);
  for_rows(rows, count, spare, [&](Index i, auto row) {
    Four less = Four::load(l.at[0] + i) * multiples[0];
    for (int k = 1; k < 4; ++k) less = less + Four::load(l.at[k] + i) * multiples[k];
    for (int lane = 0; lane < 4; ++lane) x[row(lane)] -= less[lane];
  });
}

// The dot products of x at listed rows and four columns; x at the spare row is 0.
template <class T>
GT_INLINE void dot_rows(const double* x, const Row* rows, Index count, Row spare,
                        const Columns<T>& l, double (&dots)[4]) {
  FourSums<T, Four> sums;
  for_rows(rows, count, spare, [&](Index i, auto row) {
    sums.add(l, i, Four::of([&](int lane) { return x[row(lane)]; }));
  });
  sums.write(dots);
}

// A solve of one column.
template <class T>
class ColumnSolve {
 public:
  ColumnSolve(const Analysis& analysis, const T* panels)
      : its_(analysis),
        panels_(panels),
        spare_(static_cast<Row>(its_.n_vertices())),
        workspace_(its_.n_vertices() + 1 + its_.tallest + kPaddingRows),
        x_(workspace_.data()),
        own_(x_ + its_.n_vertices() + 1),
        ahead_(its_.n_stored() * static_cast<Index>(sizeof(T)) > kCachedBytes ? kPrefetchDistance
                                                                              : 0) {}

  bool solve(const double* b, double* x, Index stride) {
    const Index n = its_.n_vertices();
    for (Index j = 0; j < n; ++j) x_[j] = b[its_.order[j] * stride];
    for (Index s = 0; s < its_.n_supernodes(); ++s) forward(s);
    x_[n] = 0.0;
    for (Index s = its_.n_supernodes() - 1; s >= 0; --s) backward(s);
    double nothing = 0.0;
    for (Index j = 0; j < n; ++j) {
      x[its_.order[j] * stride] = x_[j];
      nothing += 0.0 * x_[j];
    }
    return nothing == 0.0;
  }

 private:
  GT_INLINE void forward(Index s) {
    const Index width = its_.width(s), height = its_.height(s);
    double* const x = x_ + its_.first[s];
    bool touched = false;
    for (Index j = 0; j < width; ++j) touched |= x[j] != 0.0;
    if (!touched) return;
    const T* const panel = panels_ + its_.panels[s];
    const Row* const below = its_.rows_below(s);
    double y[4];
    if (width <= kMaxColumnsInPlace) {  // most are: no copy, and a loop or two
      const Columns<T> l(panel, height, width);
      fetch(panel, width * height, ahead_);
      forward_four(x, width, l, y);
      minus_rows(x_, below, height - width, spare_, Columns<T>(l, width), y);
      return;
    }
    double* const own = own_;
    std::copy_n(x, width, own);
    std::fill_n(own + width, height - width, 0.0);
    for (Index c = 0; c < width; c += 4) {
      const Index count = std::min<Index>(width - c, 4), end = c + count;
      const Columns<T> l(panel + c * height + c, height, count);
      fetch(l.at[0], count * height, ahead_);
      forward_four(own + c, count, l, y);
      minus_columns(own + end, height - end, Columns<T>(l, count), y);
    }
    std::copy_n(own, width, x);
    for (Index k = 0; k < height - width; ++k) x_[below[k]] += own[width + k];
  }

  GT_INLINE void backward(Index s) {
    const Index width = its_.width(s), height = its_.height(s);
    double* const x = x_ + its_.first[s];
    const T* const panel = panels_ + its_.panels[s];
    const Row* const below = its_.rows_below(s);
    double dots[4];
    if (width <= kMaxColumnsInPlace) {
      const Columns<T> l(panel, height, width);
      fetch(panel, width * height, -ahead_);
      dot_rows(x_, below, height - width, spare_, Columns<T>(l, width), dots);
      backward_four(x, width, l, dots);
      return;
    }
    double* const own = own_;
    std::copy_n(x, width, own);
    for (Index k = 0; k < height - width; ++k) own[width + k] = x_[below[k]];
    std::fill_n(own + height, kPaddingRows, 0.0);
    for (Index c = (width - 1) / 4 * 4; c >= 0; c -= 4) {
      const Index count = std::min<Index>(width - c, 4), end = c + count;
      const Columns<T> l(panel + c * height + c, height, count);
      fetch(l.at[0], count * height, -ahead_);
      dot_columns(own + end, height - end, Columns<T>(l, count), dots);
      backward_four(own + c, count, l, dots);
    }
    std::copy_n(own, width, x);
  }

  const Analysis& its_;
  const T* const panels_;
  const Row spare_;  // one more row of x, which means nothing
  Workspace workspace_;
  double *const x_, *const own_;  // the part of one supernode
  const Index ahead_;
};

}  // namespace

template <class T>
bool solve_column(const Analysis& analysis, const T* panels, const double* b, double* x,
                  Index stride) {
  const FlushSubnormals flush;
  return ColumnSolve<T>(analysis, panels).solve(b, x, stride);
}

template bool solve_column(const Analysis&, const double*, const double*, double*, Index);
template bool solve_column(const Analysis&, const Half*, const double*, double*, Index);

}  // namespace geodesic
