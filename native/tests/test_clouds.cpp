// Neighbours, normals, poles and stars of clouds, against plain loops.
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "clouds/neighbours.hpp"
#include "clouds/normals.hpp"
#include "clouds/poles.hpp"
#include "clouds/stars.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

constexpr Index kPoints = 1100;  // more than two pieces for threads
constexpr Index kWidth = 24;

std::vector<double> sphere(Index n_points) {
  std::vector<double> points = random_numbers(3 * n_points, 1, -1.0);
  for (Index v = 0; v < n_points; ++v) {
    const double size = length(at(points, v));
    for (Index c = 0; c < 3; ++c) points[3 * v + c] /= size;
  }
  return points;
}

// A square tube of which each side has points on a grid, some of them where others are.
std::vector<double> tube() {
  std::vector<double> points;
  for (Index v = 0; v < kPoints; ++v) {
    const double along = static_cast<double>(v / 4), across = v % 8 == 7 ? 0.0 : 0.4;
    points.insert(points.end(), {v % 2 == 0 ? across : -across, v % 4 < 2 ? 0.4 : -0.4, along});
  }
  return points;
}

struct Example {
  std::vector<double> points;
  Array<Index> near = nearest_neighbours(points, kWidth, 1);
  Neighbours neighbours{near, kWidth, kWidth};
  Array<double> normals = pca_normals(points, neighbours, 1);
  Cloud cloud{points, normals, neighbours};
};

template <class T>
bool are_same(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() &&
         (a.empty() ||
          std::memcmp(a.data(), b.data(), sizeof(T) * static_cast<std::size_t>(a.size())) == 0);
}

Stars stars_of(const Cloud& cloud, bool smooth, int n_threads) {
  return delaunay_stars(cloud, random_numbers(cloud.size(), 2), {12, false, smooth}, n_threads);
}

}  // namespace

TEST(neighbours_are_the_nearest_and_of_equals_the_first) {
  for (const std::vector<double>& points : {sphere(kPoints), tube()}) {
    const Array<Index> near = nearest_neighbours(points, kWidth, 1);
    for (Index v = 0; v < kPoints; v += 13) {
      std::vector<std::pair<double, Index>> others;
      for (Index w = 0; w < kPoints; ++w) {
        const Place step = at(points, w) - at(points, v);
        if (w != v) others.push_back({dot(step, step), w});
      }
      std::sort(others.begin(), others.end());
      for (Index i = 0; i < kWidth; ++i) {
        const Place step = at(points, near[v * kWidth + i]) - at(points, v);
        CHECK(std::abs(dot(step, step) - others[i].first) <= 1e-15);
      }
    }
  }
}

TEST(neighbours_are_found_where_squares_leave_the_range_of_numbers) {
  for (const double scale : {1e-200, 1e-162, 1e200}) {
    std::vector<double> points = sphere(200);
    for (double& x : points) x *= scale;
    for (const Index other : nearest_neighbours(points, 9, 1)) CHECK(other >= 0 && other < 200);
  }
  const std::vector<double> two{0, 0, 0, 0, 0, 0};
  const Array<Index> near = nearest_neighbours(two, 1, 4);
  CHECK(near[0] == 1 && near[1] == 0);
}

TEST(neighbours_that_there_are_not_are_refused) {
  const std::vector<double> points = sphere(5);
  for (const Index k : {-1, 0, 5})
    CHECK(message_of<std::invalid_argument>([&] {
            nearest_neighbours(points, k, 1);
          }).find("fewer") != std::string::npos);
  std::vector<double> hollow = points;
  hollow[7] = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of<std::invalid_argument>([&] { nearest_neighbours(hollow, 2, 1); }) ==
        "a point is not finite");
}

TEST(normals_of_a_sphere_are_its_radii) {
  const Example sphere_cloud{sphere(kPoints)};
  double worst = 1.0;
  for (Index v = 0; v < kPoints; ++v)
    worst = std::min(worst, std::abs(dot(at(sphere_cloud.normals, v), at(sphere_cloud.points, v))));
  CHECK(worst > 0.9);
}

