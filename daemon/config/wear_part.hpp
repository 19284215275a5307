// The wear parts of a machine, their use since the last replacement, and the limits for reminders. Value
// types; thread-safe.
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

// The use of a part in prints; light and moves by manual control are not counted.
struct WearPartUse {
  WearPart part{};
  std::optional<std::chrono::system_clock::time_point>
      replaced{};                       // nullopt: counted from the start of the history
  double lamp_h = 0;                    // hours of light
  std::int64_t layers = 0, prints = 0;  // with light
};

// The limits of a part's use; a replacement is due once any of them is reached. nullopt: no limit.
struct WearLimits {
  std::optional<double> lamp_h{};
  std::optional<std::int64_t> layers{}, prints{};
};

struct ReminderConfig {
  WearLimits lamp{}, film{}, vat{};
};

}  // namespace contourd
