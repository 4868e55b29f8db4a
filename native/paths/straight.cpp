#include "paths/straight.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "triangles/measures.hpp"

namespace geodesic {
namespace {

using Planar = std::complex<double>;

// Share of an edge by which a line keeps off its ends: it passes a vertex on one side.
constexpr double kAside = 1e-12;

Index next(Index half) { return half % 3 == 2 ? half - 2 : half + 1; }
Index previous(Index half) { return half % 3 == 0 ? half + 2 : half - 1; }
double cross(Planar p, Planar q) { return p.real() * q.imag() - p.imag() * q.real(); }

// A triangle in the plane in which one of its half-edges leads from 0 along the first axis.
struct Laid {
  Index half;
  Planar places[3];  // its tail, its head, the corner opposite

  Laid(std::span<const double> lengths, Index of) : half(of) {
    const double edge = lengths[of];
    const double head_side = lengths[next(of)], tail_side = lengths[previous(of)];
    const double along = (edge * edge + (tail_side - head_side) * (tail_side + head_side)) / 2;
    places[0] = 0.0;
    places[1] = edge;
    places[2] = {along / edge, doubled_area(edge, head_side, tail_side) / edge};
  }
  Index corner(int place) const {  // as numbered in the face: opposite half is the third
    return place == 0 ? next(half) : place == 1 ? previous(half) : half;
  }
  Index side(int place) const {  // which leads from that place to the next
    return place == 0 ? half : place == 1 ? next(half) : previous(half);
  }
};

struct Point {
  Index face;
  double weights[3];
};

// One line after the other.
class Tracer {
 public:
  Tracer(std::span<const double> lengths, std::span<const Index> twin, Index most)
      : lengths_(lengths), twin_(twin), most_(most) {}

  // Add the points of a line; return the rest of its length.
  double trace(Index face, const double* weights, double angle, double left,
               std::vector<Point>& points) {
    points.push_back({face, {weights[0], weights[1], weights[2]}});
    Laid laid(lengths_, 3 * face);
    Planar at = 0.0;
    for (int k = 0; k < 3; ++k) at += weights[laid.corner(k) % 3] * laid.places[k];
    Planar ahead = std::polar(1.0, angle);
    int from = -1;  // the corner that it leaves at first: no rounding is to send it along a side
    for (int k = 0; k < 3; ++k)
      if (weights[laid.corner(k) % 3] == 1) from = k;
    bool entered = false;
    for (Index step = 0; step < most_ && left > 0; ++step) {
      int out = -1;
      double way = 0.0, share = 0.0;
      for (int k = entered; k < 3; ++k) {
        if (from >= 0 && k != (from + 1) % 3) continue;
        const Planar begin = laid.places[k] - at, edge = laid.places[(k + 1) % 3] - laid.places[k];
        const double down = cross(ahead, edge);
        if (!(down > 0)) continue;  // it comes in there
        const double here = std::max(cross(begin, edge) / down, 0.0);
        if (out >= 0 && here >= way) continue;
        out = k, way = here, share = cross(begin, ahead) / down;
      }
      if (out < 0) return left;
      if (way >= left) {
        add(laid, at + left * ahead, points);
        return 0.0;
      }
      left -= way;
      share = std::clamp(share, kAside, 1 - kAside);
      const Index side = laid.side(out), mate = twin_[side];
      Point crossing{laid.half / 3, {0, 0, 0}};
      crossing.weights[laid.corner(out) % 3] = 1 - share;
      crossing.weights[laid.corner((out + 1) % 3) % 3] = share;
      points.push_back(crossing);
      if (mate < 0) return left;
      const Planar edge = laid.places[(out + 1) % 3] - laid.places[out];
      ahead *= -std::conj(edge) / std::abs(edge);  // the twin leads back
      ahead = {ahead.real(), std::max(ahead.imag(), kAside)};
      ahead /= std::abs(ahead);
      laid = Laid(lengths_, mate);
      at = lengths_[mate] * (1 - share);
      entered = true;
      from = -1;
    }
    return left;
  }

 private:
  static void add(const Laid& laid, Planar at, std::vector<Point>& points) {
    const Planar apex = laid.places[2];
    const double up = std::clamp(at.imag() / apex.imag(), 0.0, 1.0);
    const double head =
        std::clamp((at.real() - up * apex.real()) / laid.places[1].real(), 0.0, 1.0 - up);
    Point point{laid.half / 3, {0, 0, 0}};
    point.weights[laid.corner(0) % 3] = 1 - up - head;
    point.weights[laid.corner(1) % 3] = head;
    point.weights[laid.corner(2) % 3] = up;
    points.push_back(point);
  }

  std::span<const double> lengths_;
  std::span<const Index> twin_;
  const Index most_;
};

}  // namespace

StraightLines straight_lines(std::span<const double> lengths, std::span<const Index> twin,
                             std::span<const Index> faces, std::span<const double> weights,
                             std::span<const double> angles, std::span<const double> distances,
                             Index most) {
  const Index n = count(faces);
  StraightLines result{Array<Index>(n + 1), {}, {}, Array<double>(n)};
  std::vector<Point> points;
  Tracer tracer(lengths, twin, most);
  for (Index i = 0; i < n; ++i) {
    result.begins[i] = static_cast<Index>(points.size());
    result.missing[i] =
        tracer.trace(faces[i], weights.data() + 3 * i, angles[i], distances[i], points);
  }
  const auto n_points = static_cast<Index>(points.size());
  result.begins[n] = n_points;
  result.faces = Array<Index>(n_points);
  result.weights = Array<double>(3 * n_points);
  for (Index p = 0; p < n_points; ++p) {
    const Point& point = points[static_cast<std::size_t>(p)];
    result.faces[p] = point.face;
    std::copy_n(point.weights, 3, result.weights.data() + 3 * p);
  }
  return result;
}

}  // namespace geodesic
