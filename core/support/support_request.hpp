// A request for supports: the models as they stand on a plate. A value; thread-safe as any value is.
#pragma once

#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

struct SupportRequest {
  std::vector<PlateModel> models;  // as they stand, already lifted by support_lift()
  DisplayGeometry display;         // the build area; no part of a support lies outside it
  SupportSettings settings;
};

}  // namespace contourd
