// contourctl slice. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "core/engine/contour_engine.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "daemon/ctl/models/up_option.hpp"

namespace contourd::ctl {

struct SliceOptions {
  std::filesystem::path model;
  bool json = false;
  // Exactly one of the three is given: one height (the file's coordinates), layers of one height, or adaptive
  // ones.
  std::optional<Millimeters> z;
  std::optional<Nanometers> layer_height;
  std::optional<AdaptiveLayers> adaptive;

  std::optional<UpOption> up;  // before all else; a z is the turned model's then

  EngineSettings engine;
  bool fit = false;
  bool supports = false;        // layers count from the plate then, and --z stays the file's
  std::optional<double> scale;  // factor on the model's size
  std::optional<std::filesystem::path> uniformity;  // to be read into engine.uniformity

  std::optional<std::filesystem::path> mask;      // one PNG, with z
  std::optional<std::filesystem::path> masks;     // a folder of PNGs, with layers
  std::optional<std::filesystem::path> csv;       // with layers
  std::optional<std::filesystem::path> contours;  // a folder of CSVs, with layers
  bool force = false;                             // replaces what an earlier slice left in these folders
};
int slice(SliceOptions options);

}  // namespace contourd::ctl
