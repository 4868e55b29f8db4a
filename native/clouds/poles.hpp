// Normals where sheets are thin: towards the emptiest side of a point.
//
// Principal components take the plane in which most neighbours lie, and where a sheet is thinner
// than its spacing, or a limb not much thicker, half of the neighbours are on the far side of it.
// However thin it is, a ball of air touches each of its points from outside, and the direction to
// the centre of the largest is the normal: the pole of the Voronoi cell of N. Amenta and M. Bern,
// Surface reconstruction by Voronoi filtering, Discrete & Computational Geometry 22, 1999,
// https://doi.org/10.1007/PL00009475
#pragma once

#include "clouds/cloud.hpp"

namespace geodesic {

// The normals, (N, 3), with the doubtful ones replaced by poles.
//
// Throws std::invalid_argument if a neighbour is not a point of the cloud.
Array<double> pole_normals(const Cloud& cloud, int n_threads);

}  // namespace geodesic
