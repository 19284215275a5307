// contourctl orient. Prints its result and returns the exit code; what is wrong with the data comes out as an
// exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "core/orientation/orientation_weights.hpp"

namespace contourd::ctl {

struct OrientOptions {
  std::filesystem::path model;
  std::optional<double> scale;
  OrientationPreset preset = OrientationPreset::Auto;
  // As contourd with this configuration prints it: its build volume, and its resin.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> resin;     // a profile in the place of the printer's
  std::optional<std::filesystem::path> html;      // one self-contained page
  std::optional<std::filesystem::path> pictures;  // a folder of PNGs
  bool force = false;                             // replaces what an earlier one left in that folder
  bool json = false;
};
int orient(const OrientOptions& options);

}  // namespace contourd::ctl
