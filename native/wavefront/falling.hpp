// The order in which a front comes to vertices, as heat tells it.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// The order in which values fall as far as nine digits tell, and then by number.
Array<Row> falling(std::span<const double> values);

}  // namespace geodesic
