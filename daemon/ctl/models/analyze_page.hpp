// The page that `contourctl analyze --html` writes: figures, the thesis's plots and correlations, and its
// stacked contours as a picture that can be turned. One file that needs nothing else. Thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/support/supports.hpp"
#include "daemon/ctl/models/contour_stack.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

struct AnalyzedModel {
  std::string name;
  std::size_t facets = 0;
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;  // as printed
  double top_mm = 0;                                   // above the plate
  DisplayGeometry display;
  std::optional<Supports> supports;            // nothing where none are wanted
  std::vector<Nanometers> layers;              // their thicknesses, from the plate up
  std::vector<Nanometers> layer_middles;       // where they are cut
  std::optional<Duration> assumed_layer_time;  // when no printer is known
  std::vector<std::string> warnings;           // about the file and its mesh
  PrintFindings findings;
  std::vector<LayerMeasurement> measurements;  // by layer; z above the plate
  LayerStatistics statistics;
  ContourStack contours;
};

// How long the layers take, and where that is from.
[[nodiscard]] std::string layer_time_text(const AnalyzedModel& model);

[[nodiscard]] std::string analysis_page(const AnalyzedModel& model);

}  // namespace contourd::ctl
