// What must hold of every print with supports, looked for in its masks and its primitives by code that shares
// nothing with what makes them. Pure; thread-safe. Blocks for as long as all masks take.
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

// A sentence for each rule that is broken, with how often and where first. The rules: each part of a layer
// lies on something of the layer below, 50 um beneath; supports are in a model only where a tip is, and
// elsewhere no nearer than the clearance; all of them is above the plate, within the display; no contact
// holds more than it can.
[[nodiscard]] std::vector<std::string> broken_rules(const SupportedPrint& print);

}  // namespace contourd::reference
