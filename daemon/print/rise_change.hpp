// The rises of a print that is under way, planned again with other settings. Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/continuous/rise_planner.hpp"
#include "daemon/print/print_plan.hpp"
#include "daemon/print/print_settings.hpp"

namespace contourd {

// The rises that are left, and what their speeds follow from.
struct RisesAhead {
  std::shared_ptr<const std::vector<RiseSlab>> slabs;
  RiseBounds bounds{};  // with all of the lamp's light
  double gamma = 1;     // of the projector
  RiseSettings settings{};
  std::vector<PlannedRise> each;       // at least one; `lit` of the first one includes its own light so far
  std::optional<Nanometers> height{};  // the plate's, if the first one is under way
};

struct ChangedRises {
  RiseSettings settings{};
  std::vector<RisePlan> each;  // the rises that are left
  // The height above which the first rise may be faster than before; nullopt if it is not under way. The
  // plate is not there before half a second has passed.
  std::optional<Nanometers> from{};
};

// Returns the rises with other settings, between the same heights; or a sentence with the reason why they
// are not possible. Blocks for some milliseconds.
[[nodiscard]] std::variant<ChangedRises, std::string> change_rises(const RisesAhead& ahead,
                                                                   const RiseSettings& settings);

// Takes over the rises that are left. REQUIRES: at least as many.
void take_change(const ChangedRises& changed, PlannedRises& rises);

// Returns the settings that these bounds are planned with: all light, and the fastest speed that the machine
// and the curing resin allow, rounded up.
[[nodiscard]] RiseSettings planned_settings(const RiseBounds& bounds);

// Returns the bounds with a print's settings.
[[nodiscard]] RiseBounds bounds_with(const RiseBounds& bounds, double gamma, const RiseSettings& settings);

// Returns the grey value with which white pixels give this share of the lamp's light, at least 1 percent,
// through a projector with this gamma; and the share that a grey value gives.
[[nodiscard]] std::uint8_t white_for(double light_percent, double gamma);
[[nodiscard]] double light_of(std::uint8_t white, double gamma);

}  // namespace contourd
