// Wavefront OBJ: vertices, and polygons that name them. Materials, normals, textures and unknown words do not
// matter; curves, free-form surfaces and other files that the file includes are left out with a warning.
#pragma once

#include "core/formats/model_format.hpp"

namespace contourd {

// A text is likely to be OBJ if one of its first lines is a vertex of OBJ, or each of them begins with a word
// of OBJ, or is blank or a comment.
extern const ModelFormat kObj;

}  // namespace contourd
