// wavefront
#include "python/bindings.hpp"

namespace geodesic {

void bind_wavefront(nb::module_&) {}

}  // namespace geodesic
