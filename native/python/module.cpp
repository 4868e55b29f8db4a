// The extension module of one level of processor.
#include "core/pool.hpp"
#include "core/vectors.hpp"
#include "python/bindings.hpp"

NB_MODULE(GT_MODULE, module) {
#if defined(NDEBUG)
  nb::set_leak_warnings(false);  // of objects that outlive the interpreter, as with pytest
#endif
  module.attr("LANES") = geodesic::kLanes;
  module.def(
      "empty",
      [](geodesic::Index size) {
        geodesic::require(size >= 0, "a number of numbers");
        return geodesic::give(geodesic::Array<double>(size));
      },
      "size"_a);
  module.def("trim", [] { geodesic::Pool::shared().trim(); });
  geodesic::bind_errors(module);
  geodesic::bind_matrix(module);
  geodesic::bind_linear(module);
  geodesic::bind_triangles(module);
  geodesic::bind_graphs(module);
  geodesic::bind_heat(module);
  geodesic::bind_wavefront(module);
  geodesic::bind_bounds(module);
  geodesic::bind_windows(module);
  geodesic::bind_clouds(module);
  geodesic::bind_paths(module);
}
