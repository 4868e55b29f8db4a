// Errors that Python knows by their classes.
#pragma once

#include <stdexcept>

namespace geodesic {

// A system that has no solution in floating point; `SolverError` in Python.
struct SolverError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace geodesic
