// The plan of a continuous print: the rises, and what lies between them. Pure functions; thread-safe.
#pragma once

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

// Returns the rises, from the top of the first layers up; none if the print is too wide throughout. Throws
// ComputationStopped. Blocks for up to a thousand masks. REQUIRES: no continuous_refusal(), an engine with
// the resin's compensation and this display.
[[nodiscard]] std::vector<RisePlan> plan_continuous(ContourEngine& engine, const ContinuousSubject& subject,
                                                    const ResinProfile& resin,
                                                    const ContinuousMachine& machine, StopCheck& stop);

// Returns the rise of a print in layers of one thickness: the last one, if it reaches the top; the print is
// layered up to it. nullopt if no rise reaches the top, or if the last one does not begin on top of a layer.
[[nodiscard]] std::optional<PlannedRise> rise_to_top(std::vector<RisePlan> rises,
                                                     const ContinuousSubject& subject,
                                                     const ContinuousResin& resin);

// Returns a sentence with the reason why a print has no rise_to_top().
[[nodiscard]] std::string why_no_rise(const ContinuousSubject& subject, const ResinProfile& resin);

// A range of heights that is printed in one way.
struct ContinuousRange {
  Nanometers bottom{}, top{};
  std::optional<RiseLimit> limit{};           // nullopt: layers
  MillimetersPerSecond slowest{}, fastest{};  // but for ramps of less than a hundredth of the range
  Duration time{};
  bool rests = false;  // in the dark at the top, until the window has its oxygen again
};

// Returns the ranges of a print, from the plate up: each rise in ranges with one limit, and the layers
// between, whose times are `layer_times`, by their thicknesses. REQUIRES: a time for each layer.
[[nodiscard]] std::vector<ContinuousRange> ranges_of(std::span<const RisePlan> rises,
                                                     std::span<const Nanometers> layers,
                                                     std::span<const Duration> layer_times);

}  // namespace contourd
