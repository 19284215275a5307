// Carries a print out: takes events from the machine, the clock and the owner through the table of
// print_states.hpp and does what its rows say. Whatever happens, a print ends with the light off. Event
// loop's thread only.
//
// It is larger than other classes: each effect of the table is a method of it, and all of them work on the
// one layer under way and account for its light.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/print/print_states.hpp"
#include "daemon/print/shown_mask.hpp"
#include "hw/machine.hpp"

namespace contourd {

// How a print is to be made; everything decided before it starts.
struct PrintPlan {
  std::string job;
  std::unique_ptr<ContourEngine> engine;
  PrintLayers layers;  // asked layer by layer
  // Light of a layer, counted from 0, of this thickness.
  std::function<Duration(std::int32_t layer, Nanometers thickness)> exposure;
  std::vector<Nanometers> expected_layers;         // their thicknesses, for the time left only
  Duration mask_budget = std::chrono::seconds{1};  // for the computation of one mask, on the event loop
  double pixel_area_mm2 = 0;
  ExposureTolerance tolerance;
  Nanometers lift{};
  MillimetersPerSecond lift_speed, retract_speed, travel_speed, homing_speed;
  Duration settle{}, rest{};
  // For the time left only: how long the lamp takes to be warm, and where the plate is behind homing.
  Duration warm_up{};
  Nanometers home_height{};
};

// How long one of the expected layers takes on this axis: exposure, peel, the way back and the waits between.
[[nodiscard]] Duration layer_duration(const PrintPlan& plan, std::int32_t layer, const ZAxis& axis);
// The same where `move_duration(distance, speed)` stands for the axis.
template <typename MoveDuration>
[[nodiscard]] Duration layer_duration(const PrintPlan& plan, std::int32_t layer,
                                      const MoveDuration& move_duration) requires
    std::is_invocable_r_v<Duration, MoveDuration, Nanometers, MillimetersPerSecond> {
  return plan.exposure(layer, plan.expected_layers[static_cast<std::size_t>(layer)]) + plan.settle +
         plan.rest + move_duration(plan.lift, plan.lift_speed) +
         move_duration(-plan.lift, plan.retract_speed);
}

// What really happened to one layer.
struct LayerRecord {
  std::int32_t layer = 0;  // from 0
  Nanometers bottom{};     // where it was meant to lie, above the plate
  Nanometers thickness{};
  Nanometers plate_height{};  // where the axis said the plate was when the mask was computed
  Nanometers mask_height{};   // at which the model was cut: half a layer below
  Duration exposure_asked{};
  // Of the light, all parts: it shone for no less and no more, by what is known of its commands (LightSpan).
  Duration exposure_least{}, exposure_most{};
  int exposure_parts = 0;      // more than one when the exposure was interrupted and went on later
  bool complete = false;       // it had all its light; else the print ended before
  bool dark_confirmed = true;  // or else the light may have shone on: exposure_most is as of the print's end
  Duration mask_time{};        // processor time from the height to the mask (real time, also when simulated)
  double area_mm2 = 0;         // exposed
  std::uint32_t intersecting_facets = 0;
  std::uint32_t loops = 0;
  LayerCracks cracks;
  TimePoint shown_at{};  // vblank at which the mask was on the screen
};

// Those that had all their light.
[[nodiscard]] inline std::int64_t layers_exposed(const std::vector<LayerRecord>& layers) {
  return std::ranges::count(layers, true, &LayerRecord::complete);
}

enum class PrintOutcome { Done, Canceled, Failed };
[[nodiscard]] std::string_view name_of(PrintOutcome outcome);

// Told what goes on; called from within the process, which must not be called back from there.
class PrintObserver {
 public:
  PrintObserver() = default;
  PrintObserver(const PrintObserver&) = delete;
  PrintObserver& operator=(const PrintObserver&) = delete;
  virtual ~PrintObserver() = default;

  virtual void state_changed(PrintState state) = 0;
  virtual void layer_done(const LayerRecord& layer) = 0;
  // The light is off and the layer, as layer() has it, waits to be gone on with; `what` says why.
  virtual void interrupted(const std::string& what) = 0;
  // The light, which may have been on up to now, is confirmed off; or the print ends without that.
  virtual void light_gone() = 0;
  // The print is over: the light is off and the process idle. `reason` says why it failed.
  virtual void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) = 0;
};

class PrintProcess {
 public:
  // All must outlive the process.
  PrintProcess(Machine& machine, Clock& clock, PrintObserver& observer);
  // Leaves the machine safe.
  ~PrintProcess();
  PrintProcess(const PrintProcess&) = delete;
  PrintProcess& operator=(const PrintProcess&) = delete;

  // REQUIRES: state() is Idle; at least one layer; an exposure.
  void start(PrintPlan plan);

  // Pause after the layer under way, or no longer.
  void pause();
  // Also after an interruption: the layer under way then gets the light that it still lacks. Does not look
  // whether anything keeps the machine from printing.
  void resume();
  // Light off at once; the plate goes up, and the print waits for resume(). `what` says why, in one sentence.
  // Does nothing while Idle.
  void interrupt(const std::string& what);
  // Ends the print: light off at once, plate to its parking height.
  void cancel();
  // Ends the print at once and leaves the plate where it is.
  void fail(const std::string& reason);

