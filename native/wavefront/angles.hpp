// Angles in loops that compilers vectorise: the library's atan2 takes them one at a time.
#pragma once

#include <cmath>

namespace geodesic {

inline constexpr double kPi = 3.14159265358979323846;

// The angle in [0, pi] of (x, y), y >= 0, to two units in the last place; 0 at the origin.
//
// S. L. Moshier, Cephes mathematical library, 1989, https://www.netlib.org/cephes/: a rational
// function for tangents up to 0.66, to which the others are turned by pi / 4.
inline double angle(double x, double y) {
  const double width = std::abs(x), most = width > y ? width : y, least = width > y ? y : width;
  const bool turned = least > 0.66 * most;
  const double above = turned ? least - most : least, below = turned ? least + most : most;
  const double t = above / (below > 0 ? below : 1.0), z = t * t;
  const double p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                     7.500855792314704667340e1) *
                        z -
                    1.228866684490136173410e2) *
                       z -
                   6.485021904942025371773e1;
  const double q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                     4.328810604912902668951e2) *
                        z +
                    4.853903996359136964868e2) *
                       z +
                   1.945506571482613964425e2;
  const double within = (turned ? kPi / 4 : 0.0) + (t + t * z * p / q);
  const double upright = width > y ? within : kPi / 2 - within;
  return x < 0 ? kPi - upright : upright;
}

}  // namespace geodesic
