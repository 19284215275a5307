// Binary STL: 80 bytes of anything, the facet count, then 50 bytes a facet.
#pragma once

#include "core/formats/model_format.hpp"

namespace contourd {

// A file is certain to be binary STL if its size is what its facet count says, whatever else it looks like.
extern const ModelFormat kBinaryStl;

}  // namespace contourd
