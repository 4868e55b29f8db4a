// Point clouds in Python.
#include "clouds/poles.hpp"
#include "clouds/stars.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

Cloud cloud_of(const In<double, 2>& points, const In<double, 2>& normals,
               const In<Index, 2>& neighbours) {
  require(points.shape(1) == 3 && normals.shape(1) == 3 && n_rows(normals) == n_rows(points),
          "three coordinates and a normal for each point");
  require(n_rows(neighbours) == n_rows(points), "neighbours for each point");
  return {span(points), span(normals), span(neighbours), static_cast<Index>(neighbours.shape(1))};
}

}  // namespace

void bind_clouds(nb::module_& module) {
  module.def(
      "delaunay_stars",
      [](In<double, 2> points, In<double, 2> normals, In<Index, 2> neighbours, In<double> shares,
         Index k, bool oriented, bool smooth, int n_threads) {
        const Cloud cloud = cloud_of(points, normals, neighbours);
        require(n_rows(shares) == cloud.size(), "a share for each point");
        Stars stars = unlocked(
            [&] { return delaunay_stars(cloud, span(shares), {k, oriented, smooth}, n_threads); });
        return nb::make_tuple(give(std::move(stars.triangles), 3), give(std::move(stars.frames), 3),
                              give(std::move(stars.is_open)));
      },
      "points"_a.noconvert(), "normals"_a.noconvert(), "neighbours"_a.noconvert(),
      "shares"_a.noconvert(), "k"_a, "oriented"_a, "smooth"_a, "n_threads"_a);
  module.def(
      "pole_normals",
      [](In<double, 2> points, In<Index, 2> neighbours, In<double, 2> normals, int n_threads) {
        const Cloud cloud = cloud_of(points, normals, neighbours);
        return give(unlocked([&] { return pole_normals(cloud, n_threads); }), 3);
      },
      "points"_a.noconvert(), "neighbours"_a.noconvert(), "normals"_a.noconvert(), "n_threads"_a);
}

}  // namespace geodesic
