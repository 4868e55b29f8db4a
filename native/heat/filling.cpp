#include "heat/filling.hpp"

#include <cmath>

namespace geodesic {

void fill(const MatrixView& matrix, std::span<double> solution, Index stride, std::span<Row> rows) {
  Array<double> means(count(rows));
  for (Index left = count(rows);;) {
    for (Index m = 0; m < left; ++m) {
      double mass = 0.0, total = 0.0, found = 0.0;
      bool known = false;
      for (Row entry = matrix.indptr[rows[m]]; entry < matrix.indptr[rows[m] + 1]; ++entry) {
        const Row neighbour = matrix.indices[entry];
        const double value = matrix.data[entry];
        mass += value;
        if (neighbour == rows[m] || value == 0) continue;
        total += std::abs(value);
        if (solution[neighbour * stride] > 0) {
          found += std::abs(value) * solution[neighbour * stride];
          known = true;
        }
      }
      means[m] = known ? found / (std::abs(mass) + total) : -1.0;
    }
    Index waiting = 0;
    for (Index m = 0; m < left; ++m) {  // now that no row looks at its neighbours any more
      if (means[m] < 0)
        rows[waiting++] = rows[m];
      else
        solution[rows[m] * stride] = means[m];
    }
    if (waiting == left) return;
    left = waiting;
  }
}

}  // namespace geodesic
