// The right-hand side of the Poisson step, for linear functions on triangles: gradient,
// normalisation and divergence in one pass, and nothing of the size of the faces is written.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Triangles with inverse frames, (F, 3), and areas.
struct Triangles {
  std::span<const Index> faces;
  std::span<const double> frames, measure;
};

// Return G' W X with X = -grad u / |grad u|, which is *minus* the integrated divergence of X, for
// columns of a table of heat u or log u by rows.
Array<double> poisson_load(const Triangles& triangles, std::span<const double> heat,
                           Index n_columns, bool logarithmic);

}  // namespace geodesic
