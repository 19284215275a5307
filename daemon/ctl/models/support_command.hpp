// contourctl support. Prints its result and returns the exit code; what is wrong with the data comes out as
// an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "daemon/ctl/models/up_option.hpp"

namespace contourd::ctl {

struct SupportOptions {
  std::filesystem::path model;
  bool json = false;
  std::optional<double> scale;  // factor on the model's size
  std::optional<UpOption> up;   // what points up; as the model is drawn
  DisplayGeometry display;      // the model stands in its middle
  Nanometers layer_height{50'000};
  // Binary: x and y as in the model's file, z above the plate.
  std::optional<std::filesystem::path> stl;
  bool with_model = false;  // in that file too
};
int support(const SupportOptions& options);

}  // namespace contourd::ctl
