// Layers as thick as the surface allows, decided as the print goes from the facets just ahead: by the allowed
// cusp height of Dolenc and Makela, as in Pandey et al. 2003 and Zhou et al. 2004. Thread-safe (no shared
// state).
//
// A layer of thickness t on a surface whose unit normal has the vertical part n_z is a stair whose corner
// stands off the surface by t |n_z|. That is kept at or below the allowed cusp for every facet that the layer
// touches; or the layer ends where such a facet begins. So walls get thick layers, slopes thin ones, and flat
// faces lie at a layer's boundary.
#pragma once

#include "core/geometry/units.hpp"
#include "core/layers/layers.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

// Layers are whole micrometres: far below any cusp that shows, and it keeps thicknesses readable. A facet
// that reaches less than half of one into a layer does not count.
inline constexpr Nanometers kLayerStep{1000};

struct AdaptiveLayers {
  Nanometers thinnest, thickest;  // inclusive; counted in whole micrometres, rounded inwards
  Nanometers cusp;                // allowed distance of a stair's corner from the surface

  // 1 um <= thinnest <= thickest <= kThickestLayer, cusp > 0.
  [[nodiscard]] bool are_printable() const {
    return kLayerStep <= thinnest && thinnest <= thickest && thickest <= kThickestLayer &&
           cusp > Nanometers{};
  }
};

// How thick the layer on `bottom` (above the plate) is to be: never more than what the cusp
// allows, unless that is less than the thinnest. The next flat face or the model's top is approached so that
// the layer that ends there is not too thin, where that can be. What is left below the top may be less than
// the thinnest: then the layer reaches beyond it. The thickest when nothing is left. Its cost is in
// proportion to the facets near the layer. REQUIRES: layers.are_printable().
[[nodiscard]] Nanometers next_thickness(const StandingModel& model, Nanometers bottom,
                                        const AdaptiveLayers& layers);

}  // namespace contourd
