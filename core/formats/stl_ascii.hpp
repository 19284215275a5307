// ASCII STL: "solid", "facet", "vertex" and numbers, as any writer spells them.
#pragma once

#include "core/formats/model_format.hpp"

namespace contourd {

extern const ModelFormat kAsciiStl;

}  // namespace contourd
