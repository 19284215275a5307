// How far the light that layers had was from what was asked for: counted, and drawn for the report. Values,
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/print/print_process.hpp"

namespace contourd {

struct LightBin {
  double middle_ms = 0;               // given less asked
  std::uint64_t least = 0, most = 0;  // layers whose light was here by its lower and by its upper bound
};

struct LightHistogram {
  static constexpr std::size_t kMaxBins = 41;
  static constexpr double kFinest_ms = 0.01;

  std::vector<LightBin> bins;  // side by side, one of them around 0; none without layers
  double width_ms = kFinest_ms;
  std::uint64_t layers = 0;    // that are counted
  std::uint64_t left_out = 0;  // whose light was not all given, or not confirmed off
  std::int32_t farthest = 0;   // layer, from 0
  double farthest_ms = 0;      // its bound that is farthest from what was asked
  bool exact = true;           // both bounds of every layer are in one bin
};

[[nodiscard]] LightHistogram histogram_of_light(std::span<const LayerRecord> layers);

// As SVG. REQUIRES: bins.
[[nodiscard]] std::string svg_of(const LightHistogram& histogram);

}  // namespace contourd
