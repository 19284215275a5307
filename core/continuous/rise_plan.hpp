// The speed of a plate that rises without a stop, planned by height. Values and pure functions; thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "core/geometry/units.hpp"

namespace contourd {

// The law that holds the speed down.
enum class RiseLimit : std::uint8_t { Cure, Refill, Oxygen, Machine };

struct RisePoint {
  Nanometers height;
  MillimetersPerSecond speed;
  RiseLimit limit;  // from this point to the next
  bool operator==(const RisePoint&) const = default;
};

// A rise from rest to rest. Heights rise strictly. Between two points the acceleration is constant: the
// square of the speed is linear in height. The first and the last speed are 0, all others are positive.
struct RisePlan {
  std::vector<RisePoint> points;
  // The plate goes on for so long above the last point, until resin has gelled up to there.
  Nanometers overrun{};
  bool operator==(const RisePlan&) const = default;
};

// Returns the plan of the plate's whole way, whose last point is higher by the overrun. It is passed at the
// speed before the last ramp.
[[nodiscard]] RisePlan with_overrun(const RisePlan& plan);

// Returns the time between two points that follow each other.
[[nodiscard]] std::chrono::duration<double> duration(const RisePoint& from, const RisePoint& to);

// Returns the time that the rise takes without its overrun. REQUIRES: a plan as described above.
[[nodiscard]] std::chrono::duration<double> duration(const RisePlan& plan);

// Returns the time that the rise takes between two heights.
[[nodiscard]] std::chrono::duration<double> duration(const RisePlan& plan, Nanometers low, Nanometers high);

// Returns the speed at a height; 0 below the first point and above the last.
[[nodiscard]] MillimetersPerSecond speed_at(const RisePlan& plan, Nanometers height);

}  // namespace contourd
