// The figures of a fit's page, as HTML. Pure functions; thread-safe.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/calibration/lamp_fit.hpp"

namespace contourd::ctl {

// A measurement, or a place of a fitted line with its standard uncertainty.
struct PlottedPoint {
  double x = 0, y = 0, uncertainty = 0;
};

// Measurements of one kind and the line that was fitted to them.
struct PlottedFit {
  std::string name{};  // empty if there is only one kind
  std::vector<PlottedPoint> measured{}, line{};
};

enum class Scale { Linear, Logarithmic };

struct FitPlot {
  std::string x_heading, y_heading;
  Scale x_scale = Scale::Linear;
  std::vector<PlottedFit> fits{};
};

// Returns an SVG of the measurements, the lines, and around each a band of two standard uncertainties.
// REQUIRES: a fit with a measurement; x above 0 on a logarithmic scale.
[[nodiscard]] std::string svg_of_fit(const FitPlot& plot);

// Returns a map of the lamp's light, with the readings' places, for a display that is `aspect` times as wide
// as high. REQUIRES: an aspect above 0.
[[nodiscard]] std::string map_of_lamp(const LampFit& lamp, std::span<const LampReading> readings,
                                      double aspect);

}  // namespace contourd::ctl
