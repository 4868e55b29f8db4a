#include "clouds/poles.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "core/threads.hpp"
#include "core/vectors.hpp"

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Exponent by which the weight of a neighbour falls with its distance. With 1, the inscribed ball,
// a single point of an opposite limb can tilt the normal.
constexpr double kDistanceExponent = 1.25;

// Steps of the descent from each of the six starting directions.
constexpr int kDescentSteps = 30;

// Number of nearest neighbours whose elevations show whether a point lies on a sheet or at a tip.
constexpr std::size_t kCloseNeighbours = 12;

// Square of the sine of the elevation over a plane above which a close neighbour makes the plane
// doubtful.
constexpr double kMinSquaredSineOfDoubt = 0.5 * 0.5;

// Sine of the elevation below which all close neighbours of a tip lie. A tip is surrounded by empty
// space, and the mean direction away from its neighbours is the better normal.
constexpr double kMaxSineAtTip = 0.1;

// Square of the sine of the elevation at which the residual of a neighbour is capped.
constexpr double kMaxSquaredSineOffPlane = 0.25;

// The given plane is kept if its residual is at most this share of the residual of the pole's
// plane: it fits the close neighbours far better. This holds at the rim of a sheet, too, beside
// which there is empty space.
constexpr double kMaxResidualRatio = 0.5;

// Cosine of the angle within which two normals count as one plane; the given normal is kept.
constexpr double kMinCosineOfSamePlane = 0.9;

Vector3 operator*(double scale, const Vector3& a) {
  return {scale * a.x, scale * a.y, scale * a.z};
}
Vector3 unit(const Vector3& a) {
  const double size = length(a);
  return {a.x / size, a.y / size, a.z / size};
}

// The positions of the neighbours of a point, relative to it.
void see(const Cloud& cloud, Index point, std::vector<Vector3>& seen) {
  seen.clear();
  for (const Index other : cloud.around(point))
    seen.push_back(at(cloud.points, other) - at(cloud.points, point));
}

std::span<const Vector3> close_ones(const std::vector<Vector3>& seen) {
  return std::span(seen).first(std::min(seen.size(), kCloseNeighbours));
}

// True if a close neighbour has a steep elevation over the plane of a point.
bool is_doubtful(const Cloud& cloud, Index point) {
  const Vector3 here = at(cloud.points, point), normal = at(cloud.normals, point);
  const std::span<const Index> near = cloud.around(point);
  for (const Index other : near.first(std::min(near.size(), kCloseNeighbours))) {
    const Vector3 step = at(cloud.points, other) - here;
    const double rise = dot(step, normal);
    if (rise * rise > kMinSquaredSineOfDoubt * dot(step, step)) return true;
  }
  return false;
}

// Number of directions that descend side by side: both directions of three axes. A processor does
// a step of all of them in less time than two steps of one. Two of the eight repeat others, because
// vectors have eight numbers.
class Descent {
 public:
  explicit Descent(const Vector3& normal) {
    const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
    const Vector3 least = x <= y && x <= z ? Vector3{1, 0, 0}
                          : y <= z         ? Vector3{0, 1, 0}
                                           : Vector3{0, 0, 1};
    const Vector3 across = unit(cross(normal, least));
    const Vector3 axes[] = {normal, across, cross(normal, across), normal};
    for (int i = 0; i < kDirections; ++i) {
      const Vector3 axis = i % 2 == 0 ? axes[i / 2] : -1.0 * axes[i / 2];
      now_.set(i, axis);
      best_.set(i, axis);
      least_[i] = kInfinity;
    }
  }

  // Descend by steps of decreasing size away from the foremost image, and return the best direction
  // found.
  Vector3 pole(std::span<const Vector3> images) {
    for (int step = 0; step <= kDescentSteps; ++step) {
      look(images);
      keep_best();
      move(0.7 / (1 + 0.35 * step));
    }
    int first = 0;
    for (int i = 1; i < kDirections; ++i)
      if (least_[i] < least_[first]) first = i;
    return {best_.x[first], best_.y[first], best_.z[first]};
  }

 private:
  static constexpr int kDirections = 8;

  struct Lanes {
    double x[kDirections], y[kDirections], z[kDirections];
    void set(int i, const Vector3& place) {
      x[i] = place.x;
      y[i] = place.y;
      z[i] = place.z;
    }
  };