TEST(normals_are_units_where_points_are_on_a_line_or_at_one_place) {
  std::vector<double> line(90, 0.0);
  for (Index v = 0; v < 30; ++v) line[3 * v] = line[3 * v + 1] = static_cast<double>(v);
  for (const std::vector<double>& points : {line, std::vector<double>(90, 0.25)}) {
    const Array<Index> near = nearest_neighbours(points, 8, 1);
    const Array<double> normals = pca_normals(points, {near, 8, 8}, 1);
    for (Index v = 0; v < 30; ++v) {
      CHECK(std::abs(length(at(normals, v)) - 1) < 1e-14);
      CHECK(std::abs(dot(at(normals, v), at(line, 1))) < 1e-14 || points != line);
    }
  }
}

TEST(stars_of_a_sphere_surround_their_points) {
  const Example sphere_cloud{sphere(kPoints)};
  const Stars stars = stars_of(sphere_cloud.cloud, true, 1);
  CHECK(std::count(stars.is_open.begin(), stars.is_open.end(), true) < kPoints / 20);
  CHECK(stars.triangles.size() == stars.frames.size());
  std::vector<double> turn(kPoints, 0.0);  // the angles around each point
  for (Index e = 0; e < stars.triangles.size(); e += 3) {
    const double a = stars.frames[e + 1], b = stars.frames[e + 2];
    CHECK(stars.frames[e] > 0 && b > 0);
    turn[stars.triangles[e]] += std::atan2(b, a);
  }
  for (Index v = 0; v < kPoints; ++v)
    CHECK(stars.is_open[v] || std::abs(turn[v] - 2 * std::acos(-1.0)) < 1e-9);
}

TEST(kernels_of_clouds_give_the_same_bits_on_any_number_of_threads) {
  for (const std::vector<double>& points : {sphere(kPoints), tube()}) {
    const Example one{points};
    const Stars stars = stars_of(one.cloud, false, 1);
    const Array<double> poles = pole_normals(one.cloud, 1);
    for (const int n_threads : {2, 5}) {
      CHECK(are_same(one.near, nearest_neighbours(points, kWidth, n_threads)));
      CHECK(are_same(one.normals, pca_normals(points, one.neighbours, n_threads)));
      CHECK(are_same(poles, pole_normals(one.cloud, n_threads)));
      const Stars several = stars_of(one.cloud, false, n_threads);
      CHECK(are_same(stars.triangles, several.triangles));
      CHECK(are_same(stars.frames, several.frames));
      CHECK(are_same(stars.is_open, several.is_open));
    }
  }
}

TEST(clouds_of_rubbish_make_no_other_indices) {
  for (const double bad : {0.0, 1e300, std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()}) {
    Example rubbish{sphere(kPoints)};
    for (Index i = 0; i < 3 * kPoints; i += 7) rubbish.points[i] = rubbish.normals[i] = bad;
    for (const bool smooth : {false, true})
      for (const Index corner : stars_of(rubbish.cloud, smooth, 2).triangles)
        CHECK(corner >= 0 && corner < kPoints);
    CHECK(pole_normals(rubbish.cloud, 2).size() == 3 * kPoints);
    CHECK(pca_normals(rubbish.points, rubbish.neighbours, 2).size() == 3 * kPoints);
  }
}

TEST(neighbours_that_are_no_points_are_refused) {
  for (const Index wrong : {Index{-1}, kPoints, std::numeric_limits<Index>::max()}) {
    Example cloud{sphere(kPoints)};
    cloud.near[kWidth * kPoints - 1] = wrong;
    const std::string expected = "a neighbour is no point of the cloud, which has 1100";
    using Error = std::invalid_argument;
    CHECK(message_of<Error>([&] { stars_of(cloud.cloud, true, 2); }) == expected);
    CHECK(message_of<Error>([&] { pole_normals(cloud.cloud, 2); }) == expected);
    CHECK(message_of<Error>([&] { pca_normals(cloud.points, cloud.neighbours, 2); }) == expected);
  }
}
