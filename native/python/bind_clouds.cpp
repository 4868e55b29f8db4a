// clouds
#include "python/bindings.hpp"

namespace geodesic {

void bind_clouds(nb::module_&) {}

}  // namespace geodesic
