// The thesis's measurements of a sliced model: the timed loop (section 3.5), and its results (tables 4.1 to
// 4.6) as text, JSON and CSV.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/contour/contour_loops.hpp"
#include "core/contour/slicer.hpp"
#include "core/layers/layer_statistics.hpp"

namespace contourd::ctl {

// Times slicing and joining. Keeps its memory from one layer to the next. Not thread-safe.
class LayerStopwatch {
 public:
  // Cuts the model at z; joins ends of segments that are at most `tolerance` apart.
  [[nodiscard]] LayerMeasurement measure(const HeightIndex& model, Millimeters z, Millimeters tolerance);
  // Returns the contours of the last cut.
  [[nodiscard]] const Contours& contours() const { return contours_; }

 private:
  Section section_;
  ContourLinker linker_;
  Contours contours_;
};

void print_statistics(const LayerStatistics& statistics);
[[nodiscard]] nlohmann::ordered_json statistics_json(const LayerStatistics& statistics);
// Returns one row per measurement: mean and standard deviation (tables 4.1 to 4.6); then the correlations of
// table 4.5.
[[nodiscard]] std::string statistics_csv(const LayerStatistics& statistics);
// Returns a heading, and one row per layer.
[[nodiscard]] std::string measurements_csv(std::span<const LayerMeasurement> layers);

// Returns text such as "400 of 50 um" or "372 of 25 to 100 um".
[[nodiscard]] std::string layers_text(std::span<const Nanometers> thicknesses);

}  // namespace contourd::ctl
