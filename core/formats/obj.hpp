// Wavefront OBJ: vertices, and polygons that name them. Materials, normals and textures do not matter; curves
// and free-form surfaces are not read.
#pragma once

#include "core/formats/model_format.hpp"

namespace contourd {

// A text is likely to be OBJ if each of its first lines begins with a word of OBJ, or is blank or a comment.
extern const ModelFormat kObj;

}  // namespace contourd
