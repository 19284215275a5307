// A histogram of the layers by the difference between actual and requested exposure, and its drawing for the
// report. Values, thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/print/print_plan.hpp"

namespace contourd {

struct LightBin {
  double middle_ms = 0;  // actual minus requested exposure
  // Numbers of layers whose exposure has its lower bound, or its upper bound, in this bin.
  std::uint64_t least = 0, most = 0;
};

struct LightHistogram {
  static constexpr std::size_t kMaxBins = 41;
  static constexpr double kFinest_ms = 0.01;

  std::vector<LightBin> bins;  // adjacent, one of them around 0; empty without layers
  double width_ms = kFinest_ms;
  std::uint64_t layers = 0;    // counted layers
  std::uint64_t left_out = 0;  // layers not counted: not all light given, or not confirmed off
  std::int32_t farthest = 0;   // layer with the largest difference, from 0
  double farthest_ms = 0;      // this difference, by the bound farther from the requested exposure
  bool exact = true;           // true if both bounds of every layer are in one bin
};

// Counts the layers whose light was given completely and confirmed off.
[[nodiscard]] LightHistogram histogram_of_light(std::span<const LayerRecord> layers);

// Draws the histogram as SVG. REQUIRES: bins.
[[nodiscard]] std::string svg_of(const LightHistogram& histogram);

}  // namespace contourd
