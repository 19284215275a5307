// The value of the option --up: a direction of the model, or a preset by which the best direction is found.
// Thread-safe (no shared state).
#pragma once

#include <string>
#include <variant>

#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd::ctl {

using UpOption = std::variant<OrientationPreset, Direction>;

// Parses "auto", "fast", "clean", "safe" or "X,Y,Z". Throws UsageError for any other word, and for a
// direction that is zero or not finite.
[[nodiscard]] UpOption parse_up(const std::string& word);

}  // namespace contourd::ctl
