// The plan of a continuous print: the rises, and what lies between them. Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/continuous/rise_planner.hpp"
#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/print/print_plan.hpp"
#include "daemon/print/rise_change.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The printer's figures for continuous prints.
struct ContinuousMachine {
  double irradiance_mw_cm2 = 0;
  double masks_per_s = 0;  // one a refresh
  Micrometers microstep{};
  std::optional<MillimetersPerSecond> top_speed{};
  MillimetersPerSecondSquared acceleration{};
  Duration mask_budget{};
  Nanometers travel{std::numeric_limits<std::int64_t>::max()};
};

[[nodiscard]] ContinuousMachine continuous_machine(const PrinterConfig& printer);

// Returns a sentence with the reason why no print can be continuous: the profile lacks something, or the
// speed is too slow even for the smallest section. Empty if there is none.
[[nodiscard]] std::string continuous_refusal(const ResinProfile& resin, const ContinuousMachine& machine);

// Returns the bounds of the rises. REQUIRES: no continuous_refusal().
[[nodiscard]] RiseBounds rise_bounds(const ResinProfile& resin, const ContinuousMachine& machine);

// The print whose rises are planned.
struct ContinuousSubject {
  DisplayGeometry display{};
  Nanometers layer{};  // thickness of its layers
  Nanometers top{};
};

// Returns the slabs by which the rises of a print are planned. Throws ComputationStopped. Blocks for up to a
// thousand masks. REQUIRES: no continuous_refusal(), an engine with the resin's compensation and this
// display.
[[nodiscard]] std::vector<RiseSlab> continuous_slabs(ContourEngine& engine, const ContinuousSubject& subject,
                                                     const ResinProfile& resin,
                                                     const ContinuousMachine& machine, StopCheck& stop);

// Returns the rises through these slabs, from the top of the first layers up; none if the print is too wide
// throughout. REQUIRES: no continuous_refusal(); slabs of continuous_slabs() for layers of this thickness,
// and the same penetration depth, dead zone and margin.
[[nodiscard]] std::vector<RisePlan> rises_through(std::span<const RiseSlab> slabs, Nanometers layer,
                                                  const ResinProfile& resin,
                                                  const ContinuousMachine& machine);

// Returns the rises as parts of a print whose layers have these thicknesses, and these times if printed one
// by one. A rise follows a rest where it and the rises before would use up the window's oxygen; the time of
// the layers between them is part of that rest. REQUIRES: a time for each layer, and rises that begin and end
// between layers.
[[nodiscard]] std::vector<PlannedRise> rises_between(std::vector<RisePlan> rises,
                                                     std::span<const Nanometers> layers,
                                                     std::span<const Duration> layer_times,
                                                     const ContinuousResin& resin);

// Returns a sentence with the reason why a print has no rise, so that it is layered throughout.
[[nodiscard]] std::string why_no_rise(const ContinuousSubject& subject, const ResinProfile& resin);

// A range of heights that is printed in one way.
struct ContinuousRange {
  Nanometers bottom{}, top{};
  std::optional<RiseLimit> limit{};           // nullopt: layers
  MillimetersPerSecond slowest{}, fastest{};  // but for ramps of less than a hundredth of the range
  Duration time{};                            // the moves before and after a rise are part of its first range
  Duration rest{};                            // at the top, in the dark, before a rise
};

// Returns the ranges of a print, from the plate up: each rise in ranges with one limit, and the layers
// between. Their times and rests add up to `times`, those of layer_durations(). REQUIRES: a time for each
// expected layer.
[[nodiscard]] std::vector<ContinuousRange> ranges_of(const PrintPlan& plan, std::span<const Duration> times);

// The plan of a continuous print, for a person.
struct ContinuousForecast {
  RiseBounds bounds{};
  std::vector<ContinuousRange> ranges{};

  // Returns the time of all ranges and rests.
  [[nodiscard]] Duration time() const;
};

// The plan of a print's rises since they were changed.
struct ChangedForecast {
  Nanometers from{};
  RiseSettings settings{};
  ContinuousForecast plan{};  // of the rises from there on, without what lies between them
};

// Returns the plan of the rises that are left, from the plate's height on.
[[nodiscard]] ChangedForecast changed_forecast(const RisesAhead& ahead, const ChangedRises& changed);
// Ends a plan at a height, where another begins. The time of a range that is cut there is shared by height.
void end_at(Nanometers height, ContinuousForecast& plan);

// Returns a sentence about what is printed layer by layer above the first layers, if that is more than a
// millimetre high; else an empty text.
[[nodiscard]] std::string layered_parts_sentence(const ContinuousForecast& forecast, Nanometers first_layers);

}  // namespace contourd
