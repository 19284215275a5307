// The layers of a sweep: a print's own layers, or layers of one default thickness. A value; thread-safe as
// any value is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/units.hpp"

namespace contourd {

// The thickness of a sweep's layers if the print's layers are not known.
inline constexpr Nanometers kDefaultSweptLayer{50'000};

// Layers count from 1: layer 0 is the plate.
class SweepLayers {
 public:
  // Makes layers of these thicknesses, or of kDefaultSweptLayer up to `top` if there are none. Neighbouring
  // layers are swept as one where there would be more than kMostLayers.
  SweepLayers(std::span<const Nanometers> thicknesses, Millimeters top);

  // The number of layers fits into 16 bits.
  static constexpr std::size_t kMostLayers = 60'000;

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(tops_.size()) - 1; }
  // The height above the plate at which a layer begins, ends, and is cut.
  [[nodiscard]] Nanometers bottom_of(std::int32_t layer) const { return top_of(layer - 1); }
  [[nodiscard]] Nanometers top_of(std::int32_t layer) const { return tops_[static_cast<std::size_t>(layer)]; }
  [[nodiscard]] Nanometers middle_of(std::int32_t layer) const {
    return bottom_of(layer) + thickness_of(layer) / 2;
  }
  [[nodiscard]] Nanometers thickness_of(std::int32_t layer) const { return top_of(layer) - bottom_of(layer); }
  // Returns the step at which the swept material is recorded: the thinnest layer, but 20 to 50 um.
  [[nodiscard]] Nanometers step() const;

 private:
  std::vector<Nanometers> tops_;  // by layer, beginning with the plate
};

}  // namespace contourd
