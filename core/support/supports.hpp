// The supports of a print, and the places that cannot be held. Values; thread-safe as any value is.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/engine/compensation.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {

// A place that has to be held but that no support reaches.
struct UnheldPlace {
  SupportContact contact;
  std::string why;  // a clause: "no path leads to the plate"
};

struct Supports {
  std::shared_ptr<const SupportStructure> structure{};  // null if nothing has to be held
  std::vector<SupportContact> contacts{};               // the contacts that are held, from the plate up
  std::vector<UnheldPlace> unheld{};                    // from the plate up
  std::vector<SupportContact> on_hairs{};    // held contacts on parts that are one pixel thick there
  std::vector<SupportContact> in_hollows{};  // held contacts in sealed hollows: their supports stay there
  std::vector<SupportContact> in_gaps{};     // held contacts over gaps that their supports fill
  std::vector<SupportContact> over_gaps{};   // not held: a support would join both sides of a narrow gap
  std::vector<SupportContact> resting{};  // islands so low that the bottom exposures join them to the plate
  std::uint32_t branches = 0, feet = 0, feet_on_models = 0;
  std::uint32_t carriers = 0;  // models that carry supports of their own, and get no others
  double volume_mm3 = 0;       // resin outside the models
};

// The masks of a print.
struct PrintedLayers {
  std::vector<Nanometers> thicknesses{};  // from the plate up; empty: not known
  Compensation compensation{};
  AntiAliasing anti_aliasing = AntiAliasing::On;
  std::uint8_t least_grey = 64;  // lowest grey value that carries the next layer
};

struct SupportRequest {
  std::vector<PlateModel> models;  // as they stand, already lifted by support_lift()
  DisplayGeometry display;         // the build area; no part of a support lies outside it
  SupportSettings settings;
  std::vector<PlateModel> carriers{};  // models that carry supports of their own, and get no others
  PrintedLayers printed{};
};

}  // namespace contourd
