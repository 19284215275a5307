#include "hw/gpio/axis_interlocks.hpp"

#include <utility>

#include "hw/gpio/axis_fault.hpp"

namespace contourd {
namespace {

using Kind = MachineEvent::Kind;

}  // namespace

AxisInterlocks::AxisInterlocks(const GpioAxisConfig& config, const StepEngine& engine, AxisInputs& inputs,
                               Wiring wiring)
    : config_(config), engine_(engine), inputs_(inputs), wiring_(std::move(wiring)) {}

void AxisInterlocks::take_changes() {
  inputs_.changes().clear();
  if (inputs_.lost() && !loss_reported_) blocked();
  while (const auto change = inputs_.take_change())
    take_change(*change);
}

void AxisInterlocks::take_change(const InputChange& change) {
  switch (change.which) {
    case AxisInput::EmergencyStop:
      return take_emergency_stop(change);
    case AxisInput::Lid:
      return take_interlock(
          change, *config_.lid,
          {"the lid was opened", "the lid cannot be read, which counts as open", "the lid was closed"});
    case AxisInput::PowerFail:
      return take_interlock(
          change, *config_.power_fail,
          {"the power is failing", "the power-fail signal cannot be read, which counts as a failure",
           "the power is back"});
    case AxisInput::SecondSwitch:
      if (!change.halted) return;
      return wiring_.halted_for(
          {HomingResult::WrongSwitch,
           "the second switch (" + describe(config_.second_switch->line) + ") closed" + wiring_.where()});
    case AxisInput::LimitSwitch:
      return take_limit_switch(change);
    case AxisInput::Force:
      return wiring_.force_changed(change);
  }
}

void AxisInterlocks::take_emergency_stop(const InputChange& change) {
  const std::string line = " (" + describe(config_.emergency_stop->line) + ")";
  if (change.to == SafetyState::Unsafe) {
    if (!emergency_reported_) blocked();
    return;
  }
  if (change.to == SafetyState::Debouncing) {
    // The signal has lasted meanwhile, and the fault that follows says so.
    if (engine_.inhibited()) return;
    wiring_.slow_down();
    return wiring_.report(
        {Kind::Interlock, change.readable ? "the emergency stop was touched, or its line disturbed" + line
                                          : "the emergency stop cannot be read" + line});
  }
  inputs_.let_go();
  if (inputs_.lost()) return;
  const bool lasted = change.from == SafetyState::Unsafe;
  emergency_reported_ = false;
  wiring_.report({Kind::Recovery,
                  (lasted ? "the emergency stop was released" : "the emergency stop is not pressed") + line,
                  lasted});
}

void AxisInterlocks::take_interlock(const InputChange& change, const GpioInputConfig& input,
                                    const InterlockTexts& texts) {
  const std::string line = " (" + describe(input.line) + ")";
  if (change.to == SafetyState::Unsafe) return;  // was reported at the first edge
  if (change.to == SafetyState::Debouncing)
    return wiring_.report({Kind::Interlock, (change.readable ? texts.unsafe : texts.unreadable) + line});
  inputs_.let_go();
  wiring_.report({Kind::Recovery, texts.safe + line});
}

void AxisInterlocks::take_limit_switch(const InputChange& change) {
  if (!change.halted || wiring_.takes_contact(change)) return;
  wiring_.halted_for({.what = "the limit switch (" + describe(config_.limit_switch.line) + ") is closed" +
                              wiring_.where() + ", where it should be open"});
}

void AxisInterlocks::blocked() {
  if (inputs_.lost()) {
    loss_reported_ = true;
    return wiring_.fail({.what = loss()});
  }
  emergency_reported_ = true;
  const bool readable = inputs_.readable(AxisInput::EmergencyStop);
  wiring_.fail(
      {.what = (readable ? "the emergency stop is pressed (" : "the emergency stop cannot be read (") +
               describe(config_.emergency_stop->line) + ")",
       .needs_user = true});
}

std::string AxisInterlocks::loss() const {
  if (!inputs_.readable(AxisInput::LimitSwitch))
    return "the limit switch cannot be read (" + describe(config_.limit_switch.line) + ")";
  if (!inputs_.readable(AxisInput::SecondSwitch))
    return "the second switch cannot be read (" + describe(config_.second_switch->line) + ")";
  if (!inputs_.readable(AxisInput::Force))
    return "the force line cannot be read (" + describe(config_.force->input.line) + ")";
  return "the axis' inputs on " + config_.limit_switch.line.chip +
         " can no longer be read: their chip is gone, or they change faster than they can be handled";
}

std::vector<std::string> AxisInterlocks::why_not_ready() const {
  std::vector<std::string> sentences;
  const auto add = [&](AxisInput which, const std::string& name, const char* unsafe) {
    if (inputs_.active(which))
      sentences.push_back(name + (inputs_.readable(which) ? unsafe : " cannot be read"));
  };
  add(AxisInput::EmergencyStop, "the emergency stop", " is pressed");
  add(AxisInput::Lid, "the lid", " is open");
  if (inputs_.active(AxisInput::PowerFail))
    sentences.emplace_back(inputs_.readable(AxisInput::PowerFail) ? "the power is failing"
                                                                  : "the power-fail signal cannot be read");
  return sentences;
}

}  // namespace contourd
