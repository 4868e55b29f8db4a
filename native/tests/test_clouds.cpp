// Poles and stars of clouds, of neighbours from a plain loop and normals away from the origin.
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "clouds/crowds.hpp"
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

std::vector<Index> nearest(std::span<const double> points) {
  const Index n = count(points) / 3;
  std::vector<Index> near;
  for (Index v = 0; v < n; ++v) {
    std::vector<std::pair<double, Index>> others;
    for (Index w = 0; w < n; ++w) {
      const Vector3 step = at(points, w) - at(points, v);
      if (w != v) others.push_back({dot(step, step), w});
    }
    std::partial_sort(others.begin(), others.begin() + kWidth, others.end());
    for (Index i = 0; i < kWidth; ++i) near.push_back(others[i].second);
  }
  return near;
}

std::vector<double> outwards(std::span<const double> points) {
  std::vector<double> normals(points.begin(), points.end());
  for (Index v = 0; v < count(points) / 3; ++v)
    for (Index c = 0; c < 3; ++c) normals[3 * v + c] /= length(at(points, v));
  return normals;
}

struct Example {
  std::vector<double> points;
  std::vector<Index> near = nearest(points);
  std::vector<double> normals = outwards(points);
  Cloud cloud{points, normals, near, kWidth};
};

template <class T>
bool are_same(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() &&
         (a.empty() ||
          std::memcmp(a.data(), b.data(), sizeof(T) * static_cast<std::size_t>(a.size())) == 0);
}

Stars stars_of(const Cloud& cloud, bool smooth, int n_threads) {
  std::vector<Index> centres(static_cast<std::size_t>(cloud.size()));
  std::iota(centres.begin(), centres.end(), Index{0});
  const std::vector<double> reaches(centres.size(), std::numeric_limits<double>::infinity());
  std::vector<double> weights = random_numbers(cloud.size(), 2);
  for (double& weight : weights) weight *= 1e-10;
  return delaunay_stars(cloud, {centres, reaches}, weights, {12, false, smooth}, n_threads);
}

}  // namespace

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
  }
}

TEST(neighbours_that_are_no_points_are_refused) {
  for (const Index wrong : {Index{-1}, kPoints, std::numeric_limits<Index>::max()}) {
    Example cloud{sphere(kPoints)};
    cloud.near[kWidth * kPoints - 1] = wrong;
    const std::string expected = "a neighbour is not a point of the cloud, which has 1100";
    using Error = std::invalid_argument;
    CHECK(message_of<Error>([&] { stars_of(cloud.cloud, true, 2); }) == expected);
    CHECK(message_of<Error>([&] { pole_normals(cloud.cloud, 2); }) == expected);
    CHECK(message_of<Error>([&] { crowd_reaches(cloud.cloud, 2); }) == expected);
    CHECK(message_of<Error>([&] { thinned(cloud.cloud, cloud.points); }) == expected);
  }
}

TEST(the_first_of_a_heap_stays) {
  std::vector<double> points;  // four heaps on a line, of which each point is near the first
  for (Index v = 0; v < kPoints; ++v)
    points.insert(points.end(), {static_cast<double>(v % 40), 1e-3 * (v / 40), 0.0});
  const Example heaps{points};
  const Array<double> reaches = crowd_reaches(heaps.cloud, 2);
  CHECK(are_same(reaches, crowd_reaches(heaps.cloud, 1)));
  std::vector<double> radii(kPoints, 0.02);
  radii[kPoints - 1] = 0.0;
  const Array<bool> kept = thinned(heaps.cloud, radii);
  CHECK(kept[0] && kept[kPoints - 1] && !kept[40]);
}
