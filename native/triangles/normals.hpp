// Unit normals at the vertices of triangles.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// Unit normals at vertices, (N, 3): those of Max, corrected where heights over two rings say more.
//
// Those of Max are exact where vertices are on a sphere; elsewhere their tilt is of the first order
// of the edge length. Heights above their planes have a fit of third degree over two rings, and a
// normal is corrected by the slope of that fit as far as the slope exceeds its uncertainty, which
// follows from the residuals. So slopes of noise and of creases change nothing, and the tilt is of
// the third order where the surface is smooth. It is (0, 0, 1) at vertices of no face, and
// the normal of one face where those of all cancel.
//
// N. Max, Weights for Computing Vertex Normals from Facet Normals, Journal of Graphics Tools 4,
// 1999, https://doi.org/10.1080/10867651.1999.10487501
// F. Cazals, M. Pouget, Estimating Differential Quantities Using Polynomial Fitting of Osculating
// Jets, Computer Aided Geometric Design 22, 2005, https://doi.org/10.1016/j.cagd.2004.09.004
// They are the same for any number of threads.
Array<double> vertex_normals(std::span<const double> vertices, std::span<const Index> faces,
                             int n_threads = 1);

}  // namespace geodesic
