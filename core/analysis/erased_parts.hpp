// Parts of layers that a compensation erases whole: walls and pins that are thinner than the distance by
// which their outline moves inwards from both sides. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// A connected part of a layer without a lit pixel left.
struct ErasedPart {
  std::int32_t layer = 0;  // index of the layer's height
  Point plate_mm{};        // middle of the part, from the plate's centre; seen from above, mirrors undone
  double area_mm2 = 0;
};

struct ErasedParts {
  std::uint64_t count = 0;
  std::optional<ErasedPart> largest;  // the lowest one of equally large parts
};

struct ErasedPartSearch {
  EngineSettings settings;
  std::span<const Nanometers> heights;  // of the layers' middles, rising
  std::uint8_t least_grey;              // lowest grey value that cures
  std::chrono::nanoseconds mask_budget;
};

// Compares layers whose outlines move inwards with the same layers without compensation: at most 200 of them,
// evenly spread. Every point loses its end: a part no larger than a square of twice the distance and a pixel
// counts only if it is erased 0.2 mm beneath and above as well, as a pin is. Masks that overrun their budget
// do not count. Blocks for two masks per layer, and for six where there are small parts. Returns early if
// `stop` is requested.
[[nodiscard]] ErasedParts find_erased_parts(const std::vector<PlateModel>& models,
                                            const ErasedPartSearch& search, const std::stop_token& stop = {});

}  // namespace contourd
