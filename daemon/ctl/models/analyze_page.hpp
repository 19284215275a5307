// The page of `contourctl analyze --html`: a picture of the part with marked places, figures, and the
// thesis's plots and correlations. One self-contained file. Thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/image/preview.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/support/supports.hpp"
#include "daemon/report/rise_forecast_text.hpp"
#include "daemon/report/time_causes.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

struct AnalyzedModel {
  std::string name;
  std::size_t facets = 0;
  std::array<double, 3> size_mm{};  // as printed
  DisplayGeometry display;
  std::optional<Supports> supports;            // nullopt: not wanted
  std::vector<Nanometers> layers;              // thicknesses, from the plate up
  std::vector<Nanometers> layer_middles;       // heights of the cuts
  std::optional<Duration> assumed_layer_time;  // if there is no printer's configuration
  std::vector<std::string> warnings;           // about the file and its mesh
  PrintFindings findings;
  std::optional<PrintForecast> forecast;         // nullopt if there is no printer's configuration
  std::optional<ContinuousForecast> continuous;  // nullopt: not wanted
  std::vector<LayerMeasurement> measurements;    // by layer; z above the plate
  LayerStatistics statistics;
  Preview picture;  // for the page
};

// Returns the time of all layers and its source, as text.
[[nodiscard]] std::string layer_time_text(const AnalyzedModel& model);

[[nodiscard]] std::string analysis_page(const AnalyzedModel& model);

}  // namespace contourd::ctl
