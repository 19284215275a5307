// The layers of a print, chosen one after the other during the print: where one ends, the next begins.
// Immutable; any number of threads may call it.
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
  PrintLayers() = default;  // no layers
  // Makes layers of one thickness. REQUIRES: a stack as layers_for() returns it.
  explicit PrintLayers(const LayerStack& uniform) : uniform_(uniform) {
    expects(uniform.count == 0 || (uniform.count > 0 && is_layer(uniform.thickness)),
            "layers have a thickness");
  }
  // Makes layers as thick as the models' surfaces allow; of several models, the most demanding one decides.
  // REQUIRES: adaptive.are_printable(); no null pointers.
  PrintLayers(std::vector<StandingModel> models, const AdaptiveLayers& adaptive);

  // Returns the thickness of the layer on `bottom`, which is 0 or the top of an earlier layer; nullopt if
  // that layer would be cut above the models.
  [[nodiscard]] std::optional<Nanometers> thickness_at(Nanometers bottom) const;

  // Returns all thicknesses, from the plate up, for an estimate of the printing time. Makes every decision
  // that the print will make, but no mask. Throws TooManyLayers.
  [[nodiscard]] std::vector<Nanometers> all() const;

 private:
  LayerStack uniform_;
  std::vector<StandingModel> models_;  // empty if uniform
  AdaptiveLayers adaptive_;
  Millimeters top_{};  // top of the highest model, above the plate
};

}  // namespace contourd
