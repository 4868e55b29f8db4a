// Point clouds in Python.
#include "clouds/crowds.hpp"
#include "clouds/poles.hpp"
#include "clouds/stars.hpp"
#include "python/bindings.hpp"

namespace geodesic {
namespace {

Cloud cloud_of(const In<double, 2>& points, const In<Index, 2>& neighbours) {
  require(points.shape(1) == 3, "three coordinates for each point");
  return {span(points), {}, span(neighbours), static_cast<Index>(neighbours.shape(1))};
}

Cloud cloud_of(const In<double, 2>& points, const In<double, 2>& normals,
               const In<Index, 2>& neighbours) {
  require(normals.shape(1) == 3 && n_rows(normals) == n_rows(points), "a normal for each point");
  Cloud cloud = cloud_of(points, neighbours);
  cloud.normals = span(normals);
  return cloud;
}

void require_all(const In<double, 2>& points, const In<Index, 2>& neighbours) {
  require(n_rows(neighbours) == n_rows(points), "neighbours for each point");
}

}  // namespace

void bind_clouds(nb::module_& module) {
  module.def(
      "delaunay_stars",
      [](In<double, 2> points, In<double, 2> normals, In<Index> centres, In<Index, 2> neighbours,
         In<double> reaches, In<double> weights, Index k, bool oriented, bool smooth,
         int n_threads) {
        const Cloud cloud = cloud_of(points, normals, neighbours);
        require(n_rows(weights) == cloud.size(), "a weight for each point");
        require(n_rows(neighbours) == n_rows(centres) && n_rows(reaches) == n_rows(centres),
                "neighbours and a reach for each centre");
        Stars stars = unlocked([&] {
          return delaunay_stars(cloud, {span(centres), span(reaches)}, span(weights),
                                {k, oriented, smooth}, n_threads);
        });
        return nb::make_tuple(give(std::move(stars.triangles), 3), give(std::move(stars.frames), 3),
                              give(std::move(stars.is_open)));
      },
      "points"_a.noconvert(), "normals"_a.noconvert(), "centres"_a.noconvert(),
      "neighbours"_a.noconvert(), "reaches"_a.noconvert(), "weights"_a.noconvert(), "k"_a,
      "oriented"_a, "smooth"_a, "n_threads"_a);
  module.def(
      "pole_normals",
      [](In<double, 2> points, In<Index, 2> neighbours, In<double, 2> normals, int n_threads) {
        const Cloud cloud = cloud_of(points, normals, neighbours);
        require_all(points, neighbours);
        return give(unlocked([&] { return pole_normals(cloud, n_threads); }), 3);
      },
      "points"_a.noconvert(), "neighbours"_a.noconvert(), "normals"_a.noconvert(), "n_threads"_a);
  module.def(
      "crowd_reaches",
      [](In<double, 2> points, In<Index, 2> neighbours, int n_threads) {
        const Cloud cloud = cloud_of(points, neighbours);
        require_all(points, neighbours);
        return give(unlocked([&] { return crowd_reaches(cloud, n_threads); }));
      },
      "points"_a.noconvert(), "neighbours"_a.noconvert(), "n_threads"_a);
  module.def(
      "thinned",
      [](In<double, 2> points, In<Index, 2> neighbours, In<double> radii) {
        const Cloud cloud = cloud_of(points, neighbours);
        require_all(points, neighbours);
        require(n_rows(radii) == cloud.size(), "a radius for each point");
        return give(unlocked([&] { return thinned(cloud, span(radii)); }));
      },
      "points"_a.noconvert(), "neighbours"_a.noconvert(), "radii"_a.noconvert());
}

}  // namespace geodesic
