#include "triangles/frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/angles.hpp"
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

// The half-edges that leave each vertex, fan by fan: from one end of the surface to the other, or
// around all of it, counter-clockwise as the faces run.
class Fans {
 public:
  struct Spoke {
    Index half, head;  // the half-edge, or -1 of the last edge of a fan that does not close
  };

  Fans(std::span<const Index> faces, std::span<const double> lengths, std::span<const Index> twin,
       std::span<const bool> mirrored)
      : faces_(faces), twin_(twin), angles_(corner_angles(lengths)), done_(count(faces), false) {
    const Index most = count(faces) + std::ranges::count_if(twin, [](Index t) { return t < 0; });
    spokes_ = Array<Spoke>(most);
    directions_ = Array<double>(most);
    starts_ = Array<Index>(count(faces) + 1);
    scales_ = Array<double>(count(faces));
    for (Index corner = 0; corner < count(faces); ++corner)
      if (!done_[corner]) walk(corner, mirrored[corner / 3] ? -1.0 : 1.0);
    starts_[n_fans_] = n_;
  }

  Index n_fans() const { return n_fans_; }
  Index n_spokes() const { return n_; }
  Index begin(Index fan) const { return starts_[fan]; }
  Index end(Index fan) const { return starts_[fan + 1]; }
  const Spoke& spoke(Index place) const { return spokes_[place]; }
  Index tail(Index fan) const { return faces_[next(spokes_[starts_[fan]].half)]; }
  // Scaled angles from the first half-edge of the fan, and the factor between these and angles.
  double direction(Index place) const { return directions_[place]; }
  double scale(Index fan) const { return scales_[fan]; }

 private:
  void walk(Index corner, double sign) {
    starts_[n_fans_] = n_;
    double total = 0.0;
    Index start = corner, at = corner;
    const auto go_around = [&] {
      for (at = start;;) {
        done_[at] = true;
        spokes_[n_] = {previous(at), faces_[next(at)]};
        directions_[n_++] = total;
        total += angles_[at];
        const Index mate = twin_[next(at)];
        if (mate < 0) return false;
        at = next(mate);
        if (at == start) return true;
      }
    };
    const bool closes = go_around();
    if (!closes) {
      for (Index mate; (mate = twin_[previous(start)]) >= 0;) start = previous(mate);
      if (start != corner) {
        n_ = starts_[n_fans_];
        total = 0.0;
        go_around();
      }
      spokes_[n_] = {-1, faces_[previous(at)]};
      directions_[n_++] = total;
    }
    const double scale = sign * (closes ? 2 * kPi / total : 1.0);
    for (Index k = starts_[n_fans_]; k < n_; ++k) directions_[k] *= scale;
    scales_[n_fans_++] = scale;
  }

  std::span<const Index> faces_, twin_;
  Array<double> angles_;
  Array<bool> done_;
  Array<Spoke> spokes_;
  Array<double> directions_, scales_;
  Array<Index> starts_;
  Index n_ = 0, n_fans_ = 0;
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

Array<double> unit_vectors(std::span<const double> angles) {
  Array<double> pairs(2 * count(angles));
  for (Index k = 0; k < count(angles); ++k) {
    const auto [cosine, sine] = cosine_and_sine(angles[k]);
    pairs[2 * k] = cosine;
    pairs[2 * k + 1] = sine;
  }
  return pairs;
}

Array<double> to_space(std::span<const double> pairs, std::span<const double> x_axes,
                       std::span<const double> y_axes) {
  Array<double> result(count(x_axes));
  for (Index v = 0; v < count(x_axes) / 3; ++v)
    for (Index d = 3 * v; d < 3 * v + 3; ++d)
      result[d] = pairs[2 * v] * x_axes[d] + pairs[2 * v + 1] * y_axes[d];
  return result;
}

Directions polar_directions(std::span<const double> vertices, std::span<const Index> faces,
                            std::span<const double> lengths, std::span<const Index> twin,
                            std::span<const bool> mirrored, std::span<const double> normals,
                            std::span<const double> axes) {
  const Fans fans(faces, lengths, twin, mirrored);
  // Each step in space as a complex number in the frame, of length 1, over its direction.
  Array<double> real(fans.n_spokes()), imaginary(fans.n_spokes());
  for (Index fan = 0; fan < fans.n_fans(); ++fan) {
    const Index v = fans.tail(fan);
    const Vector3 here = at(vertices, v), x = at(axes, v), y = cross(at(normals, v), x);
    for (Index k = fans.begin(fan); k < fans.end(fan); ++k) {
      const Vector3 step = at(vertices, fans.spoke(k).head) - here;
      real[k] = dot(step, x);
      imaginary[k] = dot(step, y);
    }
  }
  for (Index k = 0; k < fans.n_spokes(); ++k) {
    const auto [cosine, sine] = cosine_and_sine(fans.direction(k));
    const double along = real[k], aside = imaginary[k];
    const double size = std::sqrt(along * along + aside * aside);
    const double share = size > 0 ? 1 / size : 0.0;
    real[k] = share * (along * cosine + aside * sine);
    imaginary[k] = share * (aside * cosine - along * sine);
  }
  Directions result{Array<double>(count(faces)), Array<double>(count(faces))};
  for (Index fan = 0; fan < fans.n_fans(); ++fan) {
    double along = 0.0, aside = 0.0;
    for (Index k = fans.begin(fan); k < fans.end(fan); ++k) {
      along += real[k];
      aside += imaginary[k];
    }
    const double turn = std::atan2(aside, along);
    for (Index k = fans.begin(fan); k < fans.end(fan); ++k) {
      const Index half = fans.spoke(k).half;
      if (half < 0) continue;
      result.angles[half] = turn + fans.direction(k);
      result.scales[half] = fans.scale(fan);
    }
  }
  return result;
}

Array<double> bisectors(std::span<const double> lengths, std::span<const double> angles,
                        std::span<const double> scales) {
  const Array<double> corners = corner_angles(lengths);
  Array<double> result(count(lengths));
  for (Index f = 0; f < count(lengths); f += 3)
    for (Index c = 0; c < 3; ++c) {
      const Index half = f + (c + 2) % 3;
      result[f + c] = angles[half] + scales[half] * corners[f + c] / 2;
    }
  return result;
}

Array<double> triangle_turns(std::span<const double> lengths, std::span<const double> bisectors,
                             std::span<const bool> mirrored) {
  const Array<double> corners = corner_angles(lengths);
  Array<double> turns(2 * count(lengths));
  for (Index f = 0; f < count(lengths); f += 3) {
    const double* const own = corners.data() + f;
    const double inside[3] = {own[0] / 2, kPi - own[1] / 2, kPi + own[0] + own[2] / 2};
    for (Index c = 0; c < 3; ++c)
      turns[2 * (f + c)] = (mirrored[f / 3] ? -inside[c] : inside[c]) - bisectors[f + c];
  }
  for (Index corner = 0; corner < count(lengths); ++corner) {
    const auto [cosine, sine] = cosine_and_sine(turns[2 * corner]);
    turns[2 * corner] = cosine;
    turns[2 * corner + 1] = sine;
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
