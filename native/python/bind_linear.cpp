// The Cholesky solver in Python.
#include <nanobind/stl/shared_ptr.h>

#include "linear/factor.hpp"
#include "linear/front.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

template <class Class, class T>
auto field(Array<T> Class::* member) {
  return [member](nb::handle self) { return view(nb::cast<const Class&>(self).*member, self); };
}

}  // namespace

void bind_linear(nb::module_& module) {
  module.def(
      "is_symmetric",
      [](In<Row> indptr, In<Row> indices) {
        const Pattern pattern = pattern_of(indptr, indices);
        return unlocked([&] { return is_symmetric(pattern); });
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert());
  nb::class_<Elimination>(module, "Elimination")
      .def_prop_ro("order", field(&Elimination::order))
      .def_prop_ro("starts", field(&Elimination::starts))
      .def_prop_ro("heights", field(&Elimination::heights))
      .def_prop_ro("parents", field(&Elimination::parents))
      .def_ro("n_full", &Elimination::n_full);
  module.def(
      "minimum_degree",
      [](In<Row> indptr, In<Row> indices) {
        const Pattern pattern = pattern_of(indptr, indices);
        return unlocked([&] { return minimum_degree(pattern); });
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert());
  nb::class_<Analysis>(module, "Analysis")
      .def_prop_ro("order", field(&Analysis::order))
      .def_prop_ro("starts", field(&Analysis::starts))
      .def_prop_ro("lower_rows", field(&Analysis::lower_rows))
      .def_prop_ro("places", field(&Analysis::places))
      .def_prop_ro("first", field(&Analysis::first))
      .def_prop_ro("row_starts", field(&Analysis::row_starts))
      .def_prop_ro("rows", field(&Analysis::rows))
      .def_prop_ro("parents", field(&Analysis::parents))
      .def_prop_ro("panels", field(&Analysis::panels))
      .def_prop_ro("n_stored", &Analysis::n_stored)
      .def_prop_ro("nbytes", &Analysis::nbytes)
      .def("factor_bytes", &Factor::nbytes_needed, "compact"_a)
      .def(
          "in_pairs",
          [](const Analysis& self, In<Row> indptr) {
            require(!self.in_pairs && n_rows(indptr) == self.n_vertices() + 1 &&
                        indptr.data()[self.n_vertices()] == self.n_entries,
                    "the pattern that was analysed");
            return unlocked(
                [&] { return std::const_pointer_cast<Analysis>(in_pairs(self, span(indptr))); });
          },
          "indptr"_a.noconvert());
  module.def(
      "analyze",
      [](In<Row> indptr, In<Row> indices) {
        const Pattern pattern = pattern_of(indptr, indices);
        return unlocked([&] {
          return std::const_pointer_cast<Analysis>(analyze(pattern, minimum_degree(pattern)));
        });
      },
      "indptr"_a.noconvert(), "indices"_a.noconvert());
  nb::class_<Factor>(module, "Factor")
      .def(
          "__init__",
          [](Factor* self, std::shared_ptr<Analysis> analysis, In<double> data, bool compact) {
            require(n_rows(data) == analysis->n_entries,
                    "the data of a matrix with the pattern that was analysed");
            unlocked([&] { new (self) Factor(std::move(analysis), span(data), compact); });
          },
          "analysis"_a, "data"_a.noconvert(), "compact"_a = false)
      .def(
          "solve",
          [](const Factor& self, Columns b, nb::ndarray<double, nb::c_contig, nb::device::cpu> x) {
            const Index columns = n_columns(b);
            require(n_rows(b) == self.analysis().n_vertices() && have_one_shape(b, x),
                    "a row for each unknown, and workspace for as many solutions");
            unlocked([&] { self.solve(span(b), span(x), columns); });
          },
          "b"_a.noconvert(), "x"_a.noconvert())
      .def_prop_ro("nbytes", &Factor::nbytes)
      .def_prop_ro("panels", [](nb::handle self) -> nb::object {
        const Factor& factor = nb::cast<const Factor&>(self);
        if (factor.halves().empty()) return nb::cast(view(factor.numbers(), self));
        const std::size_t shape[] = {static_cast<std::size_t>(factor.halves().size())};
        return nb::cast(
            nb::ndarray<nb::numpy, const std::uint32_t>(&factor.halves()[0].upper, 1, shape, self));
      });
  module.def(
      "eliminate_front",
      [](Out<double> panel, Index height, Index width) {
        require(0 < width && width <= height && n_rows(panel) == height * width,
                "so many columns of so many rows");
        Array<double> update((height - width) * (height - width));
        Array<double> workspace(front::packed_size(height));
        const Index failed = unlocked([&] {
          return front::eliminate(panel.data(), update.data(), height, width, false,
                                  workspace.data());
        });
        return nb::make_tuple(failed, give(std::move(update)));
      },
      "panel"_a.noconvert(), "height"_a, "width"_a);
}

}  // namespace geodesic
