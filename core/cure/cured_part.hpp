// Computes the part that a print's light makes, from the very masks of the print, and its distance from the
// model. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/cure/cure_comparison.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/cure/cured_surface.hpp"
#include "core/cure/dark_copies.hpp"
#include "core/cure/pixel_light.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/mask/light_split.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// The light of a print.
struct PrintLight {
  std::span<const LayerDose> layers;  // from the plate up
  CureSettings cure{};
  PixelLight pixel{};
  UndersideDimming* undersides = nullptr;  // null: undersides are not dimmed
  // Heights of the cuts through the models, by layer, of a print that is over; empty: the layers' middles.
  std::span<const Nanometers> mask_heights{};
  std::function<bool()> is_stopped{};  // asked at each layer; empty: never
  GivenLight* given = nullptr;         // null: exposures are not split
  std::span<const DarkCopy> dark{};    // in the order in which they were left dark

  [[nodiscard]] CutLayers cuts() const { return {layers, mask_heights}; }
};

struct CuredPart {
  CureFigures figures;
  // Dose at the lower side of a layer over Ec, before the next peel: from 1 on, the layer is solid down to
  // the one beneath. That of fully lit pixels, or a lower one of pixels that get less light, see LayerBonds.
  // Layers that no peel separates from the one beneath do not count.
  double weakest_bond = 0;  // of all layers but the first; 0 for one layer
  std::int32_t weakest_bond_layer = 0;
  // Layers whose masks exceeded their budget; they count as dark.
  std::int64_t abandoned_layers = 0;
  // Layers in which undersides keep their light because they were not found within their budget.
  std::int64_t unfound_undersides = 0;
  std::vector<CutCopy> cut_copies{};  // copies that were left dark
};

// The masks of a print, as the share of the light that they are to give. Not thread-safe.
class PrintMasks {
 public:
  // Finds the dimmed undersides. Engine and light must outlive this object. In both, leave_dark()
  // leaves dark what the light leaves dark.
  PrintMasks(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
             std::optional<std::chrono::nanoseconds> budget);

  // Returns the number of layers in which undersides were not found within their budget.
  [[nodiscard]] std::int64_t unfound() const { return unfound_; }
  // Returns the mask of a layer; null if it exceeded its budget. Valid until the next call.
  const Mask* of(std::size_t number);
  // True if masks may be darker than the coverage of which they are made.
  [[nodiscard]] bool darken() const { return given_ != nullptr || !threshold_.is_none() || !dimmed_.empty(); }

 private:
  // Returns the light that the engine's last mask asks for in this layer.
  const Mask& wanted_of(std::size_t number);

  ContourEngine& engine_;
  GivenLight* given_;
  CutLayers layers_;
  std::vector<std::vector<DimmedPixel>> dimmed_;  // by layer; none without dimming
  std::int64_t unfound_ = 0;
  ExposureCorrection threshold_;
  Mask changed_;
  std::optional<std::chrono::nanoseconds> budget_;
};

// The curing of a print on `display`: its masks, layer by layer from the top down. Light is the masks'
// coverage without pixels that the threshold leaves dark, as far as split exposures give it: gamma and
// uniformity mask serve to give just this light. Not thread-safe.
class PrintCure {
 public:
  // Finds the pixels that get light: computes all masks, and the dimmed undersides. The engine and what the
  // light refers to must outlive this object.
  PrintCure(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
            std::optional<std::chrono::nanoseconds> mask_budget);

  // Compares the part with the models and with `supports`, those beside the models, or null. Copies that were
  // left dark, and supports that were so with them, end with their last layer. Memory: see
  // CuredLayers and CureComparison, for the pixels from the first lit row and column to the last. nullopt if
  // it was stopped.
  [[nodiscard]] std::optional<CuredPart> compare(const Supports* supports);
  // Returns the lit area of each layer of a print that is over, in pixels, before a threshold if no
  // undersides are dimmed; 0 without a mask.
  [[nodiscard]] std::span<const double> lit_pixels() const { return lit_pixels_; }
  // Makes the part's surface, see CuredSurface.
  void make_surface(std::int32_t step, std::function<void(const Facet&)> sink);

 private:
  struct CuredLayer {
    std::size_t number;
    const CuredLayers& cured;
    std::span<const float> share, dose;  // given to CuredLayers, and returned
    bool has_mask;
  };
  // Calls layer(CuredLayer) for each layer. Returns the number of layers without a mask.
  template <typename Layer>
  std::int64_t cure_layers(Layer&& layer);

  ContourEngine& engine_;
  DisplayGeometry display_;
  PrintLight light_;
  PrintMasks masks_;
  std::vector<double> lit_pixels_;
  PixelWindow window_;
};

// Does what PrintCure::compare() does, with light that is never stopped.
[[nodiscard]] CuredPart cure_part(ContourEngine& engine, const DisplayGeometry& display,
                                  const PrintLight& light, const Supports* supports,
                                  std::optional<std::chrono::nanoseconds> mask_budget = std::nullopt);

}  // namespace contourd
