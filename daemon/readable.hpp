// Values as a person reads them. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/config/printable.hpp"  // IWYU pragma: export
#include "hw/clock.hpp"

namespace contourd {

// "3 h 05 min", "12 min 30 s", "4.2 s".
[[nodiscard]] std::string readable(Duration duration);

}  // namespace contourd
