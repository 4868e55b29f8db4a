// Room to work in for a factorisation or a solve.
#pragma once

#include "array.hpp"

namespace geodesic {

// Numbers to work in, in which anything may stand.
//
// Memory from the system comes with a fault for every page. So that of the last one is kept for the
// next, of whichever factor, up to a size.
class Room {
 public:
  explicit Room(Index size);
  ~Room();
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;
  double* data() { return memory_.data(); }

 private:
  Array<double> memory_;
};

}  // namespace geodesic
