// The cut through one facet. A value.
#pragma once

#include "core/geometry/facet.hpp"

namespace contourd {

// A segment, directed so that the model's inside is on the left (seen from above).
struct Segment {
  Point from, to;
  bool operator==(const Segment&) const = default;
};

}  // namespace contourd
