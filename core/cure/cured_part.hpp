// Computes the part that a print's light makes, from the very masks of the print, and its distance from the
// model. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "core/cure/cure_comparison.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/cure/pixel_light.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// The light of a print.
struct PrintLight {
  std::span<const LayerDose> layers;  // from the plate up
  CureSettings cure{};
  PixelLight pixel{};
  UndersideDimming* undersides = nullptr;  // null: undersides are not dimmed
};

struct CuredPart {
  CureFigures figures;
  // Dose at the lower side of a fully lit layer over Ec: from 1 on, the layer is solid down to the one
  // beneath.
  double weakest_bond = 0;  // of all layers but the first; 0 for one layer
  std::int32_t weakest_bond_layer = 0;
  // Layers whose masks exceeded their budget; they count as dark.
  std::int64_t abandoned_layers = 0;
  // Layers in which undersides keep their light because they were not found within their budget.
  std::int64_t unfound_undersides = 0;
};

// Cures the part that `engine` prints on `display`; `supports` are those beside its models, or null. Light is
// the masks' coverage without pixels that the threshold leaves dark: gamma and uniformity mask serve to give
// just this light. Memory: see CuredLayers and CureComparison, for the pixels from the first lit row and
// column to the last.
[[nodiscard]] CuredPart cure_part(ContourEngine& engine, const DisplayGeometry& display,
                                  const PrintLight& light, const Supports* supports,
                                  std::optional<std::chrono::nanoseconds> mask_budget = std::nullopt);

}  // namespace contourd
