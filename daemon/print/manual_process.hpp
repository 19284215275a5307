// The printer controlled by hand: takes one operation at a time through the table of manual_states.hpp, and
// shows a picture beside it. Each operation ends by itself, dark and still, the picture after its time. Only
// while nothing prints. Event loop's thread only.
//
// It is larger than other classes: each effect of the table is a method of it, as in PrintProcess.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/mask/mask.hpp"
#include "daemon/print/manual_states.hpp"
#include "daemon/print/shown_mask.hpp"
#include "hw/machine.hpp"

namespace contourd {

class ManualProcess {
 public:
  // Machine and clock must outlive the process. `changed` is called whenever what it tells has changed, from
  // inside; it must not call back.
  ManualProcess(Machine& machine, Clock& clock, std::function<void()> changed);
  // Ends what is under way, safely.
  ~ManualProcess();
  ManualProcess(const ManualProcess&) = delete;
  ManualProcess& operator=(const ManualProcess&) = delete;

  // Operations. REQUIRES: state() is Idle; none of these looks whether the machine is ready.
  void home(MillimetersPerSecond homing_speed);
  // REQUIRES: a known height.
  void move_to(Nanometers target, MillimetersPerSecond speed);
  // A short way up, below 0 down, from wherever the plate is; that is unknown then. REQUIRES: as
  // ZAxis::nudge().
  void nudge(Nanometers way, MillimetersPerSecond speed);
  // On and warm; stays on until power_off(), a print's end, or ten minutes behind the last operation.
  void power_on();
  void power_off();
  // Powers the projector on, if need be, then light for this long.
  void light_on(Duration time);
  void ask_status();

  // On the screen until hide(), or for this long. Also while an operation is under way, but not lit.
  // REQUIRES: the mask has the display's size; light_may_be_on() is false.
  void show(Mask picture, const std::string& name, Duration time);
  void hide();

  // Ends the operation: light off, motor still, at once or when it has slowed down. The picture stays.
  void stop();
  // The same at once, with the picture; `what` says why, in one sentence.
  void fail(const std::string& what);
  // A print takes over: nothing of what was done by hand comes in its way. REQUIRES: state() is Idle.
  void give_way();

  [[nodiscard]] ManualState state() const { return state_; }
  // From light on's command until the light is confirmed off.
  [[nodiscard]] bool light_may_be_on() const { return light_asked_; }
  // How many operations have begun.
  [[nodiscard]] std::uint64_t operations() const { return operations_; }
  // Why the last operation did not come to its end; empty when it did, or nothing is known yet.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  // The picture on the screen; empty when there is none.
  [[nodiscard]] const std::string& picture() const { return picture_; }
  // The same as a mask. Valid until it is not shown any more.
  [[nodiscard]] ShownMask shown() const { return shown_; }
  // As ZAxis::homing_shift(); nothing unless homing was the last operation.
  [[nodiscard]] std::optional<Nanometers> homing_shift() const { return homing_shift_; }
  // As the projector answered; nothing unless that was the last operation.
  [[nodiscard]] const std::optional<ProjectorStatus>& projector() const { return projector_; }

 private:
  void begin(ManualEvent event);
  void handle(ManualEvent event);
  void perform(ManualEffect effect);
  template <typename Answer>
  std::function<void(Answer)> while_in_state(std::function<void(Answer)> call);
  void expect_within(Duration duration, const std::string& what);
  void start_home();
  void start_move();
  void start_nudge();
  void motion_ended(bool well, const std::string& why);
  void start_power_on();
  void start_light();
  void light_answered(ProjectorReply reply);
  void await_dark();
  void ask_projector();
  void power_off_later();

  Machine& machine_;
  Clock& clock_;
  std::function<void()> changed_;
  ManualState state_ = ManualState::Idle;
  std::uint64_t states_entered_ = 0, operations_ = 0;
  std::string problem_, picture_;
  Mask pixels_;  // of the picture
  ShownMask shown_;
  // What was asked for.
  Nanometers target_{}, way_{};
  MillimetersPerSecond speed_{0};
  Duration light_time_{};

  bool light_asked_ = false, powered_on_ = false;
  TimePoint light_end_{};
  std::optional<Nanometers> homing_shift_;
  std::optional<ProjectorStatus> projector_;
  std::unique_ptr<Timer> wait_, deadline_, picture_end_, power_end_;
};

}  // namespace contourd
