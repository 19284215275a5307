// contourctl orient: finds the best orientation of a model. Prints its result and returns the exit code.
// Problems with the data are thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "core/orientation/orientation_figures.hpp"

namespace contourd::ctl {

struct OrientOptions {
  std::filesystem::path model;
  std::optional<double> scale;
  OrientationPreset preset = OrientationPreset::Auto;
  // Configuration of contourd, for build volume and resin.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> resin;     // profile instead of the printer's resin
  std::optional<std::filesystem::path> html;      // one self-contained page
  std::optional<std::filesystem::path> pictures;  // a folder of PNGs
  bool force = false;                             // replace the pictures of an earlier call
  bool json = false;
};
int orient(const OrientOptions& options);

}  // namespace contourd::ctl
