#include "clouds/poles.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "core/threads.hpp"
#include "core/vectors.hpp"

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// How fast neighbours lose their say with distance; 1 is the ball, which a single point of a limb
// opposite can tilt.
constexpr double kPower = 1.25;

// Steps of the descent, from each of six directions.
constexpr int kSteps = 30;

// Neighbours whose elevation tells what place a point lies at.
constexpr std::size_t kClose = 12;

// Square of the sine of the elevation over a plane from which on a close neighbour puts the plane
// in doubt.
constexpr double kSteep = 0.5 * 0.5;

// Sine of the elevation below which all close neighbours lie where a point is a tip: there the air
// is all around, and the mean direction away from the neighbours is the better normal.
constexpr double kPointed = 0.1;

// Square of the sine of the elevation from which on a neighbour counts as off a plane, however far.
constexpr double kCapped = 0.25;

// Share of what the pole's plane leaves off up to which the plane at hand is kept: it fits its
// close neighbours far better. So does the plane of a sheet at its rim, which has air on its side.
constexpr double kBetter = 0.5;

// Cosine of the angle within which two normals are the same plane, and the one at hand is kept.
constexpr double kAgreed = 0.9;

Place operator*(double scale, const Place& a) { return {scale * a.x, scale * a.y, scale * a.z}; }
Place unit(const Place& a) {
  const double size = length(a);
  return {a.x / size, a.y / size, a.z / size};
}

// The places of the neighbours of a point, as seen from it.
void see(const Cloud& cloud, Index point, std::vector<Place>& seen) {
  seen.clear();
  for (const Index other : cloud.around(point))
    seen.push_back(at(cloud.points, other) - at(cloud.points, point));
}

std::span<const Place> close_ones(const std::vector<Place>& seen) {
  return std::span(seen).first(std::min(seen.size(), kClose));
}

// Whether a close neighbour is steep over the plane of a point.
bool is_doubtful(const Cloud& cloud, Index point) {
  const Place here = at(cloud.points, point), normal = at(cloud.normals, point);
  const std::span<const Index> near = cloud.around(point);
  for (const Index other : near.first(std::min(near.size(), kClose))) {
    const Place step = at(cloud.points, other) - here;
    const double rise = dot(step, normal);
    if (rise * rise > kSteep * dot(step, step)) return true;
  }
  return false;
}

// Directions that go down side by side, from three axes either way: a processor does a step of all
// of them in less time than two of one. Two go the way of others, because vectors have eight
// numbers.
class Descent {
 public:
  explicit Descent(const Place& normal) {
    const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
    const Place least = x <= y && x <= z ? Place{1, 0, 0}
                        : y <= z         ? Place{0, 1, 0}
                                         : Place{0, 0, 1};
    const Place across = unit(cross(normal, least));
    const Place axes[] = {normal, across, cross(normal, across), normal};
    for (int i = 0; i < kWays; ++i) {
      const Place axis = i % 2 == 0 ? axes[i / 2] : -1.0 * axes[i / 2];
      now_.set(i, axis);
      best_.set(i, axis);
      least_[i] = kInfinity;
    }
  }

  // Go by steps away from the foremost image, which become smaller, and return the best direction
  // on the way.
  Place pole(std::span<const Place> images) {
    for (int step = 0; step <= kSteps; ++step) {
      look(images);
      keep_best();
      move(0.7 / (1 + 0.35 * step));
    }
    int first = 0;
    for (int i = 1; i < kWays; ++i)
      if (least_[i] < least_[first]) first = i;
    return {best_.x[first], best_.y[first], best_.z[first]};
  }

 private:
  static constexpr int kWays = 8;

  struct Lanes {
    double x[kWays], y[kWays], z[kWays];
    void set(int i, const Place& place) {
      x[i] = place.x;
      y[i] = place.y;
      z[i] = place.z;
    }
  };

  // Find the foremost image in each direction.
  void look(std::span<const Place> images) {
    using Ways = Pack<kWays>;
    const Ways nx = Ways::load(now_.x), ny = Ways::load(now_.y), nz = Ways::load(now_.z);
    Ways front = Ways::spread(-kInfinity);
    Ways fx = Ways::zeros(), fy = Ways::zeros(), fz = Ways::zeros();
    for (const Place& image : images) {
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
    for (int i = 0; i < kWays; ++i) {
      const bool better = front_[i] < least_[i];
      least_[i] = better ? front_[i] : least_[i];
      best_.x[i] = better ? now_.x[i] : best_.x[i];
      best_.y[i] = better ? now_.y[i] : best_.y[i];
      best_.z[i] = better ? now_.z[i] : best_.z[i];
    }
  }

  void move(double stride) {
    for (int i = 0; i < kWays; ++i) {
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
  double front_[kWays], least_[kWays];
};

// The unit vector n that lessens n . x / |x|^(1 + kPower) of the foremost neighbour x.
//
// `images` is room for them.
Place pole(std::span<const Place> seen, const Place& normal, std::vector<Place>& images) {
  const double nearest = length(seen.front());
  images.clear();
  for (const Place& place : seen) {
    const double distance = length(place);
    images.push_back(std::pow(nearest / distance, kPower) / distance * place);
  }
  return Descent(normal).pole(images);
}

// How far unit vectors stand off a plane, squared and summed.
double left_off(std::span<const Place> directions, const Place& normal) {
  double sum = 0.0;
  for (const Place& direction : directions) {
    const double off = dot(direction, normal);
    sum += std::min(off * off, kCapped);
  }
  return sum;
}

// Makes one normal after the other, in memory of its own.
class PoleFinder {
 public:
  // The normal of a point, or its pole where that does better.
  Place better_normal(const Cloud& cloud, Index point);

 private:
  Place pole_or_tip(const Place& normal);

  std::vector<Place> seen_, images_, directions_;
};

// The pole, or the direction away from all neighbours where there is one.
Place PoleFinder::pole_or_tip(const Place& normal) {
  Place away{0, 0, 0};
  for (const Place& direction : directions_) away = away - direction;
  const double size = std::max(length(away) / static_cast<double>(directions_.size()), 1e-12);
  away = 1 / (size * static_cast<double>(directions_.size())) * away;
  const bool is_tip = std::all_of(directions_.begin(), directions_.end(),
                                  [&](const Place& one) { return dot(one, away) < -kPointed; });
  return is_tip ? away : pole(seen_, normal, images_);
}

Place PoleFinder::better_normal(const Cloud& cloud, Index point) {
  const Place normal = at(cloud.normals, point);
  see(cloud, point, seen_);
  directions_.clear();
  for (const Place& place : close_ones(seen_)) directions_.push_back(unit(place));
  const Place other = pole_or_tip(normal);
  const bool fits = left_off(directions_, normal) <= kBetter * left_off(directions_, other);
  return fits || std::abs(dot(other, normal)) > kAgreed ? normal : other;
}

}  // namespace

Array<double> pole_normals(const Cloud& cloud, int n_threads) {
  check_neighbours(cloud, n_threads);
  Array<double> result(3 * cloud.size());
  in_pieces(cloud.size(), kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    PoleFinder finder;
    for (Index v = begin; v < end; ++v) {
      const Place normal =
          is_doubtful(cloud, v) ? finder.better_normal(cloud, v) : at(cloud.normals, v);
      result[3 * v] = normal.x;
      result[3 * v + 1] = normal.y;
      result[3 * v + 2] = normal.z;
    }
  });
  return result;
}

}  // namespace geodesic
