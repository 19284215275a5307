// The continuous print mode: prints the first layers with a layered print, so that the part holds, then lets
// the plate rise in the light without a stop, with the masks of RiseFrames. Between two rises, it prints
// layers again, or rests in the dark until the window has its oxygen again. A plan without a rise is printed
// layer by layer to its end. Looks up the events of a rise in the table of continuous_states.hpp and performs
// the effects found there. A rise is recorded in slices with the thicknesses of the plan's layers. Event
// loop's thread only. Like LayeredPrint, it has a method for each effect of its table, and all of them work
// on the rise under way and account for its light. It is larger than other classes for this reason.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/print/continuous_states.hpp"
#include "daemon/print/layered_print.hpp"
#include "daemon/print/machine_process.hpp"
#include "daemon/print/print_mode.hpp"
#include "daemon/print/rise_frames.hpp"
#include "daemon/print/rise_progress.hpp"
#include "hw/machine.hpp"

namespace contourd {

class ContinuousPrint final : public PrintMode,
                              private MachineProcess<ContinuousTransition>,
                              private PrintObserver {
 public:
  // Makes the machine safe. All arguments must outlive the process.
  ContinuousPrint(Machine& machine, Clock& clock, PrintObserver& observer);
  // Makes the machine safe and powers the projector off.
  ~ContinuousPrint() override;

  // REQUIRES: as in PrintMode; rises start on top of layers, one after another, and their masks are neither
  // dimmed nor split.
  void start(PrintPlan plan) override;
  void pause() override;
  void pause_at(PausePoint point) override;
  void resume() override;
  void set(const PrintSettings& settings) override;
  [[nodiscard]] std::optional<RisesAhead> rises_ahead() const override;
  // If the plate rises, it stops for a moment in the light and goes on by the new plan; more light comes
  // before that, less light after it.
  void change(const ChangedRises& rises) override;
  void exclude(ExcludedCopy copy) override;
  void interrupt(const std::string& what) override;
  void cancel() override;
  void fail(const std::string& reason) override;

  [[nodiscard]] const PrintState& state() const override;
  [[nodiscard]] ContinuousState continuous_state() const { return MachineProcess::state(); }
  [[nodiscard]] bool pause_pending() const override;
  [[nodiscard]] const std::optional<PausePoint>& planned_pause() const override;
  [[nodiscard]] std::string_view why_fixed(std::string_view what) const override;
  [[nodiscard]] PrintSettings settings() const override;
  [[nodiscard]] std::string_view next_pause() const override;
  [[nodiscard]] bool can_resume() const override;
  [[nodiscard]] bool can_cancel() const override;
  [[nodiscard]] std::string_view why_it_ends() const override;
  [[nodiscard]] const std::string& interruption() const override;
  [[nodiscard]] bool light_may_be_on() const override { return light_asked_ || layers_.light_may_be_on(); }
  [[nodiscard]] std::int32_t layer() const override;
  [[nodiscard]] Nanometers layer_top() const override;
  [[nodiscard]] Nanometers layer_thickness() const override;
  [[nodiscard]] ShownMask shown() const override;
  [[nodiscard]] bool shows_mask() const override;
  [[nodiscard]] Duration time_left() const override;
  [[nodiscard]] std::optional<Duration> state_left() const override;

 private:
  // Events of the layered print, and its end, which the table handles.
  void light_due() override { observer_.light_due(); }
  void state_changed(const PrintState& state) override;
  void layer_done(const LayerRecord& layer) override { observer_.layer_done(layer); }
  void layer_peeled(std::int32_t layer, const PeelRecord& peel) override {
    observer_.layer_peeled(layer, peel);
  }
  void warned(const std::string& what) override { observer_.warned(what); }
  void progressed(const PrintProgress& progress) override { observer_.progressed(progress); }
  void interrupted(const std::string& what) override { observer_.interrupted(what); }
  void light_gone() override { observer_.light_gone(); }
  void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) override;

  void perform(ContinuousEffect effect) override;
  void performed(ContinuousEvent event) override;
  void effect_threw(const std::string& what) override;
  void settled() override;
  [[nodiscard]] bool is_in(EnumSet<ContinuousState> states) const {
    return states.contains(continuous_state());
  }
  [[nodiscard]] bool layering() const { return is_in({ContinuousState::Layering, ContinuousState::Idle}); }
  [[nodiscard]] bool ends() const { return over_ || canceled_; }
  void estimate(Duration duration) { estimated_end_ = clock_.now() + duration; }
  [[nodiscard]] Nanometers current_height() const;
  void move_to(Nanometers target, MillimetersPerSecond speed, std::function<void()> arrived);
  void meet_resistance();
  void lower();
  void lift();
  void print_more_layers();
  void end_rise();
  void stop_here();
  [[nodiscard]] ContinuousEvent next_due() const;
  void report_progress();
  [[nodiscard]] PrintPhase phase() const;
  void stop_for(const std::string& what, ContinuousEvent event);

  void expose();
  void show_masks();
  void rise();
  void risen(MoveResult result);
  void refreshed();
  void missed();
  [[nodiscard]] Duration longest_rise() const;
  [[nodiscard]] Nanometers rise_top() const;
  void set_white();
  void begin_slice(Nanometers bottom);
  void note_light();
  void end_light();
  void report_slice(bool complete);
  void turn_light_off();
  void is_dark();
  void finish();
  [[nodiscard]] Duration rise_left() const;
  [[nodiscard]] Duration left_after_state() const;
  [[nodiscard]] Duration parking_duration() const;

  PrintObserver& observer_;
  LayeredPrint layers_;
  std::optional<PrintPlan> plan_;  // from the end of the layered print to that of the print
  PrintOutcome layers_outcome_ = PrintOutcome::Done;
  std::string reason_;                       // reason of a failure
  std::string interruption_;                 // of the rise
  std::string layers_interruption_;          // to be passed on to the layered print
  std::optional<PausePoint> planned_pause_;  // in the rise
  bool canceled_ = false;
  bool over_ = false;          // the last rise has ended, and nothing is on top of it
  bool pause_wanted_ = false;  // when the plate is up
  RiseProgress rises_;
  std::vector<Duration> left_after_;  // by expected layer: the time for it, all later layers and parking
  std::unique_ptr<RiseFrames> frames_;
  // The light of the rise, from its command until it is confirmed off, or the print ends without that.
  struct Light {
    LightSpan span;
    TimePoint noted;     // the slices have their light up to this time
    bool wanted = true;  // light off has not been sent
  };
  std::optional<Light> light_;
  LayerRecord record_;  // the slice under way, or what comes next
};

}  // namespace contourd