  // Find the foremost image in each direction.
  void look(std::span<const Vector3> images) {
    using Ways = Pack<kDirections>;
    const Ways nx = Ways::load(now_.x), ny = Ways::load(now_.y), nz = Ways::load(now_.z);
    Ways front = Ways::spread(-kInfinity);
    Ways fx = Ways::zeros(), fy = Ways::zeros(), fz = Ways::zeros();
    for (const Vector3& image : images) {
      const Ways x = Ways::spread(image.x), y = Ways::spread(image.y), z = Ways::spread(image.z);
      const Ways ahead = x * nx + y * ny + z * nz;
      fx = choose(front, ahead, x, fx);
      fy = choose(front, ahead, y, fy);
      fz = choose(front, ahead, z, fz);
      front = choose(front, ahead, ahead, front);
    }
    front.store(front_);
    fx.store(foremost_.x);
    fy.store(foremost_.y);
    fz.store(foremost_.z);
  }

  void keep_best() {
    for (int i = 0; i < kDirections; ++i) {
      const bool better = front_[i] < least_[i];
      least_[i] = better ? front_[i] : least_[i];
      best_.x[i] = better ? now_.x[i] : best_.x[i];
      best_.y[i] = better ? now_.y[i] : best_.y[i];
      best_.z[i] = better ? now_.z[i] : best_.z[i];
    }
  }

  void move(double stride) {
    for (int i = 0; i < kDirections; ++i) {
      const double gx = foremost_.x[i] - front_[i] * now_.x[i];
      const double gy = foremost_.y[i] - front_[i] * now_.y[i];
      const double gz = foremost_.z[i] - front_[i] * now_.z[i];
      const double slope = std::sqrt(gx * gx + gy * gy + gz * gz);
      const double share = slope < 1e-9 ? 0.0 : stride / slope;
      const double x = now_.x[i] - share * gx, y = now_.y[i] - share * gy,
                   z = now_.z[i] - share * gz;
      const double size = std::sqrt(x * x + y * y + z * z);
      now_.x[i] = x / size;
      now_.y[i] = y / size;
      now_.z[i] = z / size;
    }
  }

  Lanes now_, best_, foremost_{};
  double front_[kDirections], least_[kDirections];
};

// The unit vector n that minimises n . x / |x|^(1 + kDistanceExponent) of the foremost neighbour x.
//
// `images` is workspace for them.
Vector3 pole(std::span<const Vector3> seen, const Vector3& normal, std::vector<Vector3>& images) {
  const double nearest = length(seen.front());
  images.clear();
  for (const Vector3& place : seen) {
    const double distance = length(place);
    images.push_back(std::pow(nearest / distance, kDistanceExponent) / distance * place);
  }
  return Descent(normal).pole(images);
}

// The sum of squared sines of the elevations of unit vectors over a plane.
double left_off(std::span<const Vector3> directions, const Vector3& normal) {
  double sum = 0.0;
  for (const Vector3& direction : directions) {
    const double off = dot(direction, normal);
    sum += std::min(off * off, kMaxSquaredSineOffPlane);
  }
  return sum;
}

// Computes one normal after the other, with its own memory.
class PoleFinder {
 public:
  // The given normal of a point, or its pole where that fits better.
  Vector3 better_normal(const Cloud& cloud, Index point);

 private:
  Vector3 pole_or_tip(const Vector3& normal);

  std::vector<Vector3> seen_, images_, directions_;
};

// The pole, or the direction away from all neighbours where there is one.
Vector3 PoleFinder::pole_or_tip(const Vector3& normal) {
  Vector3 away{0, 0, 0};
  for (const Vector3& direction : directions_) away = away - direction;
  const double size = std::max(length(away) / static_cast<double>(directions_.size()), 1e-12);
  away = 1 / (size * static_cast<double>(directions_.size())) * away;
  const bool is_tip = std::all_of(directions_.begin(), directions_.end(), [&](const Vector3& one) {
    return dot(one, away) < -kMaxSineAtTip;
  });
  return is_tip ? away : pole(seen_, normal, images_);
}

Vector3 PoleFinder::better_normal(const Cloud& cloud, Index point) {
  const Vector3 normal = at(cloud.normals, point);
  see(cloud, point, seen_);
  directions_.clear();
  for (const Vector3& place : close_ones(seen_)) directions_.push_back(unit(place));
  const Vector3 other = pole_or_tip(normal);
  const bool fits =
      left_off(directions_, normal) <= kMaxResidualRatio * left_off(directions_, other);
  return fits || std::abs(dot(other, normal)) > kMinCosineOfSamePlane ? normal : other;
}

}  // namespace

Array<double> pole_normals(const Cloud& cloud, int n_threads) {
  check_neighbours(cloud, n_threads);
  Array<double> result(3 * cloud.size());
  in_pieces(cloud.size(), kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    PoleFinder finder;
    for (Index v = begin; v < end; ++v) {
      const Vector3 normal =
          is_doubtful(cloud, v) ? finder.better_normal(cloud, v) : at(cloud.normals, v);
      result[3 * v] = normal.x;
      result[3 * v + 1] = normal.y;
      result[3 * v + 2] = normal.z;
    }
  });
  return result;
}

}  // namespace geodesic
