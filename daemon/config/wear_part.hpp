// The parts of a machine that wear by use, what one of them has been used since it was new, and when its
// owner wants to be reminded of it. Value types; thread-safe.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace contourd {

enum class WearPart { Lamp, Film, Vat };

inline constexpr std::array<WearPart, 3> kWearParts{WearPart::Lamp, WearPart::Film, WearPart::Vat};

[[nodiscard]] constexpr std::string_view name_of(WearPart part) {
  switch (part) {
    case WearPart::Lamp:
      return "lamp";
    case WearPart::Film:
      return "film";
    case WearPart::Vat:
      return "vat";
  }
  return "?";
}

// By prints alone: what was lit or moved by hand does not count.
struct WearPartUse {
  WearPart part{};
  std::optional<std::chrono::system_clock::time_point>
      replaced{};                       // nothing: counted from the history's begin
  double lamp_h = 0;                    // hours of light
  std::int64_t layers = 0, prints = 0;  // that had light
};

// From any of these on the part is due; nothing: never.
struct WearLimits {
  std::optional<double> lamp_h{};
  std::optional<std::int64_t> layers{}, prints{};
};

struct ReminderConfig {
  WearLimits lamp{}, film{}, vat{};
};

}  // namespace contourd
