// The layers of a print, asked for one after the other while it goes: where one ends, the next begins.
// Immutable; any number of threads may ask.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "core/layers/layers.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

class PrintLayers {
 public:
  PrintLayers() = default;  // none
  // All of one thickness. REQUIRES: as layers_for() has them.
  explicit PrintLayers(const LayerStack& uniform) : uniform_(uniform) {}
  // As the models' surfaces allow: of several models, what the most demanding one says. REQUIRES: as
  // next_thickness() does; no null pointers.
  PrintLayers(std::vector<std::shared_ptr<const HeightIndex>> models, const AdaptiveLayers& adaptive);

  // The thickness of the layer on `bottom`, which is 0 or the top of an earlier layer; nothing when the print
  // is as high as it will be.
  [[nodiscard]] std::optional<Nanometers> thickness_at(Nanometers bottom) const;

  // All thicknesses, from the plate up: for an estimate of how long the print takes. Makes every decision
  // that the print will make, but no mask. Throws TooManyLayers.
  [[nodiscard]] std::vector<Nanometers> all() const;

 private:
  LayerStack uniform_;
  std::vector<std::shared_ptr<const HeightIndex>> models_;  // none when uniform
  AdaptiveLayers adaptive_;
  double height_mm_ = 0;  // of the highest model
};

}  // namespace contourd
