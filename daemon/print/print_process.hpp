// Carries out a print: looks up the events from the machine, the clock and the user in the table of
// print_states.hpp and performs the effects found there. Whatever happens, a print ends with the light off.
// Event loop's thread only.
// PrintProcess has a method for each effect of the table, and all of them work on the layer under way and
// account for its light. It is larger than other classes for this reason.
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

// The plan of a print: everything that is decided before it starts.
struct PrintPlan {
  std::string job;
  std::unique_ptr<ContourEngine> engine;
  PrintLayers layers;  // queried layer by layer during the print
  // Returns the exposure of a layer, counted from 0, of this thickness.
  std::function<Duration(std::int32_t layer, Nanometers thickness)> exposure;
  std::vector<Nanometers> expected_layers;         // thicknesses, used only for the time left
  Duration mask_budget = std::chrono::seconds{1};  // time limit for one mask, computed on the event loop
  double pixel_area_mm2 = 0;
  ExposureTolerance tolerance;
  Nanometers lift{};
  MillimetersPerSecond lift_speed, retract_speed, travel_speed, homing_speed;
  Duration settle{}, rest{};
  // Used only for the time left: the lamp's warm-up time, and the plate's height after homing.
  Duration warm_up{};
  Nanometers home_height{};
};

// Returns the duration of an expected layer on this axis: exposure, peel, the move back down and the waits.
[[nodiscard]] Duration layer_duration(const PrintPlan& plan, std::int32_t layer, const ZAxis& axis);
// Returns the duration of an expected layer on an axis described by `move_duration(distance, speed)`.
template <typename MoveDuration>
[[nodiscard]] Duration layer_duration(const PrintPlan& plan, std::int32_t layer,
                                      const MoveDuration& move_duration) requires
    std::is_invocable_r_v<Duration, MoveDuration, Nanometers, MillimetersPerSecond> {
  return plan.exposure(layer, plan.expected_layers[static_cast<std::size_t>(layer)]) + plan.settle +
         plan.rest + move_duration(plan.lift, plan.lift_speed) +
         move_duration(-plan.lift, plan.retract_speed);
}

// The measured facts about one layer.
struct LayerRecord {
  std::int32_t layer = 0;  // from 0
  Nanometers bottom{};     // planned height of the layer's lower side above the plate
  Nanometers thickness{};
  Nanometers plate_height{};  // the axis' reading when the mask was computed
  Nanometers mask_height{};   // height of the cut through the model: half a layer below plate_height
  Duration exposure_asked{};
  // Bounds on the total time that the light was on for this layer, as far as its commands show (LightSpan).
  Duration exposure_least{}, exposure_most{};
  int exposure_parts = 0;      // more than 1 if the exposure was interrupted and continued later
  bool complete = false;       // the layer had all its light; false if the print ended before
  bool dark_confirmed = true;  // false if the light may have stayed on: exposure_most ends with the print
  Duration mask_time{};        // time to compute the mask (real time, also on a simulated printer)
  double area_mm2 = 0;         // exposed area
  std::uint32_t intersecting_facets = 0;
  std::uint32_t loops = 0;
  LayerCracks cracks;
  TimePoint shown_at{};  // vblank at which the mask appeared on the screen
};

// Returns the number of layers that had all their light.
[[nodiscard]] inline std::int64_t layers_exposed(const std::vector<LayerRecord>& layers) {
  return std::ranges::count(layers, true, &LayerRecord::complete);
}

enum class PrintOutcome { Done, Canceled, Failed };
[[nodiscard]] std::string_view name_of(PrintOutcome outcome);

// The receiver of a print's events. PrintProcess calls it from within its functions, so it must not call back
// into the process.
class PrintObserver {
 public:
  PrintObserver() = default;
  PrintObserver(const PrintObserver&) = delete;
  PrintObserver& operator=(const PrintObserver&) = delete;
  virtual ~PrintObserver() = default;

  virtual void state_changed(PrintState state) = 0;
  virtual void layer_done(const LayerRecord& layer) = 0;
  // Called when the print was interrupted: the light was turned off, and layer() waits for resume(). `what`
  // says why.
  virtual void interrupted(const std::string& what) = 0;
  // Called when a light that may have been on until now is confirmed off, or when the print ends without this
  // confirmation.
  virtual void light_gone() = 0;
  // Called when the print is over: the light is off and the process idle. `reason` says why it failed.
  virtual void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) = 0;
};