  [[nodiscard]] PrintState state() const { return state_; }
  [[nodiscard]] bool pause_pending() const { return pause_wanted_; }
  // When a pause asked for now comes, for its owner: "after this layer". Empty where none does: the print
  // ends before. REQUIRES: not Idle.
  [[nodiscard]] std::string_view next_pause() const;
  [[nodiscard]] bool canceled() const { return canceled_; }
  // From light on's command until the light is confirmed off, or the print ends without that.
  [[nodiscard]] bool light_may_be_on() const { return light_asked_; }
  // What interrupted the print, until it is resumed; empty when nothing did.
  [[nodiscard]] const std::string& interruption() const { return interruption_; }
  // The layer under way, from 0. REQUIRES: not Idle.
  [[nodiscard]] std::int32_t layer() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return layer_;
  }
  // Its top above the plate. REQUIRES: not Idle.
  [[nodiscard]] Nanometers layer_top() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return bottom_ + thickness_;
  }
  // REQUIRES: not Idle.
  [[nodiscard]] Nanometers layer_thickness() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return thickness_;
  }
  [[nodiscard]] bool on_last_layer() const { return !plan_->layers.thickness_at(layer_top()); }
  // The mask that was on the screen last or is there; none before the first. Valid until the loop's next
  // turn.
  [[nodiscard]] ShownMask shown() const { return shown_; }
  // It is there now, as far as is known.
  [[nodiscard]] bool shows_mask() const {
    return state_ == PrintState::Igniting || state_ == PrintState::Exposing;
  }
  // Nothing while Idle.
  [[nodiscard]] const PrintPlan* plan() const { return plan_ ? &*plan_ : nullptr; }
  // From now to the end, pauses aside, as far as the layers are as expected: with warm-up, homing and
  // parking. It stands still only where a state takes longer than was expected, or waits for somebody.
  // REQUIRES: not Idle.
  [[nodiscard]] Duration time_left() const;
  // From now to the end of the state under way; nothing where nobody knows. REQUIRES: not Idle.
  [[nodiscard]] std::optional<Duration> state_left() const;

 private:
  void handle(PrintEvent event);
  void perform(PrintEffect effect);
  // A callback that does nothing once the state has changed: late answers belong to the past.
  template <typename Answer>
  std::function<void(Answer)> while_in_state(std::type_identity_t<std::function<void(Answer)>> call);
  void wait(Duration duration) { wait_until(clock_.now() + duration); }
  void wait_until(TimePoint when);
  [[nodiscard]] Duration exposure_left() const { return record_.exposure_asked - record_.exposure_most; }
  void expect_within(Duration duration, const std::string& what);
  void estimate(Duration duration) { estimated_end_ = clock_.now() + duration; }
  [[nodiscard]] Duration homing_duration() const;
  [[nodiscard]] Duration parking_duration(Nanometers from) const;
  [[nodiscard]] Duration lowering_duration(std::int32_t layer) const;
  [[nodiscard]] Duration left_behind_state() const;
  [[nodiscard]] Duration left_of_layer() const;
  void move_to(Nanometers target, MillimetersPerSecond speed);
  void power_on();
  void show_black();
  void home();
  void show_mask();
  void abandon_mask(const MaskBudget& spent);
  void record_layer();
  void finish();
  void after_move(MoveResult result);
  [[nodiscard]] Nanometers current_height() const;
  void begin_layer(Nanometers bottom);
  void light_on();
  void light_answered(ProjectorReply reply);
  void time_exposure();
  [[nodiscard]] bool light_went_off() const;
  void expect_darkness();
  void is_dark();
  void count_light();
  void tell_layer();
  void judge_exposure();
  void display_lost();
  [[nodiscard]] PrintEvent next_due() const;
  [[nodiscard]] bool has_all_light() const;

  Machine& machine_;
  Clock& clock_;
  PrintObserver& observer_;
  PrintState state_ = PrintState::Idle;
  std::uint64_t states_entered_ = 0;
  std::optional<PrintPlan> plan_;
  std::int32_t layer_ = 0;
  Nanometers bottom_{}, thickness_{};  // of the layer under way
  bool pause_wanted_ = false;
  bool resume_wanted_ = false;  // while the plate still rises for a pause
  bool canceled_ = false;
  std::string failure_;
  std::string interruption_;
  LayerRecord record_;  // of the layer under way
  ShownMask shown_;
  bool layer_exposed_ = false;      // it has had all its light
  bool layer_told_ = false;         // its record was
  bool light_asked_ = false;        // what light it gave is not in the record yet
  std::optional<LightSpan> light_;  // of that light, as it was known when it was told to go off
  TimePoint exposure_end_{};
  std::vector<Duration> left_after_;  // by expected layer: how long it, those behind it and parking take
  std::optional<TimePoint> estimated_end_;  // of the state under way
  std::unique_ptr<Timer> wait_;
  std::unique_ptr<Timer> deadline_;
};

}  // namespace contourd
