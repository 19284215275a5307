// The settings of a resin and its window for continuous printing. Value types and pure functions;
// thread-safe.
#pragma once

#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

class JsonDocument;
class JsonSection;

// The way in which a rise goes on when a mask is not on the screen at its refresh. Whatever is chosen, the
// light goes off before the shown mask is too far from the plate's height.
enum class MissedMasks {
  Keep,   // rises on; the mask is counted
  Slow,   // rises on more slowly
  Pause,  // turns dark and waits for the user
};

// The section `continuous` of a resin's profile.
struct ContinuousResin {
  double margin = 0;               // least dose over the critical one; above 1
  double refill_pressure_kpa = 0;  // pressure that resin may lose on its way into the gap
  Duration window{};               // light after which the window's oxygen is used up
  Duration recovery{};             // dark after which the window has its oxygen again
  Nanometers layered{};            // height of the first layers
  Micrometers mask_step{};         // travel after which a mask is out of date
  MillimetersPerSecond slowest{}, fastest{};
  MissedMasks missed = MissedMasks::Keep;
  bool operator==(const ContinuousResin&) const = default;
};

// Reads the section; nullopt if the profile has none.
[[nodiscard]] std::optional<ContinuousResin> read_continuous(const JsonSection& profile);
// Checks the rules that the schema cannot say.
void check_continuous(JsonDocument& profile);

}  // namespace contourd
