// The layers of a print, asked for one after the other while it goes: where one ends, the next begins.
// Immutable; any number of threads may ask.
#pragma once

#include <optional>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/geometry/units.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "core/layers/layers.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

class PrintLayers {
 public:
  PrintLayers() = default;  // none
  // All of one thickness. REQUIRES: as layers_for() has them.
  explicit PrintLayers(const LayerStack& uniform) : uniform_(uniform) {
    expects(uniform.count == 0 || (uniform.count > 0 && is_layer(uniform.thickness)),
            "layers have a thickness");
  }
  // As the models' surfaces allow: of several models, what the most demanding one says. REQUIRES:
  // adaptive.are_printable(); no null pointers.
  PrintLayers(std::vector<StandingModel> models, const AdaptiveLayers& adaptive);

  // The thickness of the layer on `bottom`, which is 0 or the top of an earlier layer; nothing when the print
  // is as high as it will be.
  [[nodiscard]] std::optional<Nanometers> thickness_at(Nanometers bottom) const;

  // All thicknesses, from the plate up: for an estimate of how long the print takes. Makes every decision
  // that the print will make, but no mask. Throws TooManyLayers.
  [[nodiscard]] std::vector<Nanometers> all() const;

 private:
  LayerStack uniform_;
  std::vector<StandingModel> models_;  // none when uniform
  AdaptiveLayers adaptive_;
  Millimeters top_{};  // of the highest model, above the plate
};

}  // namespace contourd
