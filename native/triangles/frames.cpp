#include "triangles/frames.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "triangles/measures.hpp"
#include "triangles/vector3.hpp"

namespace geodesic {
namespace {

// Cosine of the angle between two normals, plus one, from which on the least rotation between them
// is taken to be known.
constexpr double kOpposite = 1e-9;

Index next(Index half) { return half % 3 == 2 ? half - 2 : half + 1; }
Index previous(Index half) { return half % 3 == 0 ? half + 2 : half - 1; }

void put(Array<double>& table, Index row, const Vector3& a) {
  table[3 * row] = a.x;
  table[3 * row + 1] = a.y;
  table[3 * row + 2] = a.z;
}

double angle_at(std::span<const double> lengths, Index corner) {
  return angle_between(lengths[next(corner)], lengths[previous(corner)], lengths[corner]);
}

// The corners about one vertex from one end of the surface to the other, or around all of it.
class Fan {
 public:
  Fan(std::span<const double> lengths, std::span<const Index> twin)
      : lengths_(lengths), twin_(twin) {}

  // Counter-clockwise as the faces run, from the corner that is the first in its direction.
  void walk(Index corner) {
    corners_.clear();
    before_.clear();
    total_ = 0.0;
    is_closed_ = false;
    Index start = corner;
    while (true) {
      const Index mate = twin_[previous(start)];
      if (mate < 0) break;
      start = previous(mate);
      if (start == corner) {
        is_closed_ = true;
        break;
      }
    }
    for (Index at = start;;) {
      corners_.push_back(at);
      before_.push_back(total_);
      total_ += angle_at(lengths_, at);
      const Index mate = twin_[next(at)];
      if (mate < 0) break;
      at = next(mate);
      if (at == start) break;
    }
  }
  std::span<const Index> corners() const { return corners_; }
  double angle_before(std::size_t place) const { return before_[place]; }
  double total() const { return total_; }
  double scale() const { return is_closed_ ? 2 * std::numbers::pi / total_ : 1.0; }
  bool is_closed() const { return is_closed_; }

 private:
  std::span<const double> lengths_;
  std::span<const Index> twin_;
  std::vector<Index> corners_;
  std::vector<double> before_;
  double total_ = 0.0;
  bool is_closed_ = false;
};

// The angle by which directions must be turned to fit steps in space best.
class Fit {
 public:
  Fit(const Vector3& x, const Vector3& y) : x_(x), y_(y) {}
  void add(const Vector3& step, double direction) {
    const double along = dot(step, x_), aside = dot(step, y_);
    const double size = std::sqrt(along * along + aside * aside);
    if (!(size > 0)) return;
    const double c = std::cos(direction), s = std::sin(direction);
    real_ += (along * c + aside * s) / size;
    imaginary_ += (aside * c - along * s) / size;
  }
  double turn() const { return std::atan2(imaginary_, real_); }

