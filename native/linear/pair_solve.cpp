// Forward and back substitution with a factor of complex numbers, a + i b in pairs (a, b).
//
// The first column of each pair of its real form is a column of the complex factor, so that a solve
// reads half of what a real one does. Like that it is as fast as memory is, and skips supernodes
// that the right-hand side does not touch.
#include <algorithm>

#include "core/processor.hpp"
#include "core/vectors.hpp"
#include "core/workspace.hpp"
#include "linear/substitution.hpp"

namespace geodesic {
namespace {

constexpr int kColumns = 4;  // complex columns at a time
constexpr int kRows = kLanes < 4 ? 4 : kLanes;
using Rows = Pack<kRows>;  // real and imaginary parts that lie together
using Two = Pack<4>;       // those of two rows of a list
using One = Pack<2>;

constexpr Index kPrefetchDistance = 1024;  // numbers of a factor that are asked for ahead
constexpr Index kCachedBytes = 1 << 20;  // bytes of a factor that stays in the cache between solves

struct Complex {
  double re, im;
};
GT_INLINE Complex operator-(const Complex& a, const Complex& b) {
  return {a.re - b.re, a.im - b.im};
}
GT_INLINE Complex operator*(const Complex& a, const Complex& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
GT_INLINE Complex operator*(const Complex& a, double b) { return {a.re * b, a.im * b}; }
GT_INLINE Complex conjugate(const Complex& a) { return {a.re, -a.im}; }
GT_INLINE Complex load(const double* from) { return {from[0], from[1]}; }
GT_INLINE void store(double* to, const Complex& a) {
  to[0] = a.re;
  to[1] = a.im;
}

// Up to four columns; where fewer are left, the first of them stands for the others.
struct Columns {
  const double* at[kColumns];

  GT_INLINE Columns(const double* first, Index height, Index count) {
    for (Index k = 0; k < kColumns; ++k) at[k] = first + (k < count ? k : 0) * height;
  }
  GT_INLINE Columns(const Columns& other, Index down) {
    for (int k = 0; k < kColumns; ++k) at[k] = other.at[k] + down;
  }
  // The entry in a row of the triangle of these columns.
  GT_INLINE Complex entry(Index row, Index column) const { return load(at[column] + 2 * row); }
};

GT_INLINE void fetch(const double* begin, Index count, Index ahead) {
  if (ahead == 0) return;
  for (Index k = ahead; k < ahead + count; k += 8) prefetch(begin + k);
}

// Solve with a triangle, x in place; the values of columns that are not there come out as 0.
GT_INLINE void forward_triangle(double* x, Index count, const Columns& l, Complex (&y)[kColumns]) {
  for (Index k = 0; k < kColumns; ++k) {
    y[k] = {0.0, 0.0};
    if (k >= count) continue;
    Complex value = load(x + 2 * k);
    for (Index m = 0; m < k; ++m) value = value - l.entry(k, m) * y[m];
    y[k] = value * l.at[k][2 * k];
    store(x + 2 * k, y[k]);
  }
}

// Solve with the conjugate transpose; `below` are the products of the rows below it.
GT_INLINE void backward_triangle(double* x, Index count, const Columns& l,
                                 const Complex (&below)[kColumns]) {
  for (Index k = count - 1; k >= 0; --k) {
    Complex value = load(x + 2 * k) - below[k];
    for (Index m = k + 1; m < count; ++m)
      value = value - conjugate(l.entry(m, k)) * load(x + 2 * m);
    store(x + 2 * k, value * l.at[k][2 * k]);
  }
}

// Sums of rows of four columns, times a number each.
template <class Values>
struct Multiples {
  Values re[kColumns], im[kColumns];

  explicit GT_INLINE Multiples(const Complex (&y)[kColumns]) {
    for (int k = 0; k < kColumns; ++k) {
      re[k] = Values::spread(y[k].re);
      im[k] = Values::spread(y[k].im);
    }
  }
  GT_INLINE Values of(const Columns& l, Index i) const {
    Values real = Values::zeros(), imaginary = real;
    for (int k = 0; k < kColumns; ++k) {
      const Values entries = Values::load(l.at[k] + i);
      real = real + entries * re[k];
      imaginary = imaginary + entries * im[k];
    }
    return real + times_i(imaginary);
  }
};

// Sums of products of rows with the conjugates of four columns.
template <class Values>
struct Products {
  Values re[kColumns], im[kColumns];

  GT_INLINE Products() {
    for (int k = 0; k < kColumns; ++k) re[k] = im[k] = Values::zeros();
  }
  GT_INLINE void add(const Columns& l, Index i, const Values& x) {
    const Values turned = Values::zeros() - times_i(x);
    for (int k = 0; k < kColumns; ++k) {
      const Values entries = Values::load(l.at[k] + i);
      re[k] = re[k] + entries * x;
      im[k] = im[k] + entries * turned;
    }
  }
  GT_INLINE void write(Complex (&sums)[kColumns]) const {
    for (int k = 0; k < kColumns; ++k) sums[k] = {re[k].sum(), im[k].sum()};
  }
};

class PairSolve {
 public:
  PairSolve(const Analysis& analysis, const double* panels)
      : its_(analysis),
        panels_(panels),
        workspace_(its_.n_vertices() + its_.tallest + kPaddingRows),
        x_(workspace_.data()),
        own_(x_ + its_.n_vertices()),
        ahead_(its_.n_stored() * Index{sizeof(double)} > kCachedBytes ? kPrefetchDistance : 0) {}

  bool solve(const double* b, double* x, Index stride) {
    const Index n = its_.n_vertices();
    for (Index j = 0; j < n; ++j) x_[j] = b[its_.order[j] * stride];
    for (Index s = 0; s < its_.n_supernodes(); ++s) forward(s);
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
    const Index width = its_.width(s) / 2, height = its_.height(s);
    double* const x = x_ + its_.first[s];
    bool touched = false;
    for (Index j = 0; j < 2 * width; ++j) touched |= x[j] != 0.0;
    if (!touched) return;
    const double* const panel = panels_ + its_.panels[s];
    const Row* const below = its_.rows_below(s);
    Complex y[kColumns];
    if (width <= kColumns) {  // most are: no copy
      const Columns l(panel, height, width);
      fetch(panel, width * height, ahead_);
      forward_triangle(x, width, l, y);
      minus_rows(below, height - 2 * width, Columns(l, 2 * width), y);
      return;
    }
    double* const own = own_;
    std::copy_n(x, 2 * width, own);
    std::fill_n(own + 2 * width, height - 2 * width, 0.0);
    for (Index c = 0; c < width; c += kColumns) {
      const Index count = std::min<Index>(width - c, kColumns), end = 2 * (c + count);
      const Columns l(panel + c * height + 2 * c, height, count);
      fetch(l.at[0], count * height, ahead_);
      forward_triangle(own + 2 * c, count, l, y);
      const Multiples<Rows> multiples(y);
      const Columns under(l, 2 * count);
      for (Index i = 0; i < height - end; i += kRows)  // spoils up to kPaddingRows - 1 behind
        (Rows::load(own + end + i) - multiples.of(under, i)).store(own + end + i);
    }
    std::copy_n(own, 2 * width, x);
    for (Index k = 0; k < height - 2 * width; ++k) x_[below[k]] += own[2 * width + k];
  }

  GT_INLINE void backward(Index s) {
    const Index width = its_.width(s) / 2, height = its_.height(s);
    double* const x = x_ + its_.first[s];
    const double* const panel = panels_ + its_.panels[s];
    const Row* const below = its_.rows_below(s);
    Complex sums[kColumns];
    if (width <= kColumns) {
      const Columns l(panel, height, width);
      fetch(panel, width * height, -ahead_);
      products_of_rows(below, height - 2 * width, Columns(l, 2 * width), sums);
      backward_triangle(x, width, l, sums);
      return;
    }
    double* const own = own_;
    std::copy_n(x, 2 * width, own);
    for (Index k = 0; k < height - 2 * width; ++k) own[2 * width + k] = x_[below[k]];
    std::fill_n(own + height, kPaddingRows, 0.0);
    for (Index c = (width - 1) / kColumns * kColumns; c >= 0; c -= kColumns) {
      const Index count = std::min<Index>(width - c, kColumns), end = 2 * (c + count);
      const Columns l(panel + c * height + 2 * c, height, count);
      fetch(l.at[0], count * height, -ahead_);
      const Columns under(l, 2 * count);
      Products<Rows> products;
      for (Index i = 0; i < height - end; i += kRows)
        products.add(under, i, Rows::load(own + end + i));
      products.write(sums);
      backward_triangle(own + 2 * c, count, l, sums);
    }
    std::copy_n(own, 2 * width, x);
  }

  // Real and imaginary part of a row of x lie together.
  GT_INLINE void minus_rows(const Row* rows, Index count, const Columns& l,
                            const Complex (&y)[kColumns]) {
    const Multiples<Two> two(y);
    Index i = 0;
    for (; i + 4 <= count; i += 4) {
      const Two less = two.of(l, i);
      for (int part = 0; part < 2; ++part) {
        x_[rows[i] + part] -= less[part];
        x_[rows[i + 2] + part] -= less[2 + part];
      }
    }
    if (i == count) return;
    double* const last = x_ + rows[i];
    (One::load(last) - Multiples<One>(y).of(l, i)).store(last);
  }

  GT_INLINE void products_of_rows(const Row* rows, Index count, const Columns& l,
                                  Complex (&sums)[kColumns]) const {
    Products<Two> products;
    Index i = 0;
    for (; i + 4 <= count; i += 4) {
      const double *const one = x_ + rows[i], *const other = x_ + rows[i + 2];
      products.add(l, i, Two::of([&](int lane) { return lane < 2 ? one[lane] : other[lane - 2]; }));
    }
    products.write(sums);
    if (i == count) return;
    Products<One> last;
    Complex more[kColumns];
    last.add(l, i, One::load(x_ + rows[i]));
    last.write(more);
    for (int k = 0; k < kColumns; ++k) {
      sums[k].re += more[k].re;
      sums[k].im += more[k].im;
    }
  }

  const Analysis& its_;
  const double* const panels_;
  Workspace workspace_;
  double *const x_, *const own_;  // the part of one supernode
  const Index ahead_;
};

}  // namespace

bool solve_pairs(const Analysis& analysis, const double* panels, std::span<const double> b,
                 std::span<double> x, Index n_columns) {
  const FlushSubnormals flush;
  PairSolve solve(analysis, panels);
  bool finite = true;
  for (Index k = 0; k < n_columns; ++k)
    finite &= solve.solve(b.data() + k, x.data() + k, n_columns);
  return finite;
}

}  // namespace geodesic
