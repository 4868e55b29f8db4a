// The workspace of a factorisation or of a solve.
#pragma once

#include "array.hpp"

namespace geodesic {

// An array of numbers without initial values.
//
// Memory from the system costs a page fault for every page. The memory of the last workspace is
// therefore kept for the next one, of any factor, up to a maximum size.
class Workspace {
 public:
  explicit Workspace(Index size);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  double* data() { return memory_.data(); }

 private:
  Array<double> memory_;
};

}  // namespace geodesic
