// Angles in loops that compilers vectorise: the library's functions take them one at a time.
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

struct CosineAndSine {
  double cosine, sine;
};

// To two units in the last place, of angles up to 1e5. Polynomials of the same library, within
// pi / 4 of a multiple of pi / 2, which is subtracted in three parts.
inline CosineAndSine cosine_and_sine(double angle) {
  const double quarters = std::floor(angle * (2 / kPi) + 0.5), halves = std::floor(quarters / 2);
  const double x =
      ((angle - quarters * 1.57079625129699707031) - quarters * 7.54978941586159635e-8) -
      quarters * 5.3903028581581190529e-15;
  const double z = x * x;
  const double p = (((((1.58962301576546568060e-10 * z - 2.50507477628578072866e-8) * z +
                       2.75573136213857245213e-6) *
                          z -
                      1.98412698295895385996e-4) *
                         z +
                     8.33333333332211858878e-3) *
                        z -
                    1.66666666666666307295e-1);
  const double q = (((((-1.13585365213876817300e-11 * z + 2.08757008419747316778e-9) * z -
                       2.75573141792967388112e-7) *
                          z +
                      2.48015872888517045348e-5) *
                         z -
                     1.38888888888730564116e-3) *
                        z +
                    4.16666666666665929218e-2);
  const double sine = x + x * z * p, cosine = 1 - z / 2 + z * z * q;
  const bool is_odd = quarters != 2 * halves;
  const double sign = halves == 2 * std::floor(halves / 2) ? 1.0 : -1.0;
  return {sign * (is_odd ? -sine : cosine), sign * (is_odd ? cosine : sine)};
}

}  // namespace geodesic
