// Errors of kernels, as the classes of geodesic_toolkit.errors.
#include "core/errors.hpp"
#include "python/bindings.hpp"

namespace geodesic {

void bind_errors(nb::module_&) {
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const SolverError& error) {
      const nb::object kind = nb::module_::import_("geodesic_toolkit.errors").attr("SolverError");
      PyErr_SetString(kind.ptr(), error.what());
    }
  });
}

}  // namespace geodesic
