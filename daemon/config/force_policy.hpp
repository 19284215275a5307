// The reactions of a print to the force on the plate. Value type; thread-safe.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

struct ForcePolicy {
  Nanometers contact_from{};         // as in ForceConfig
  bool resistance_fails = false;     // otherwise it pauses the print
  double least_peel_area_mm2 = 0;    // of a layer whose peel is felt
  bool pauses_without_peel = false;  // otherwise the user is only warned
};

}  // namespace contourd
