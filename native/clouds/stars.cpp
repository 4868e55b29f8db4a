#include "clouds/stars.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/threads.hpp"

namespace geodesic {
namespace {

// Square of the sine of 45 degrees, and a little more, so that rounding does not decide in a
// lattice: a neighbour that is farther along the normal than along the surface lies on another
// sheet. Measured on a U-shaped sheet with a gap of 4 spacings: 53 degrees hold, 64 leak.
constexpr double kMaxSquaredSineOfElevation = 0.5 * (1 + 1e-12);

// Square of the sine of the elevation below which a neighbour of opposed normal is taken for one
// whose normal was given the wrong sign; above it, for one of the other side of a thin sheet.
constexpr double kMaxSquaredSineOfWrongSign = 0.2 * 0.2;

// Penalty for neighbours off the sheet. Their distance is scaled by
// sqrt(1 + kOffSheetPenalty (rise^2 - kMinSquaredSineOfPenalty)), where rise is the sine of the
// elevation over the mean of both tangent planes, which is 0 on a circle through both. Without it
// sheets half a spacing apart are connected: the refined distance on camelhead's vertices errs by
// 1.2 % instead of 0.9 %.
constexpr double kOffSheetPenalty = 10.0;

// Square of that sine up to which there is no penalty: 18 degrees, as noise and creases have.
constexpr double kMinSquaredSineOfPenalty = 0.1;

// The same, for neighbours beyond the nearest k: on smooth clouds they lie within 27 degrees of the
// sheet, or not on it. At the rim of a hole, neighbourhoods grow and may reach the inside of the
// opposite wall: such bridges shortened all distances from one source by 2.5 % on the vertices of
// the Stanford bunny, which has five holes.
constexpr double kMaxSquaredSineOfGrownStars = 0.2;

// Sine of the smallest angle of a triangle at the centre of its star.
constexpr double kMinSineOfTriangle = 1e-6;

struct Planar {
  double x, y;
};
double dot(const Planar& a, const Planar& b) { return a.x * b.x + a.y * b.y; }
double cross(const Planar& a, const Planar& b) { return a.x * b.y - a.y * b.x; }
double length(const Planar& a) { return std::sqrt(dot(a, a)); }
Planar operator-(const Planar& a, const Planar& b) { return {a.x - b.x, a.y - b.y}; }

// Two vectors at right angles to a unit vector and to each other, without a branch that could
// divide by zero: T. Duff et al., Building an orthonormal basis, revisited, 2017,
// https://jcgt.org/published/0006/01/01/
struct Tangents {
  explicit Tangents(const Vector3& n) {
    const double sign = n.z >= 0 ? 1.0 : -1.0;
    const double c = -1.0 / (sign + n.z), d = n.x * n.y * c;
    u = {1.0 + sign * n.x * n.x * c, sign * d, -sign * n.x};
    v = {d, sign + n.y * n.y * c, -n.y};
  }
  Vector3 u, v;
};

// A neighbour in the tangent plane of the centre.
struct Neighbour {
  Planar place, image;  // where it lies, and where its inverse does
  Index point;
};

// The triangles of the stars of some points, one after the other.
struct Soup {
  std::vector<Index> corners;
  std::vector<double> frames;
};

// Computes one star after the other, with its own memory.
class StarMaker {
 public:
  StarMaker(const Cloud& cloud, std::span<const double> weights, const StarOptions& options)
      : cloud_(cloud), weights_(weights), options_(options) {
    seen_.reserve(static_cast<std::size_t>(cloud.width));
    hull_.reserve(2 * static_cast<std::size_t>(cloud.width));
  }

  // Add the triangles of a star whose circles are no wider than `reach`, and return whether it is
  // open.
  bool add_star(Index centre, std::span<const Index> near, double reach, Soup& soup);

 private:
  void project(Index centre, std::span<const Index> near, Index wanted);
  void find_hull();
  void append(const Neighbour& item, std::size_t kept);
  void add_triangles(Index centre, double reach, bool last, Soup& soup);

