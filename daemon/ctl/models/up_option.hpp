// What the option --up says: a direction of the model, or that the one which prints best is to be found.
// Thread-safe (no shared state).
#pragma once

#include <string>
#include <variant>

#include "core/model/placement.hpp"
#include "core/orientation/orientation_weights.hpp"

namespace contourd::ctl {

using UpOption = std::variant<OrientationPreset, Direction>;

// "auto", "fast", "clean", "safe" or "X,Y,Z". Throws UsageError for any other word, and for a direction that
// is zero or not finite.
[[nodiscard]] UpOption parse_up(const std::string& word);

}  // namespace contourd::ctl
