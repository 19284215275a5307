// contourctl support: generates supports. Prints its result and returns the exit code. Problems with the data
// are thrown as exceptions (see exit_codes.hpp).
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
  std::optional<double> scale;  // factor for the model's size
  std::optional<UpOption> up;   // direction that points up; nullopt: as drawn
  DisplayGeometry display;      // the model is in its middle
  Nanometers layer_height{50'000};
  // Binary STL file to write: x and y as in the model's file, z above the plate.
  std::optional<std::filesystem::path> stl;
  bool with_model = false;  // write the model to this file, too
};
int support(const SupportOptions& options);

}  // namespace contourd::ctl
