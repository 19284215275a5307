// The resin that a print's light solidifies, layer by layer from the top down. Values; CuredLayers is not
// thread-safe.
//
// The film is at the top of the layer under exposure, and the light falls off with the depth below it, into
// the layers that were exposed before. So resin at a height gets light with its own layer and with all later
// ones: E exp(-(top - height) / Dp) of each (Beer and Lambert, thesis equation 2.1). Light on solid resin
// changes nothing; resin that is still liquid solidifies when its dose reaches the critical dose Ec. That is
// how undersides grow downwards (print-through). At each peel the liquid is stirred and takes up oxygen: it
// keeps the share `peel_memory` of its dose, and loses `oxygen_dose` more. Between layers without a peel
// nothing is lost, so that a plate that rises without a stop is a sequence of thin layers.
//
// Within a layer the dose grows towards the layer's top, by one factor for all later layers. A single figure
// for each pixel and layer, the greatest dose that the layer's top had over Ec, therefore gives the exact
// height from which on the layer is solid: Dp ln(dose / Ec) below its top.
//
// The model leaves out heat, diffusion, and the divergence of the light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "core/cure/working_curve.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

struct CureSettings {
  WorkingCurve curve{};
  double peel_memory = 1;           // 0 to 1
  MillijoulesPerCm2 oxygen_dose{};  // not negative
  Micrometers dead_zone{};          // above the film, kept liquid by oxygen; not negative

  bool operator==(const CureSettings&) const = default;
};

// The exposure of a layer.
struct LayerDose {
  Nanometers top{};  // height of the film above the plate
  Nanometers thickness{};
  MillijoulesPerCm2 dose{};  // at the film, of a fully lit pixel
  // False if the next layer above is exposed without a peel before: the plate rises without a stop.
  bool peeled = true;
};

class CuredLayers {
 public:
  // REQUIRES: settings within their ranges.
  CuredLayers(const CureSettings& settings, std::size_t pixels);

  // Adds the layer below those that were added before, with each pixel's share of the light, 0 to 1. Returns
  // for each pixel the greatest dose that the layer's top had over Ec; if a smaller one solidifies the whole
  // layer, that one may be returned. Valid until the next call. Costs a step a pixel; where memory is lost, a
  // step for each layer whose light reaches a pixel that its own layer lights, but does not solidify, and the
  // first dark one below. REQUIRES: `pixels` shares; layers that do not overlap, from the top down.
  [[nodiscard]] std::span<const float> add_layer(const LayerDose& layer, std::span<const float> light);

  // Returns the height at which a layer's solid ends: its top, less the dead zone.
  [[nodiscard]] Millimeters solid_top(const LayerDose& layer) const;
  // Returns the thickness of the solid below solid_top() for a dose of add_layer(): 0 if the layer stays
  // liquid, at most the layer's thickness.
  [[nodiscard]] Millimeters solid_thickness(const LayerDose& layer, float dose) const;
  // Returns the dose at a layer's top, over Ec, that solidifies down to a depth below solid_top().
  [[nodiscard]] double dose_at_top(Millimeters depth) const;

 private:
  // An exposed layer whose light reaches the last one's top. Layers that no peel separates are one, with the
  // light that they give together at the lowest one's top.
  struct LitLayer {
    Nanometers top{};
    double dose = 0;                   // of a fully lit pixel over Ec, above the dead zone
    std::vector<std::uint16_t> light;  // by pixel, 65535 for all of it
  };
  // The greatest dose that a pixel's resin ever had.
  struct Greatest {
    double dose = 0;        // in units of Ec
    std::size_t layer = 0;  // of layers_, after whose light the resin had it
  };
  void sum_doses(const LayerDose& layer, double dose, std::span<const float> light);
  void follow_doses(const LayerDose& layer, double dose, std::span<const float> light);
  [[nodiscard]] double dose_in_the_dark(std::size_t pixel);
  void remember(const LayerDose& layer, double dose, std::span<const float> light);
  void add_to_last(const LayerDose& layer, double dose, std::span<const float> light);
  void reach(Nanometers top);
  [[nodiscard]] Greatest greatest_dose(std::size_t pixel, double below_top_mm) const;
  [[nodiscard]] double greatest_solid(std::size_t pixel, double thickness_mm) const;

  CureSettings settings_;
  double depth_mm_;          // Dp
  double kept_, lost_;       // at a peel: factor, and subtraction in units of Ec
  std::vector<float> dose_;  // result of the last layer
  Nanometers last_top_{};
  std::deque<LitLayer> layers_;       // from the last one up; empty if nothing is lost at a peel
  std::vector<std::uint16_t> spare_;  // the memory of a layer that was forgotten
  std::vector<double> reaching_;    // by layer of layers_: its light at the last one's top, over light's unit
  std::vector<double> most_above_;  // by layer of layers_: the most that one layer above it can add
  std::vector<std::uint16_t> unlit_;  // by pixel: layers since the last one that lit it
  // A greatest dose from layers above a pixel that is dark: as a share of what reaches the pixel of the layer
  // after whose light the resin had it. Dark layers below have the same share.
  struct DarkDose {
    double share = 0;
    std::size_t layer = 0;  // its number in pushed_ layers; 0: not known
  };
  std::vector<DarkDose> in_the_dark_;  // by pixel; empty if the share is not the same, or nothing is lost
  std::size_t pushed_ = 0;             // layers that were added to layers_
};

}  // namespace contourd
