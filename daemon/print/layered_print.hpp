// The layered print mode: exposes a layer, peels it off, lifts the plate and lowers it for the next layer.
// Looks up the events from the machine, the clock and the user in the table of layered_states.hpp and
// performs the effects found there. Whatever happens, a print ends with the light off. Event loop's thread
// only. Where a rise of the plan begins, the layered print ends in the dark, with the plate lifted and the
// projector on. LayeredPrint has a method for each effect of the table, and all of them work
// on the layer under way and account for its light. It is larger than other classes for this reason.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/peel/peel_watch.hpp"
#include "daemon/print/layered_states.hpp"
#include "daemon/print/machine_process.hpp"
#include "daemon/print/print_mode.hpp"
#include "hw/machine.hpp"

namespace contourd {

class LayeredPrint final : public PrintMode, private MachineProcess<LayeredTransition> {
 public:
  // The reason why the exposure of a print with rises is fixed.
  static constexpr std::string_view kFixedExposure =
      "the exposure of a continuous print follows from the speeds that were planned before it began";

  // Makes the machine safe. All arguments must outlive the process.
  LayeredPrint(Machine& machine, Clock& clock, PrintObserver& observer);
  // Makes the machine safe and powers the projector off.
  ~LayeredPrint() override;

  void start(PrintPlan plan) override;
  // Goes on with the layers on top of a rise, in the dark, with the plate lifted and the projector on.
  // REQUIRES: !under_way(); the plan has a layer at `bottom`, which is the layer with this number, from 0.
  void go_on(PrintPlan plan, std::int32_t layer, Nanometers bottom);
  void pause() override;
  void pause_at(PausePoint point) override;
  void resume() override;
  void set(const PrintSettings& settings) override;
  // Changes the last rises of the plan. REQUIRES: under_way(), and a plan with at least as many.
  void change(const ChangedRises& rises) override;
  void exclude(ExcludedCopy copy) override;
  void interrupt(const std::string& what) override;
  void cancel() override;
  void fail(const std::string& reason) override;

  [[nodiscard]] const PrintState& state() const override;
  [[nodiscard]] LayeredState layered_state() const { return MachineProcess::state(); }
  [[nodiscard]] bool pause_pending() const override { return pause_wanted_; }
  [[nodiscard]] const std::optional<PausePoint>& planned_pause() const override { return planned_pause_; }
  [[nodiscard]] std::string_view why_fixed(std::string_view what) const override;
  [[nodiscard]] PrintSettings settings() const override;
  [[nodiscard]] std::string_view next_pause() const override;
  [[nodiscard]] bool can_resume() const override;
  [[nodiscard]] bool can_cancel() const override;
  [[nodiscard]] std::string_view why_it_ends() const override;
  [[nodiscard]] const std::string& interruption() const override { return interruption_; }
  [[nodiscard]] bool light_may_be_on() const override { return light_asked_; }
  [[nodiscard]] std::int32_t layer() const override;
  [[nodiscard]] Nanometers layer_top() const override;
  [[nodiscard]] Nanometers layer_thickness() const override;
  [[nodiscard]] ShownMask shown() const override { return shown_; }
  [[nodiscard]] bool shows_mask() const override;
  [[nodiscard]] Duration time_left() const override;
  [[nodiscard]] std::optional<Duration> state_left() const override;

 private:
  void perform(LayeredEffect effect) override;
  void performed(LayeredEvent event) override;
  void effect_threw(const std::string& what) override;
  void settled() override;
  void wait(Duration duration);
  [[nodiscard]] bool on_last_layer() const { return !plan_->layers.thickness_at(layer_top()); }
  [[nodiscard]] bool rises_next() const;
  void begin(PrintPlan plan, std::int32_t layer, Nanometers bottom);
  void take_layer_beneath();
  void begin_press_shape();
  void take_press_shape();
  [[nodiscard]] Duration exposure_left() const { return record_.exposure_asked - record_.exposure_most; }
  void estimate(Duration duration) { estimated_end_ = clock_.now() + duration; }
  [[nodiscard]] Duration homing_duration() const;
  [[nodiscard]] Duration parking_duration(Nanometers from) const;
  [[nodiscard]] Duration lowering_duration() const;
  [[nodiscard]] Duration left_after_state() const;
  [[nodiscard]] Duration left_of_layer() const;
  // A part of a move, at one speed.
  struct Stage {
    Nanometers target;
    MillimetersPerSecond speed;
  };
  void move_to(Stage first, std::optional<Stage> second = std::nullopt);
  void lower();
  void meet_resistance();
  void lift();
  void watch_peel();
  void take_force(const ForceChange& change);
  void judge_peel();
  void show_black();
  void home();
  void find_plate();
  void show_mask();
  void abandon_mask(const MaskBudget& spent);
  void record_layer();
  void finish();
  void after_move(LayeredState move_state, MoveResult result);
  [[nodiscard]] bool is_in(EnumSet<LayeredState> states) const { return states.contains(layered_state()); }
  [[nodiscard]] Nanometers current_height() const;
  void expect_layers();
  void take_settings(const PrintSettings& settings);
  void next_layer();
  [[nodiscard]] std::optional<PrintPhase> phase() const;
  [[nodiscard]] PrintProgress progress(PrintPhase phase) const;
  [[nodiscard]] Nanometers above_mask() const;
  void begin_layer(Nanometers bottom);
  void expose();
  void time_exposure();
  void await_picture();
  void show_picture();
  void draw_picture();
  void turn_light_off();
  void note_late_picture();
  [[nodiscard]] bool light_went_off() const;
  void expect_darkness();
  void is_dark();
  void count_light();
  void report_layer();
  void judge_exposure();
  void pause_because(const std::string& what);
  void display_lost();
  [[nodiscard]] LayeredEvent next_due() const;
  [[nodiscard]] bool has_all_light() const;
  [[nodiscard]] bool planned_pause_due() const;

  PrintObserver& observer_;
  std::optional<PrintPlan> plan_;
  std::int32_t layer_ = 0;
  Nanometers bottom_{}, thickness_{};  // the layer under way
  bool pause_wanted_ = false;
  std::optional<PausePoint> planned_pause_;
  bool resume_wanted_ = false;  // requested while the plate still moves up for a pause
  bool canceled_ = false;
  std::string failure_;
  std::string interruption_;
  std::optional<PrintSettings> new_settings_;  // from the next layer on
  std::vector<ExcludedCopy> new_exclusions_;   // from the next layer on
  LayerRecord record_;                         // the layer under way
  double pressed_shape_mm4_ = 0;               // factor of the face that presses out resin next
  std::future<double> next_shape_;             // this factor, while a thread computes it
  ShownMask shown_;
  bool layer_exposed_ = false;           // the layer has had all its light
  bool layer_reported_ = false;          // the record has been passed to the observer
  std::optional<Stage> second_stage_;    // follows the move under way
  std::optional<PeelWatch> peels_;       // if there is a force line
  bool layer_peeled_ = false;            // the layer's peel has been watched
  std::optional<TimePoint> peel_begun_;  // of the lift under way, if its peel is watched
  bool let_go_ = false;                  // the first stage of this lift ends early, because the layer let go
  std::optional<LightSpan> light_;       // the requested light, as known when it was turned off
  std::vector<Duration> left_after_;     // by expected layer: the time for it, all later layers and parking
};

}  // namespace contourd
