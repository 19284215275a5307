// The plan of a print, and the record of a printed layer. Value types; thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/continuous/rise_plan.hpp"
#include "core/continuous/rise_planner.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "core/peel/pressed_resin.hpp"
#include "daemon/config/force_policy.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/print/print_settings.hpp"
#include "daemon/print/split_exposure.hpp"
#include "hw/clock.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

// A rise of a continuous print.
struct PlannedRise {
  RisePlan plan;                 // begins on top of a layer
  std::int32_t first_layer = 1;  // number of layers beneath it
  Duration rest{};               // before it, in the dark, until the window has its oxygen again
  Duration lit{};                // by rises before it, since the window had all its oxygen
};

// The rises of a continuous print, from the plate up. What lies beneath, between and above them is printed
// layer by layer.
struct PlannedRises {
  std::vector<PlannedRise> each;
  Nanometers mask_step{2'000};  // a new mask when the height has changed by this much
  MissedMasks missed = MissedMasks::Keep;
  MillimetersPerSecond slowest{};  // for MissedMasks::Slow, and for speeds that are changed

  // Slabs, bounds and settings by which the speeds are planned again while it prints.
  std::shared_ptr<const std::vector<RiseSlab>> slabs{};  // null: they cannot be changed
  RiseBounds bounds{};                                   // with all of the lamp's light
  double gamma = 1;                                      // by which the resin cures, see ToneCurve
  RiseSettings settings{};
};

// The point from which a print goes on that a power cut ended. Its part hangs on the plate.
struct ResumePoint {
  std::int32_t layer = 0;  // the first layer to be lit, from 0
  Nanometers bottom{};     // of that layer
  // The height at which the plate is assumed to rest; nullopt: the axis homes upwards.
  std::optional<Nanometers> height{};
};

// The plan of a print: everything that is decided before it starts.
struct PrintPlan {
  std::string job;
  bool dry = false;  // all moves and masks, but no light
  std::unique_ptr<ContourEngine> engine;
  std::unique_ptr<DimmedMasks>
      undersides;                        // makes the masks from the engine's coverage; null: none are dimmed
  std::unique_ptr<SplitExposure> split;  // makes pictures of few greys from the masks, whose values are then
                                         // linear; null: masks are shown as they are
  std::optional<PlannedRises> rises;     // nullopt: the print is layered throughout
  PrintLayers layers;                    // queried layer by layer during the print
  // Returns the exposure of a layer, counted from 0, of this thickness.
  std::function<Duration(std::int32_t layer, Nanometers thickness)> exposure;
  double exposure_percent = 100;                   // share of these exposures, see PrintSettings
  std::vector<Nanometers> expected_layers;         // thicknesses, used only for the time left
  Duration mask_budget = std::chrono::seconds{1};  // time limit for one mask, computed on the event loop
  double pixel_area_mm2 = 0;
  ExposureTolerance tolerance;
  LayerMotion motion;
  std::optional<PressedResin> pressed;  // nullopt: areas do not count for the wait before the light
  double plate_shape_mm4 = 0;           // factor of the plate, which presses out resin before the first layer
  std::vector<double> expected_shapes{};  // factor of each expected layer, used only for the time left
  std::optional<ForcePolicy> force{};     // nullopt: there is no force line
  MillimetersPerSecond travel_speed, homing_speed;
  // Used only for the time left: the lamp's warm-up time, and the plate's height after homing.
  Duration warm_up{};
  Nanometers home_height{};
  std::optional<ResumePoint> resume{};  // nullopt: the print begins with its first layer
};

// True if a rise of the print begins at this height.
[[nodiscard]] inline bool rise_begins_at(const PrintPlan& plan, Nanometers height) {
  return plan.rises && std::ranges::any_of(plan.rises->each, [&](const PlannedRise& rise) {
           return rise.plan.points.front().height == height;
         });
}

// The longest wait before the light, whatever a layer's area is.
inline constexpr Duration kLongestSettling = std::chrono::seconds{60};

// Returns the wait before the light of a layer of this thickness, if the face that comes down has this
// factor.
[[nodiscard]] inline Duration settling_duration(const PrintPlan& plan, double shape_mm4,
                                                Nanometers thickness) {
  const Duration least = plan.motion.before_light();
  if (!plan.pressed) return least;
  const std::chrono::duration<double> pressed = press_time(*plan.pressed, shape_mm4, thickness);
  if (pressed >= kLongestSettling) return std::max(least, kLongestSettling);
  return std::max(least, std::chrono::duration_cast<Duration>(pressed));
}

// Returns the exposure of a layer by the print's settings.
[[nodiscard]] inline Duration exposure_of(const PrintPlan& plan, std::int32_t layer, Nanometers thickness) {
  const Duration planned = plan.exposure(layer, thickness);
  if (plan.exposure_percent == 100) return planned;
  return std::chrono::duration_cast<Duration>(planned * (plan.exposure_percent / 100));
}

// Returns the wait before the light of an expected layer.
[[nodiscard]] inline Duration expected_settling(const PrintPlan& plan, std::int32_t layer) {
  const auto at = static_cast<std::size_t>(layer);
  const double shape = layer == 0                          ? plan.plate_shape_mm4
                       : at <= plan.expected_shapes.size() ? plan.expected_shapes[at - 1]
                                                           : 0;
  return settling_duration(plan, shape, plan.expected_layers[at]);
}

// Returns the duration of the lift of a layer on an axis described by `move_duration(distance, speed)`.
template <typename MoveDuration>
[[nodiscard]] Duration lift_duration(const LayerMotion& motion, const MoveDuration& move_duration) {
  const Duration first = move_duration(motion.lift, motion.lift_speed);
  if (motion.second_lift == Nanometers{}) return first;
  return first + move_duration(motion.second_lift, motion.second_lift_speed);
}

// Returns the duration of a move down to a layer's height on such an axis.
template <typename MoveDuration>
[[nodiscard]] Duration lowering_duration(const LayerMotion& motion, Nanometers distance,
                                         MillimetersPerSecond speed, const MoveDuration& move_duration) {
  const Nanometers slow = std::clamp(distance, Nanometers{}, motion.slow_retract);
  const Duration first = move_duration(slow - distance, speed);
  if (slow == Nanometers{}) return first;
  return first + move_duration(-slow, motion.slow_retract_speed);
}
// Returns the duration of the move from a lift down to the next layer, of this thickness.
template <typename MoveDuration>
[[nodiscard]] Duration lowering_duration(const LayerMotion& motion, Nanometers thickness,
                                         const MoveDuration& move_duration) {
  return lowering_duration(motion, motion.whole_lift() - thickness, motion.retract_speed, move_duration);
}

// Returns the function that computes the duration of a move of this axis.
[[nodiscard]] inline auto moves_of(const ZAxis& axis) {
  return [&axis](Nanometers distance, MillimetersPerSecond speed) {
    return axis.move_duration(distance, speed);
  };
}

// Returns the expected duration of homing from a height: to the switch, back off it and to it again.
template <typename MoveDuration>
[[nodiscard]] Duration homing_duration(const PrintPlan& plan, Nanometers from,
                                       const MoveDuration& move_duration) requires
    std::is_invocable_r_v<Duration, MoveDuration, Nanometers, MillimetersPerSecond> {
  const MillimetersPerSecond slow{plan.homing_speed.count() / 2};
  return move_duration(plan.home_height - from, plan.homing_speed) +
         move_duration(kBackOff, plan.homing_speed) + move_duration(kBackOff, slow);
}

// The masks of a part of a rise.
struct FrameFigures {
  std::uint32_t shown = 0, missed = 0;  // a mask that was late by some refreshes is missed as often
  // The largest distance of a mask's cut from the plate's height at the middle of the refresh that showed it.
  Nanometers farthest{};
  Duration longest_cut{};    // real time
  std::uint32_t slowed = 0;  // number of times that the plate was slowed down for a missed mask

