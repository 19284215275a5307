// contourctl slice: cuts a model. Prints its result and returns the exit code. Problems with the data are
// thrown as exceptions (see exit_codes.hpp).
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
  // Exactly one of these three is given: one height (in the file's coordinates), uniform layers, or adaptive
  // layers.
  std::optional<Millimeters> z;
  std::optional<Nanometers> layer_height;
  std::optional<AdaptiveLayers> adaptive;

  std::optional<UpOption> up;  // applied first; z then refers to the turned model

  EngineSettings engine;
  bool fit = false;
  bool supports = false;        // layers then count from the plate; z still refers to the file
  std::optional<double> scale;  // factor for the model's size
  std::optional<std::filesystem::path> uniformity;  // picture to read into engine.uniformity

  std::optional<std::filesystem::path> mask;      // one PNG, with z
  std::optional<std::filesystem::path> masks;     // a folder of PNGs, with layers
  std::optional<std::filesystem::path> csv;       // with layers
  std::optional<std::filesystem::path> contours;  // a folder of CSVs, with layers
  bool force = false;                             // replace the files of an earlier slice in these folders
};
int slice(SliceOptions options);

}  // namespace contourd::ctl
