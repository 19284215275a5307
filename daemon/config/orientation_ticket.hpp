// What a ticket says of which way up a model is printed, where it leaves that to contourd: "up": "auto" and
// "keep_clean". Thread-safe (no shared state).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/orientation/orientation_figures.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {

// How contourd is to find it.
struct OrientationTicket {
  OrientationPreset preset = OrientationPreset::Auto;
  std::vector<KeepClean> keep_clean{};
  bool operator==(const OrientationTicket&) const = default;
};

// Rules across keys, of the model at that pointer; it is an object.
void check_orientation_rules(JsonDocument& document, const std::string& place);
// Nothing where "up" is a direction, or missing. The model keeps those rules.
[[nodiscard]] std::optional<OrientationTicket> read_orientation(const JsonSection& model);

}  // namespace contourd