  const Cloud& cloud_;
  const std::span<const double> weights_;
  const StarOptions options_;
  std::vector<Neighbour> seen_;         // those of the sheet
  std::vector<const Neighbour*> hull_;  // counter-clockwise, the first at the end again
  double radius_ = 0.0;                 // of the ball that was searched
  bool took_all_ = false;               // whether it holds all neighbours
  bool closed_ = false;                 // whether the triangles surround the point
  bool certain_ = false;                // whether all of them are known to be Delaunay
};

// Put the neighbours of one sheet into the tangent plane of the centre, and invert them.
//
// Neighbours beyond the first k of a smooth cloud must pass a stricter test.
void StarMaker::project(Index centre, std::span<const Index> near, Index wanted) {
  const Vector3 here = at(cloud_.points, centre), normal = at(cloud_.normals, centre);
  const Tangents tangents(normal);
  const Index known = options_.smooth ? options_.k : cloud_.width;
  seen_.clear();
  double squared = 0.0;
  took_all_ = true;
  for (Index i = 0; i < count(near); ++i) {
    if (static_cast<Index>(seen_.size()) >= wanted) {
      took_all_ = false;
      break;
    }
    const Index other = near[i];
    const Vector3 step = at(cloud_.points, other) - here;
    const double height = dot(step, normal);
    squared = dot(step, step);
    if (height * height > kMaxSquaredSineOfElevation * squared) continue;
    const Vector3 theirs = at(cloud_.normals, other);
    const double agreement = dot(normal, theirs);
    if (options_.oriented && agreement < 0 &&
        height * height > kMaxSquaredSineOfWrongSign * squared)
      continue;
    const double turn = agreement >= 0 ? 1.0 : -1.0;
    const Vector3 mean{normal.x + turn * theirs.x, normal.y + turn * theirs.y,
                       normal.z + turn * theirs.z};
    const double rise = dot(step, mean);
    const double off = rise * rise / dot(mean, mean);
    if (i >= known && off > kMaxSquaredSineOfGrownStars * squared) continue;
    const double flat = squared - height * height;
    const double chord = std::max(flat, squared - off);
    const double stretch = std::sqrt(chord / flat);
    const Planar place{stretch * dot(step, tangents.u), stretch * dot(step, tangents.v)};
    const double farther =
        chord + kOffSheetPenalty * std::max(off - kMinSquaredSineOfPenalty * squared, 0.0);
    const double power =
        (farther + weights_[centre] - weights_[other]) / std::sqrt(farther / chord);
    seen_.push_back({place, {place.x / power, place.y / power}, other});
  }
  radius_ = std::sqrt(squared);
}

// Add a point to a chain, after taking away those that it leaves inside.
void StarMaker::append(const Neighbour& item, std::size_t kept) {
  while (hull_.size() > kept) {
    const Planar &a = hull_[hull_.size() - 2]->image, &b = hull_.back()->image;
    if (cross(b - a, item.image - a) > 0) break;
    hull_.pop_back();
  }
  hull_.push_back(&item);
}

void StarMaker::find_hull() {
  // There are few of them, so that they are sorted by insertion.
  const auto before = [](const Neighbour& a, const Neighbour& b) {
    return a.image.x < b.image.x || (a.image.x == b.image.x && a.image.y < b.image.y);
  };
  for (std::size_t i = 1; i < seen_.size(); ++i) {
    const Neighbour item = seen_[i];
    std::size_t j = i;
    for (; j > 0 && before(item, seen_[j - 1]); --j) seen_[j] = seen_[j - 1];
    seen_[j] = item;
  }
  hull_.clear();
  for (const Neighbour& item : seen_) append(item, 1);
  const std::size_t lower = hull_.size();
  for (std::size_t i = seen_.size() - 1; i-- > 0;) append(seen_[i], lower);
}

// The last triangles that are tried are left out where they are obtuse and reach past the ball.
void StarMaker::add_triangles(Index centre, double reach, bool last, Soup& soup) {
  closed_ = certain_ = true;
  for (std::size_t side = 0; side + 1 < hull_.size(); ++side) {
    const Neighbour &first = *hull_[side], &second = *hull_[side + 1];
    const double spanned = cross(first.place, second.place);
    const double a = length(first.place), b = length(second.place);
    if (spanned <= kMinSineOfTriangle * a * b) {
      closed_ = false;
      continue;
    }
    const double c = length(first.place - second.place), along = dot(first.place, second.place);
    const double diameter = a * b * c / spanned;  // of the circle through all three
    if (diameter > reach) {
      closed_ = false;
      continue;
    }
    if (diameter > radius_) {
      certain_ = false;
      if (last && (along < 0 || a * a < along || b * b < along)) {
        closed_ = false;
        continue;
      }
    }
    soup.corners.insert(soup.corners.end(), {centre, first.point, second.point});
    soup.frames.insert(soup.frames.end(), {a, along / a, spanned / a});
  }
}

bool StarMaker::add_star(Index centre, std::span<const Index> near, double reach, Soup& soup) {
  const std::size_t start = soup.corners.size();
  bool is_open = true;
  for (const Index wanted : {options_.k, cloud_.width}) {
    project(centre, near, wanted);
    if (seen_.size() < 2) break;
    soup.corners.resize(start);
    soup.frames.resize(start);
    find_hull();
    const bool last = took_all_ || wanted == cloud_.width;
    add_triangles(centre, reach, last, soup);
    is_open = !closed_;
    if (last || (closed_ && certain_)) break;
  }
  return is_open;
}

// Concatenate the tables of several blocks.
template <class T>
Array<T> joined(const std::vector<Soup>& soups, std::vector<T> Soup::* table) {
  Index size = 0;
  for (const Soup& soup : soups) size += static_cast<Index>((soup.*table).size());
  Array<T> result(size);
  T* free = result.begin();
  for (const Soup& soup : soups) free = std::copy((soup.*table).begin(), (soup.*table).end(), free);
  return result;
}

}  // namespace

Stars delaunay_stars(const Cloud& cloud, const Centres& centres, std::span<const double> weights,
                     const StarOptions& options, int n_threads) {
  check_neighbours(cloud, n_threads);
  const Index n_centres = count(centres.points);
  for (const Index centre : centres.points)
    if (centre < 0 || centre >= cloud.size())
      throw std::invalid_argument("a centre is not a point of the cloud, which has " +
                                  std::to_string(cloud.size()));
  StarOptions limited = options;
  limited.k = std::min(options.k, cloud.width);
  Array<bool> is_open(n_centres);
  std::vector<Soup> soups(
      static_cast<std::size_t>((n_centres + kPointsAtOnce - 1) / kPointsAtOnce));
  in_pieces(n_centres, kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    StarMaker maker(cloud, weights, limited);
    Soup& soup = soups[static_cast<std::size_t>(begin / kPointsAtOnce)];
    for (Index c = begin; c < end; ++c)
      is_open[c] = maker.add_star(centres.points[c], cloud.around(c), centres.reaches[c], soup);
  });
  return {joined(soups, &Soup::corners), joined(soups, &Soup::frames), std::move(is_open)};
}

}  // namespace geodesic
