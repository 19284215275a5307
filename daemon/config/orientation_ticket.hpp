// Reads the part of a ticket that lets contourd choose a model's orientation: "up": "auto" and "keep_clean".
// Thread-safe (no shared state).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/orientation/orientation_figures.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {

// The goals by which contourd chooses the orientation.
struct OrientationTicket {
  OrientationPreset preset = OrientationPreset::Auto;
  std::vector<KeepClean> keep_clean{};
  bool operator==(const OrientationTicket&) const = default;
};

// Checks the rules across keys for the model at the pointer `place`, which must be an object; adds violations
// to the document.
void check_orientation_rules(JsonDocument& document, const std::string& place);
// Returns nullopt if "up" is a direction or missing. The model must satisfy check_orientation_rules().
[[nodiscard]] std::optional<OrientationTicket> read_orientation(const JsonSection& model);

}  // namespace contourd
