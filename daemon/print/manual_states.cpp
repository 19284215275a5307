#include "daemon/print/manual_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ManualState;
using E = ManualEvent;
using F = ManualEffect;

template <typename... Effects>
constexpr ManualTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= ManualTransition::kMaxEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

// Turns the light off before any effect that can fail, then blanks the screen and stops the motor.
constexpr ManualTransition failure(S from) {
  return row(from, E::Failed, S::Extinguishing, F::LightOff, F::BlackNow, F::AbortAxis, F::AwaitDark);
}

constexpr ManualTransition stop_motion(S from) {
  return row(from, E::Stop, S::Braking, F::LightOff, F::StopAxis);
}

constexpr ManualTransition stop_light(S from) {
  return row(from, E::Stop, S::Extinguishing, F::LightOff, F::BlackNow, F::AwaitDark);
}

constexpr auto kTable = std::to_array<ManualTransition>({
    row(S::Idle, E::Home, S::Homing, F::Home),
    row(S::Idle, E::Move, S::Moving, F::Move),
    row(S::Idle, E::Nudge, S::Moving, F::Nudge),
    row(S::Idle, E::PowerOn, S::PoweringOn, F::LightOff, F::PowerOn),
    row(S::Idle, E::PowerOff, S::Extinguishing, F::LightOff, F::PowerOff, F::AwaitDark),
    row(S::Idle, E::LightOn, S::WarmingUp, F::LightOff, F::PowerOn),
    row(S::Idle, E::AskStatus, S::Asking, F::AskStatus),

    row(S::Homing, E::Homed, S::Idle),
    row(S::Moving, E::MoveEnded, S::Idle),
    row(S::Braking, E::MoveEnded, S::Idle),
    row(S::PoweringOn, E::ProjectorReady, S::Idle),
    row(S::WarmingUp, E::ProjectorReady, S::Igniting, F::LightOn),
    row(S::Igniting, E::LightOnSent, S::Lit, F::TimeLight),
    row(S::Lit, E::TimeOver, S::Extinguishing, F::LightOff, F::AwaitDark),
    row(S::Extinguishing, E::LightIsOff, S::Idle),
    row(S::Extinguishing, E::GaveUp, S::Idle, F::LightOff, F::TellLightMayBeOn),
    row(S::Asking, E::StatusTold, S::Idle),

    stop_motion(S::Homing),
    stop_motion(S::Moving),
    stop_light(S::PoweringOn),
    stop_light(S::WarmingUp),
    stop_light(S::Igniting),
    stop_light(S::Lit),
    stop_light(S::Asking),

    failure(S::Homing),
    failure(S::Moving),
    failure(S::Braking),
    failure(S::PoweringOn),
    failure(S::WarmingUp),
    failure(S::Igniting),
    failure(S::Lit),
    failure(S::Asking),
    // AwaitDark is in effect already.
    row(S::Extinguishing, E::Failed, S::Extinguishing, F::LightOff, F::BlackNow, F::AbortAxis),
});

}  // namespace

std::span<const ManualTransition> manual_transitions() {
  return kTable;
}

std::string_view name_of(ManualState state) {
  switch (state) {
    case S::Idle:
      return "idle";
    case S::Homing:
      return "homing";
    case S::Moving:
      return "moving";
    case S::Braking:
      return "braking";
    case S::PoweringOn:
      return "powering on";
    case S::WarmingUp:
      return "warming up";
    case S::Igniting:
      return "igniting";
    case S::Lit:
      return "lit";
    case S::Extinguishing:
      return "extinguishing";
    case S::Asking:
      return "asking";
  }
  return "?";
}

std::string_view name_of(ManualEvent event) {
  switch (event) {
    case E::Home:
      return "home";
    case E::Move:
      return "move";
    case E::Nudge:
      return "nudge";
    case E::PowerOn:
      return "power on";
    case E::PowerOff:
      return "power off";
    case E::LightOn:
      return "light on";
    case E::AskStatus:
      return "ask status";
    case E::Homed:
      return "homed";
    case E::MoveEnded:
      return "move ended";
    case E::ProjectorReady:
      return "projector ready";
    case E::LightOnSent:
      return "light on sent";
    case E::TimeOver:
      return "time over";
    case E::LightIsOff:
      return "light is off";
    case E::StatusTold:
      return "status told";
    case E::Stop:
      return "stop";
    case E::Failed:
      return "failed";
    case E::GaveUp:
      return "gave up";
  }
  return "?";
}

std::string_view name_of(ManualEffect effect) {
  switch (effect) {
    case F::LightOff:
      return "light off";
    case F::BlackNow:
      return "black now";
    case F::AbortAxis:
      return "abort axis";
    case F::StopAxis:
      return "stop axis";
    case F::Home:
      return "home";
    case F::Move:
      return "move";
    case F::Nudge:
      return "nudge";
    case F::PowerOn:
      return "power on";
    case F::PowerOff:
      return "power off";
    case F::LightOn:
      return "light on";
    case F::TimeLight:
      return "time light";
    case F::AwaitDark:
      return "await dark";
    case F::AskStatus:
      return "ask status";
    case F::TellLightMayBeOn:
      return "tell that the light may be on";
  }
  return "?";
}

}  // namespace contourd