class PrintProcess {
 public:
  // Makes the machine safe. All arguments must outlive the process.
  PrintProcess(Machine& machine, Clock& clock, PrintObserver& observer);
  // Makes the machine safe and powers the projector off.
  ~PrintProcess();
  PrintProcess(const PrintProcess&) = delete;
  PrintProcess& operator=(const PrintProcess&) = delete;

  // Starts a print. REQUIRES: state() is Idle; the plan has at least one layer, and an exposure.
  void start(PrintPlan plan);

  // Requests a pause after the layer under way; if the plate already moves up for a pause, withdraws
  // resume().
  void pause();
  // Withdraws a pending pause, or continues a paused or interrupted print; an interrupted layer then gets the
  // light that it still lacks. Does not check that the machine is ready.
  void resume();
  // Turns the light off at once and moves the plate up; the print waits for resume(). `what` says why, in one
  // sentence. Does nothing while Idle.
  void interrupt(const std::string& what);
  // Ends the print: turns the light off at once and moves the plate to its parking height.
  void cancel();
  // Ends the print at once and leaves the plate where it is.
  void fail(const std::string& reason);

  [[nodiscard]] PrintState state() const { return state_; }
  [[nodiscard]] bool pause_pending() const { return pause_wanted_; }
  // Returns when a pause that is requested now takes effect, as a text for the user: "after this layer".
  // Empty if the print ends before. REQUIRES: not Idle.
  [[nodiscard]] std::string_view next_pause() const;
  [[nodiscard]] bool canceled() const { return canceled_; }
  // True from the light-on command until the light is confirmed off, or the print ends without this
  // confirmation.
  [[nodiscard]] bool light_may_be_on() const { return light_asked_; }
  // Returns what interrupted the print, until it is resumed; empty if nothing did.
  [[nodiscard]] const std::string& interruption() const { return interruption_; }
  // Returns the layer under way, from 0. REQUIRES: not Idle.
  [[nodiscard]] std::int32_t layer() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return layer_;
  }
  // Returns the height of the layer's upper side above the plate. REQUIRES: not Idle.
  [[nodiscard]] Nanometers layer_top() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return bottom_ + thickness_;
  }
  // Returns the thickness of the layer under way. REQUIRES: not Idle.
  [[nodiscard]] Nanometers layer_thickness() const {
    expects(state_ != PrintState::Idle, "a print is under way");
    return thickness_;
  }
  [[nodiscard]] bool on_last_layer() const { return !plan_->layers.thickness_at(layer_top()); }
  // Returns the mask that is or was last on the screen; its mask is null before the first layer. Valid until
  // the event loop's next turn.
  [[nodiscard]] ShownMask shown() const { return shown_; }
  // True if the mask is on the screen now, as far as is known.
  [[nodiscard]] bool shows_mask() const {
    return state_ == PrintState::Igniting || state_ == PrintState::Exposing;
  }
  // Returns the plan of the print under way; null while Idle.
  [[nodiscard]] const PrintPlan* plan() const { return plan_ ? &*plan_ : nullptr; }
  // Returns the time from now to the end of the print, with warm-up, homing and parking but without pauses,
  // provided that the layers are as expected. It stops counting down only while a state takes longer than
  // expected or waits for the user. REQUIRES: not Idle.
  [[nodiscard]] Duration time_left() const;
  // Returns the time from now to the end of the current state; nullopt if unknown. REQUIRES: not Idle.
  [[nodiscard]] std::optional<Duration> state_left() const;

 private:
  void handle(PrintEvent event);
  void perform(PrintEffect effect);
  // Returns a callback that does nothing once the state has changed, so that late answers are ignored.
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
  [[nodiscard]] Duration left_after_state() const;
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
  void report_layer();
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
  Nanometers bottom_{}, thickness_{};  // the layer under way
  bool pause_wanted_ = false;
  bool resume_wanted_ = false;  // requested while the plate still moves up for a pause
  bool canceled_ = false;
  std::string failure_;
  std::string interruption_;
  LayerRecord record_;  // the layer under way
  ShownMask shown_;
  bool layer_exposed_ = false;      // the layer has had all its light
  bool layer_reported_ = false;     // the record has been passed to the observer
  bool light_asked_ = false;        // a light was requested that is not in the record yet
  std::optional<LightSpan> light_;  // the requested light, as known when it was turned off
  TimePoint exposure_end_{};
  std::vector<Duration> left_after_;  // by expected layer: the time for it, all later layers and parking
  std::optional<TimePoint> estimated_end_;  // end of the current state
  std::unique_ptr<Timer> wait_;
  std::unique_ptr<Timer> deadline_;
};

}  // namespace contourd
