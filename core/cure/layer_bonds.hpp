// The dose with which pixels bond to the layer beneath, where they get less than full light: undersides that
// are dimmed, pixels that a compensation, a panel of few greys or the light's own width leaves grey. Not
// thread-safe.
//
// A pixel counts where the model fills all of it in both layers, and both become solid there. Where both were
// solid before the next peel, the light of these exposures has to reach down to the lower one. Where light
// from above solidifies them later, it has to reach both at once. What holds one of a pixel's eight
// neighbours holds the pixel: light that spreads leaves the corners of every layer with less.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/cure/cured_layers.hpp"

namespace contourd {

struct LayerBond {
  double dose = 0;        // at the lower side of the layer, over Ec
  std::size_t layer = 0;  // the upper one of the two
  std::size_t pixel = 0;
};

class LayerBonds {
 public:
  // REQUIRES: width >= 1, in pixels.
  LayerBonds(const CureSettings& settings, std::span<const LayerDose> layers, std::size_t width);

  // The light of a layer, by pixel. `covered` is 255 where models and supports fill the pixel; `share` and
  // `dose` are what CuredLayers::add_layer() was given and what it returned.
  struct Light {
    std::span<const std::uint8_t> covered;
    std::span<const float> share, dose;
  };
  // Adds a layer by its number. REQUIRES: all layers, each once, from the top down, with as many pixels,
  // which are whole rows.
  void add_layer(std::size_t number, const Light& light);
  // Returns the weakest bond of pixels that get less than full light; nullopt if there are none.
  [[nodiscard]] std::optional<LayerBond> weakest() const { return weakest_; }

 private:
  // A filled pixel of the last layer that became solid with less than full light. The doses, over Ec, are the
  // greatest of this pixel and its filled neighbours.
  struct Dimmed {
    std::size_t pixel;
    float own;   // at the layer's top until the next peel
    float dose;  // of all layers
  };
  void compare(std::size_t upper, const Light& lower);
  void gather(std::size_t number, const Light& light);
  [[nodiscard]] Dimmed dimmed(std::size_t number, const Light& light, std::size_t pixel) const;
  [[nodiscard]] double own_dose(std::size_t number, const Light& light, std::size_t pixel) const;

  std::span<const LayerDose> layers_;
  std::size_t width_;
  double depth_mm_, critical_, dead_zone_mm_;
  std::vector<Dimmed> dimmed_;
  std::vector<float> above_;  // by pixel: dose of the layers above since the next peel; empty: none
  std::optional<LayerBond> weakest_;
};

}  // namespace contourd
