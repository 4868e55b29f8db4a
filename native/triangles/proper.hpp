// The faces that belong to a surface.
#pragma once

#include "core/array.hpp"

namespace geodesic {

// True if each face has three different vertices that no face before it has, in whatever order:
// front and back of one triangle are one.
Array<bool> proper_faces(std::span<const Index> faces, Index n_vertices);
// The faces that have a marked vertex, by number.
Array<Index> faces_at(std::span<const Index> faces, std::span<const bool> marked);

}  // namespace geodesic
