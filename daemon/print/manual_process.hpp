// Manual control of the printer: carries out one operation at a time by the table of manual_states.hpp, and
// independently shows a picture. Each operation ends by itself with the light off and the motor still; a
// picture disappears after its time. Used only while nothing prints. Event loop's thread only.
// ManualProcess has a method for each effect of the table, like LayeredPrint. It is larger than other classes
// for this reason.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/mask/mask.hpp"
#include "daemon/print/machine_process.hpp"
#include "daemon/print/manual_states.hpp"
#include "daemon/print/shown_mask.hpp"
#include "hw/machine.hpp"

namespace contourd {

class ManualProcess final : private MachineProcess<ManualTransition> {
 public:
  // Machine and clock must outlive the process. `changed` is called from within the process after every
  // change of what its functions return; it must not call back into the process.
  ManualProcess(Machine& machine, Clock& clock, std::function<void()> changed);
  // Makes the machine safe if an operation is under way or a picture is shown.
  ~ManualProcess() override;

  // Begins homing. Like the other operations below it returns at once and does not check that the machine is
  // ready. REQUIRES: state() is Idle, as for every operation.
  void home(MillimetersPerSecond homing_speed);
  // Begins a move to a height. REQUIRES: the plate's height is known.
  void move_to(Nanometers target, MillimetersPerSecond speed);
  // Begins a short move up or (below 0) down from wherever the plate is; its position is unknown afterwards.
  // REQUIRES: as ZAxis::nudge().
  void nudge(Nanometers distance, MillimetersPerSecond speed);
  // Begins a move up by this distance from wherever the plate is, which ends early at a limit switch at the
  // top; the position is unknown afterwards. REQUIRES: as ZAxis::raise().
  void raise(Nanometers distance, MillimetersPerSecond speed);
  // Powers the projector on; the operation ends when it is warm. The projector stays on until power_off(),
  // the end of a print, or ten minutes after the last operation.
  void power_on();
  void power_off();
  // Powers the projector on if necessary, then turns the light on for this long.
  void light_on(Duration time);
  void ask_status();

  // Shows a picture until hide(), or for this long. Allowed during an operation, but not with light.
  // REQUIRES: the mask has the display's size; light_may_be_on() is false.
  void show(Mask picture, const std::string& name, Duration time);
  void hide();

  // Ends the operation: light off, and the motor still, at once or after it has slowed down. The picture
  // stays.
  void stop();
  // Ends the operation at once and hides the picture; `what` says why, in one sentence.
  void fail(const std::string& what) override;
  // Hides the picture and leaves the projector's power to the print that begins now. REQUIRES: state() is
  // Idle.
  void give_way();

  using MachineProcess::state;
  // True if an operation is under way or a picture is shown.
  [[nodiscard]] bool in_use() const { return state() != ManualState::Idle || !picture().empty(); }
  // True from the light-on command until the light is confirmed off.
  [[nodiscard]] bool light_may_be_on() const { return light_asked_; }
  // Returns the number of operations that have begun.
  [[nodiscard]] std::uint64_t operations() const { return operations_; }
  // Returns why the last operation was not completed; empty if it was, or if nothing is known yet.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  // Returns the name of the picture on the screen; empty if there is none.
  [[nodiscard]] const std::string& picture() const { return picture_; }
  // Returns the picture on the screen as a mask. Valid as long as it is shown.
  [[nodiscard]] ShownMask shown() const { return shown_; }
  // Returns ZAxis::homing_shift() if homing was the last operation, else nullopt.
  [[nodiscard]] std::optional<Nanometers> homing_shift() const { return homing_shift_; }
  // Returns the projector's answer if ask_status() was the last operation, else nullopt.
  [[nodiscard]] const std::optional<ProjectorStatus>& projector() const { return projector_; }

 private:
  void begin(ManualEvent event);
  void perform(ManualEffect effect) override;
  void settled() override;
  void start_home();
  void start_move();
  void start_nudge();
  void motion_ended(bool reached, const std::string& why);
  void start_power_on();
  void start_light();
  void await_dark();
  void ask_projector();
  void power_off_later();

  std::function<void()> changed_;
  std::uint64_t operations_ = 0;
  std::string problem_, picture_;
  Mask pixels_;  // the picture's mask
  ShownMask shown_;
  // Parameters of the operation under way.
  Nanometers target_{}, nudge_distance_{};
  bool raises_ = false;  // the nudge is a raise()
  MillimetersPerSecond speed_{0};
  Duration light_time_{};

  bool powered_on_ = false;
  std::optional<Nanometers> homing_shift_;
  std::optional<ProjectorStatus> projector_;
  std::unique_ptr<Timer> picture_end_, power_end_;
};

}  // namespace contourd
