// Rules for every print with supports, checked on its masks and primitives by code that is independent of the
// code that makes them. Pure; thread-safe. Blocks for as long as all masks take.
#pragma once

#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_primitive.hpp"
#include "core/support/support_settings.hpp"

namespace contourd::reference {

struct SupportedPrint {
  std::vector<PlateModel> models;
  DisplayGeometry display;
  SupportSettings settings;
  std::vector<SupportPrimitive> primitives;
  std::vector<SupportContact> contacts;
};

// Returns a sentence for each broken rule, with the number of violations and the first place. The rules: each
// part of a layer lies on something in the layer 50 um below; supports are in a model only at tips, and
// elsewhere no nearer than the clearance; all of them are above the plate and within the display; no contact
// holds more than it can.
[[nodiscard]] std::vector<std::string> broken_rules(const SupportedPrint& print);

}  // namespace contourd::reference
