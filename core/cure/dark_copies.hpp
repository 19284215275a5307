// Copies of models that a print left dark from a layer on: their masks, and how far up they are compared with
// the part. Pure functions, thread-safe.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/cure/cure_comparison.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// A copy of a model that a print left dark from a layer on, and the supports that it left dark with it.
struct DarkCopy {
  std::size_t model = 0, copy = 0;  // numbers in the engine, from 0
  std::size_t layer = 0;            // the first layer without it, from 0; the number of layers if all have it
  std::shared_ptr<const SupportStructure> supports_left{};  // null: those beneath this layer
};

// The layers of a print, from the plate up, and the cuts through the models.
struct CutLayers {
  std::span<const LayerDose> layers;
  std::span<const Nanometers> mask_heights{};  // empty: the layers' middles

  // Returns the height at which the mask of a layer is cut. REQUIRES: there is such a layer.
  [[nodiscard]] Nanometers height_of(std::size_t layer) const;
};

// Leaves the copies dark in the masks of an engine and in the dimming of undersides, which may be null, and
// lights all others. REQUIRES: such copies and layers; later copies are dark from no lower layer on.
void leave_dark(std::span<const DarkCopy> dark, const CutLayers& layers, ContourEngine& engine,
                UndersideDimming* undersides);

// Returns the models, with those copies apart that were left dark.
[[nodiscard]] std::vector<ComparedModel> compared_models(std::span<const PlateModel> models,
                                                         std::span<const DarkCopy> dark,
                                                         const CutLayers& layers);
// Returns the supports as models, with those apart that were left dark.
[[nodiscard]] std::vector<ComparedModel> compared_supports(const SupportStructure& supports,
                                                           const DisplayGeometry& display,
                                                           std::span<const DarkCopy> dark,
                                                           const CutLayers& layers);

// A copy that is compared as far up as it was printed.
struct CutCopy {
  std::size_t number = 0;  // among the copies of all models, from 0
  double up_to_mm = 0;     // above the plate
};
// Returns the copies that were left dark, in their order.
[[nodiscard]] std::vector<CutCopy> cut_copies(std::span<const PlateModel> models,
                                              std::span<const DarkCopy> dark, const CutLayers& layers);

}  // namespace contourd
