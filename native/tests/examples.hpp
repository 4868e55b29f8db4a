// Matrices and meshes to test kernels on.
#pragma once

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "core/matrix.hpp"

namespace geodesic::testing {

// A table by rows, each of which is sorted by column.
using Entries = std::vector<std::map<Row, double>>;

struct Sparse {
  std::vector<Row> indptr{0}, indices;
  std::vector<double> data;

  explicit Sparse(const Entries& rows) {
    for (const auto& row : rows) {
      for (const auto& [column, value] : row) {
        indices.push_back(column);
        data.push_back(value);
      }
      indptr.push_back(static_cast<Row>(indices.size()));
    }
  }
  Pattern pattern() const { return {indptr, indices}; }
  MatrixView view() const { return {pattern(), data}; }
  Index size() const { return pattern().size(); }
  // An entry of the pattern.
  double& at(Row row, Row column) {
    const auto begin = indices.begin() + indptr[row], end = indices.begin() + indptr[row + 1];
    return data[std::lower_bound(begin, end, column) - indices.begin()];
  }

  // The product with a table of columns, in plain loops.
  std::vector<double> times(const std::vector<double>& x, Index n_columns) const {
    std::vector<double> product(x.size(), 0.0);
    for (Index i = 0; i < size(); ++i)
      for (Row p = indptr[i]; p < indptr[i + 1]; ++p)
        for (Index c = 0; c < n_columns; ++c)
          product[i * n_columns + c] += data[p] * x[indices[p] * n_columns + c];
    return product;
  }
};

struct Mesh {
  std::vector<double> vertices;
  std::vector<Index> faces;
  Index n_vertices() const { return static_cast<Index>(vertices.size()) / 3; }
  Index n_faces() const { return static_cast<Index>(faces.size()) / 3; }
};

inline std::vector<double> random_numbers(Index count, unsigned seed, double low = 0.0) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> distribution(low, 1.0);
  std::vector<double> numbers(count);
  for (double& number : numbers) number = distribution(generator);
  return numbers;
}

inline void add_edge(Entries& rows, Row i, Row j, double weight) {
  rows[i][j] -= weight;
  rows[j][i] -= weight;
  rows[i][i] += weight;
  rows[j][j] += weight;
}

// A matrix of zeros with a diagonal of `shift`.
inline Entries diagonal(Row n, double shift) {
  Entries rows(n);
  for (Row v = 0; v < n; ++v) rows[v][v] = shift;
  return rows;
}

// The Laplacian of a square grid, plus a multiple of 1.
inline Sparse grid(Row side, double shift) {
  Entries rows = diagonal(side * side, shift);
  for (Row v = 0; v < side * side; ++v) {
    if (v % side + 1 < side) add_edge(rows, v, v + 1, 1.0);
    if (v + side < side * side) add_edge(rows, v, v + side, 1.0);
  }
  return Sparse(rows);
}

// That of a random graph, of as many parts as it happens to have; with `hub` the last vertex has an
// edge to all others, and a full row.
inline Sparse random_graph(Row n, double edges_each, bool hub, double shift, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<Row> vertex(0, n - 1);
  Entries rows = diagonal(n, shift);
  const auto n_edges = static_cast<Row>(edges_each * n);
  for (Row e = 0; e < n_edges; ++e) {
    const Row i = vertex(generator), j = vertex(generator);
    if (i != j) add_edge(rows, i, j, 0.5 + e % 7);
  }
  for (Row v = 0; hub && v < n - 1; ++v) add_edge(rows, v, n - 1, 1.0);
  return Sparse(rows);
}

// A clique, two more that have edges to all of it, and a path: supernodes of many columns, with
// many rows below.
inline Sparse cliques(Row own, Row shared, Row path, double shift) {
  const Row n = 2 * own + shared + path;
  Entries rows = diagonal(n, shift);
  const auto join = [&](Row begin, Row end, Row others, Row others_end) {
    for (Row i = begin; i < end; ++i)
      for (Row j = others; j < std::min(i, others_end); ++j)
        add_edge(rows, i, j, 1.0 + (i + j) % 3);
  };
  join(0, shared, 0, shared);
  join(shared, shared + own, 0, shared + own);
  join(shared + own, shared + 2 * own, 0, shared);
  join(shared + own, shared + 2 * own, shared + own, shared + 2 * own);
  for (Row v = shared + 2 * own; v < n; ++v) add_edge(rows, v - 1, v, 1.0);
  return Sparse(rows);
}

// A grid of squares in two triangles each, in the plane; sheared, its angles are obtuse.
inline Mesh sheared_grid(Index side, double shear) {
  Mesh mesh;
  for (Index row = 0; row < side; ++row)
    for (Index column = 0; column < side; ++column)
      for (const double x : {double(column) + shear * double(row), double(row), 0.0})
        mesh.vertices.push_back(x);
  for (Index row = 0; row + 1 < side; ++row) {
    for (Index column = 0; column + 1 < side; ++column) {
      const Index v = row * side + column;
      for (const Index corner : {v, v + 1, v + side, v + 1, v + side + 1, v + side})
        mesh.faces.push_back(corner);
    }
  }
  return mesh;
}

}  // namespace geodesic::testing
