// Layers as thick as the surface allows, chosen during the print from the facets just ahead: by the allowed
// cusp height of Dolenc and Makela, as in Pandey et al. 2003 and Zhou et al. 2004. Thread-safe (no shared
// state).
//
// On a surface whose unit normal has the vertical part n_z, a layer of thickness t is a stair whose corner
// stands off the surface by t |n_z|. This distance is kept at or below the allowed cusp for every facet that
// the layer touches, unless the layer ends where the facet begins. So walls get thick layers, slopes get thin
// ones, and flat faces lie at the boundary of a layer.
#pragma once

#include "core/geometry/units.hpp"
#include "core/layers/layers.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

// Layers are whole micrometres thick: far below any visible cusp, and thicknesses stay readable. A facet that
// reaches less than half a micrometre into a layer does not count.
inline constexpr Nanometers kLayerStep{1000};

struct AdaptiveLayers {
  Nanometers thinnest, thickest;  // inclusive; rounded inwards to whole micrometres
  Nanometers cusp;                // allowed distance of a stair's corner from the surface

  // True if 1 um <= thinnest <= thickest <= kThickestLayer and cusp > 0.
  [[nodiscard]] bool are_printable() const {
    return kLayerStep <= thinnest && thinnest <= thickest && thickest <= kThickestLayer &&
           cusp > Nanometers{};
  }
};

// Returns the thickness of the layer on `bottom` (above the plate): never more than the cusp allows, unless
// that is less than the thinnest. The next flat face or the model's top is approached so that the layer that
// ends there is not too thin, if possible. If less than the thinnest is left below the top, the layer reaches
// beyond the top. Returns the thickest if nothing is left. The cost is in proportion to the facets near the
// layer. REQUIRES: layers.are_printable().
[[nodiscard]] Nanometers next_thickness(const StandingModel& model, Nanometers bottom,
                                        const AdaptiveLayers& layers);

}  // namespace contourd