 private:
  Vector3 x_, y_;
  double real_ = 0.0, imaginary_ = 0.0;
};

}  // namespace

Array<double> tangent_axes(std::span<const double> normals) {
  Array<double> axes(count(normals));
  for (Index v = 0; v < count(normals) / 3; ++v) {
    const Vector3 n = at(normals, v);
    const double sign = n.z >= 0 ? 1.0 : -1.0, c = -1 / (sign + n.z);
    put(axes, v, {1 + sign * n.x * n.x * c, 0.0 + sign * n.x * n.y * c, 0.0 - sign * n.x});
  }
  return axes;
}

Directions polar_directions(std::span<const double> vertices, std::span<const Index> faces,
                            std::span<const double> lengths, std::span<const Index> twin,
                            std::span<const bool> mirrored, std::span<const double> normals,
                            std::span<const double> axes) {
  const Index n_corners = count(faces);
  Directions result{Array<double>(n_corners), Array<double>(n_corners)};
  Array<bool> done(n_corners, false);
  Fan fan(lengths, twin);
  for (Index corner = 0; corner < n_corners; ++corner) {
    if (done[corner]) continue;
    fan.walk(corner);
    const Index v = faces[corner];
    const double scale = mirrored[corner / 3] ? -fan.scale() : fan.scale();
    const Vector3 here = at(vertices, v), x = at(axes, v);
    Fit fit(x, cross(at(normals, v), x));
    const std::span<const Index> around = fan.corners();
    for (std::size_t k = 0; k < around.size(); ++k) {
      done[around[k]] = true;
      fit.add(at(vertices, faces[next(around[k])]) - here, scale * fan.angle_before(k));
    }
    if (!fan.is_closed())
      fit.add(at(vertices, faces[previous(around.back())]) - here, scale * fan.total());
    const double turn = fit.turn();
    for (std::size_t k = 0; k < around.size(); ++k) {
      const Index half = previous(around[k]);  // which leaves the corner
      result.angles[half] = turn + scale * fan.angle_before(k);
      result.scales[half] = scale;
    }
  }
  return result;
}

Array<double> bisectors(std::span<const double> lengths, std::span<const double> angles,
                        std::span<const double> scales) {
  Array<double> result(count(lengths));
  for (Index corner = 0; corner < count(lengths); ++corner) {
    const Index half = previous(corner);
    result[corner] = angles[half] + scales[half] * angle_at(lengths, corner) / 2;
  }
  return result;
}

Array<double> triangle_turns(std::span<const double> lengths, std::span<const double> bisectors,
                             std::span<const bool> mirrored) {
  Array<double> turns(2 * count(lengths));
  for (Index f = 0; f < count(lengths); f += 3) {
    double angle[3];
    for (int c = 0; c < 3; ++c) angle[c] = angle_at(lengths, f + c);
    const double inside[3] = {angle[0] / 2, std::numbers::pi - angle[1] / 2,
                              std::numbers::pi + angle[0] + angle[2] / 2};
    for (int c = 0; c < 3; ++c) {
      const double turn = (mirrored[f / 3] ? -inside[c] : inside[c]) - bisectors[f + c];
      turns[2 * (f + c)] = std::cos(turn);
      turns[2 * (f + c) + 1] = std::sin(turn);
    }
  }
  return turns;
}

SpaceTurns space_turns(std::span<const double> places, std::span<const Index> elements, int size,
                       std::span<const double> normals, std::span<const double> axes, bool stars) {
  const Index n_elements = count(elements) / size;
  SpaceTurns result{Array<double>(2 * count(elements)), Array<bool>(n_elements, false)};
  for (Index e = 0; e < n_elements; ++e) {
    const Index* const corner = elements.data() + size * e;
    const Vector3 step = at(places, corner[1]) - at(places, corner[0]),
                  first = at(normals, corner[0]);
    Vector3 normal = first;
    if (size == 2 || corner[1] == corner[2]) {
      normal = unit(sum(first, at(normals, corner[1])), first);
    } else {
      const Vector3 own = cross(step, at(places, corner[2]) - at(places, corner[0]));
      double side = dot(own, first);
      if (!stars) {
        for (int c = 1; c < 3; ++c) side += dot(own, at(normals, corner[c]));
        normal = unit(scaled(own, side < 0 ? -1 : 1), first);
      }
      result.mirrored[e] = side < 0;
    }
    const Vector3 aside = step - scaled(normal, dot(step, normal));
    const Vector3 x = unit(aside, at(axes, corner[0])), y = cross(normal, x);
    for (int c = 0; c < size; ++c) {
      const Vector3 theirs = at(normals, corner[c]), axis = at(axes, corner[c]);
      const double share = dot(normal, axis) / std::max(1 + dot(normal, theirs), kOpposite);
      const Vector3 moved = axis - scaled(sum(theirs, normal), share);
      const double along = dot(moved, x), up = dot(moved, y), long_ = std::hypot(along, up);
      double* const turn = result.turns.data() + 2 * (size * e + c);
      turn[0] = long_ > 0 ? along / long_ : 1.0;
      turn[1] = long_ > 0 ? up / long_ : 0.0;
    }
  }
  return result;
}

}  // namespace geodesic