  FrameFigures& operator+=(const FrameFigures& other) {
    shown += other.shown;
    missed += other.missed;
    slowed += other.slowed;
    farthest = std::max(farthest, other.farthest);
    longest_cut = std::max(longest_cut, other.longest_cut);
    return *this;
  }
};

// The peel of a layer by the force on the plate, known after its lift.
struct PeelRecord {
  bool felt = false;                     // the force rose above the threshold
  std::optional<Nanometers> distance{};  // way of the plate until the layer let go
  Duration saved{};                      // time by which the lift was shorter
  bool missed = false;                   // the layer should have been felt, and the user was warned
};

// The measured facts about one layer, or about a slice of a rise that is as thick as one.
struct LayerRecord {
  std::int32_t layer = 0;  // from 0
  Nanometers bottom{};     // planned height of the layer's lower side above the plate
  Nanometers thickness{};
  Nanometers plate_height{};  // the axis' reading when the mask was computed
  // Height of the cut through the model: half a layer below plate_height; of pictures, the layer's middle.
  Nanometers mask_height{};
  Duration settling{};  // wait before the light
  Duration exposure_asked{};
  // Bounds on the total time that the light was on for this layer, as far as its commands show (LightSpan).
  Duration exposure_least{}, exposure_most{};
  int exposure_parts = 0;      // more than 1 if the exposure was interrupted and continued later
  bool complete = false;       // the layer had all its light; false if the print ended before
  bool dark_confirmed = true;  // false if the light may have stayed on: exposure_most ends with the print
  Duration mask_time{};        // time to compute the mask (real time, also on a simulated printer)
  double area_mm2 = 0;         // exposed area
  std::size_t pictures = 1;    // number of pictures that the exposure was planned to show
  double light_error = 0;      // largest difference of a pixel's planned light from its mask's, over white's
  Duration late_picture{};     // by how much a picture came later than planned, at most
  bool rises = false;          // a slice of a rise
  FrameFigures frames;         // figures of a slice of a rise
  bool undersides_found = true;      // false if undersides kept their light for lack of time
  std::optional<PeelRecord> peel{};  // nullopt: no force line, or no lift yet
  std::uint32_t intersecting_facets = 0;
  std::uint32_t loops = 0;
  LayerCracks cracks;
  TimePoint shown_at{};   // vblank at which the mask appeared on the screen
  Duration done_after{};  // time since the print's start, once the layer is in its record
};

// Returns the number of layers that had all their light.
[[nodiscard]] inline std::int64_t layers_exposed(const std::vector<LayerRecord>& layers) {
  return std::ranges::count(layers, true, &LayerRecord::complete);
}

// The split exposures of a print.
struct SplitFigures {
  std::size_t most_pictures = 1;  // of a layer
  double light_error = 0;         // the largest of any layer, as a share of white's light
  Duration late_picture{};        // of any layer, at most
};
[[nodiscard]] inline SplitFigures split_figures(const std::vector<LayerRecord>& layers) {
  SplitFigures figures;
  for (const LayerRecord& layer : layers) {
    figures.most_pictures = std::max(figures.most_pictures, layer.pictures);
    figures.light_error = std::max(figures.light_error, layer.light_error);
    figures.late_picture = std::max(figures.late_picture, layer.late_picture);
  }
  return figures;
}

// Returns the figures of all masks of a print's rises.
[[nodiscard]] inline FrameFigures frame_figures(const std::vector<LayerRecord>& layers) {
  FrameFigures figures;
  for (const LayerRecord& layer : layers)
    figures += layer.frames;
  return figures;
}

// The peels of a print.
struct PeelFigures {
  std::int64_t judged = 0, felt = 0, missed = 0;  // layers
  Duration saved{};
};
[[nodiscard]] inline PeelFigures peel_figures(const std::vector<LayerRecord>& layers) {
  PeelFigures figures;
  for (const LayerRecord& layer : layers) {
    if (!layer.peel) continue;
    ++figures.judged;
    figures.felt += layer.peel->felt;
    figures.missed += layer.peel->missed;
    figures.saved += layer.peel->saved;
  }
  return figures;
}

// Returns the number of layers in which undersides kept their light for lack of time.
[[nodiscard]] inline std::int64_t layers_with_unfound_undersides(const std::vector<LayerRecord>& layers) {
  return std::ranges::count(layers, false, &LayerRecord::undersides_found);
}

}  // namespace contourd
