// What holds a print, and what cannot be held. Values; thread-safe as any value is.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/support/support_contact.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {

// A place that has to be held and cannot be reached.
struct UnheldPlace {
  SupportContact contact;
  std::string why;  // a clause: "no way leads to the plate"
};

// A value.
struct Supports {
  std::shared_ptr<const SupportStructure> structure;  // null: nothing has to be held
  std::vector<SupportContact> contacts;               // that are held, from the plate up
  std::vector<UnheldPlace> unheld;                    // from the plate up
  std::uint32_t branches = 0, feet = 0, feet_on_models = 0;
  double volume_mm3 = 0;  // beside the models
};

}  // namespace contourd
