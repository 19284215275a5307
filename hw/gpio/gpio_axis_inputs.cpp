// What an axis makes of its inputs' changes.
#include <utility>

#include "hw/gpio/gpio_axis.hpp"

namespace contourd {
namespace {

std::string words_of(const GpioInputConfig& input) {
  return "line " + input.line.line + " of " + input.line.chip;
}

}  // namespace

void GpioAxis::inputs_changed() {
  inputs_.changes().clear();
  if (inputs_.lost() && !loss_told_) blocked();
  while (const auto change = inputs_.take_change())
    take_change(*change);
  if (ready_ && !engine_.moving()) go_on();
}

// What waits for the motor to rest and the emergency stop to be settled, which looks again itself.
void GpioAxis::go_on() {
  if (const auto ready = std::exchange(ready_, nullptr)) ready();
}

void GpioAxis::take_change(const InputChange& change) {
  switch (change.which) {
    case AxisInput::EmergencyStop:
      return take_emergency_stop(change);
    case AxisInput::Lid:
      return take_lid(change);
    case AxisInput::SecondSwitch:
      if (!change.halted) return;
      trip_ = Trip{HomingResult::WrongSwitch, "the switch at the end that is not homed to (" +
                                                  words_of(*config_.second_switch) + ") closed" + where()};
      return;
    case AxisInput::LimitSwitch:
      return take_limit_switch(change);
  }
}

void GpioAxis::take_emergency_stop(const InputChange& change) {
  const std::string line = " (" + words_of(*config_.emergency_stop) + ")";
  if (change.to == SafetyState::Unsafe) {
    if (!emergency_told_) blocked();
    return;
  }
  if (change.to == SafetyState::Doubtful) {
    // The fault that it has become meanwhile says all.
    if (engine_.barred()) return;
    if (running_) engine_.stop();
    return disturb(Disturbance::Kind::Interruption,
                   change.readable ? "the emergency stop was touched, or its line disturbed" + line
                                   : "the emergency stop cannot be read" + line);
  }
  inputs_.let_go();
  if (inputs_.lost()) return;
  const bool lasted = change.from == SafetyState::Unsafe;
  emergency_told_ = false;
  disturb(Disturbance::Kind::Recovery,
          (lasted ? "the emergency stop was let go" : "the emergency stop is not pressed") + line, lasted);
}

void GpioAxis::take_lid(const InputChange& change) {
  const std::string line = " (" + words_of(*config_.lid) + ")";
  if (change.to == SafetyState::Unsafe) return;  // told by its first edge
  if (change.to == SafetyState::Doubtful) {
    return disturb(
        Disturbance::Kind::Interruption,
        (change.readable ? "the lid was opened" : "the lid cannot be read, which counts as open") + line);
  }
  inputs_.let_go();
  disturb(Disturbance::Kind::Recovery, "the lid was closed" + line);
}

void GpioAxis::take_limit_switch(const InputChange& change) {
  if (!change.halted) return;
  if (!seek_) {
    trip_ = Trip{HomingResult::Fault, "the limit switch (" + words_of(config_.limit_switch) + ") is closed" +
                                          where() + ", where it should be open"};
    return;
  }
  seek_->contact = change;
  if (!engine_.moving() && !running_) seek_on();
}

// Barred: by the emergency stop, or because the inputs are lost.
void GpioAxis::blocked() {
  if (inputs_.lost()) {
    loss_told_ = true;
    return fail({HomingResult::Fault, loss()});
  }
  emergency_told_ = true;
  const bool readable = inputs_.readable(AxisInput::EmergencyStop);
  fail({HomingResult::Fault,
        (readable ? "the emergency stop is pressed (" : "the emergency stop cannot be read (") +
            words_of(*config_.emergency_stop) + ")",
        true});
}

std::string GpioAxis::loss() const {
  if (!inputs_.readable(AxisInput::LimitSwitch))
    return "the limit switch cannot be read (" + words_of(config_.limit_switch) + ")";
  if (!inputs_.readable(AxisInput::SecondSwitch))
    return "the second switch cannot be read (" + words_of(*config_.second_switch) + ")";
  return "the axis' inputs on " + config_.limit_switch.line.chip +
         " can no longer be read: their chip has gone, or they change without end";
}

std::vector<std::string> GpioAxis::why_not_ready() const {
  std::vector<std::string> sentences;
  const auto add = [&](AxisInput which, const std::string& name, const char* unsafe) {
    if (inputs_.active(which))
      sentences.push_back(name + (inputs_.readable(which) ? unsafe : " cannot be read"));
  };
  add(AxisInput::EmergencyStop, "the emergency stop", " is pressed");
  add(AxisInput::Lid, "the lid", " is open");
  return sentences;
}

}  // namespace contourd
