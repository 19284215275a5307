#include "hw/gpio/homing_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = HomingState;
using E = HomingEvent;
using F = HomingEffect;

template <typename... Effects>
constexpr HomingTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= HomingTransition::kMaxEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

constexpr HomingTransition stop(S from, S to) {
  return row(from, E::StopWanted, to, F::StopMotor);
}

constexpr HomingTransition failed(S from) {
  return row(from, E::Failed, S::Idle, F::TellFailed);
}

constexpr HomingTransition aborted(S from) {
  return row(from, E::Aborted, S::Idle, F::DropAnswer);
}

constexpr auto kTable = std::to_array<HomingTransition>({
    row(S::Idle, E::HomeWanted, S::GettingReady, F::ForgetPosition, F::GetReady),
    row(S::GettingReady, E::SwitchOpen, S::FastPass, F::SeekFast),
    row(S::GettingReady, E::SwitchClosed, S::BackingOff, F::BackOff),

    row(S::FastPass, E::Contact, S::BackingOff, F::BackOff),
    row(S::FastPass, E::Spike, S::FastPass, F::SeekOn),
    row(S::FastPass, E::WayOver, S::FastPassOver, F::AwaitContact),
    row(S::FastPassOver, E::Contact, S::BackingOff, F::BackOff),
    row(S::FastPassOver, E::Spike, S::FastPass, F::SeekOn),
    row(S::FastPassOver, E::WaitOver, S::Idle, F::TellNoTrigger),

    row(S::BackingOff, E::WayOver, S::BackedOff, F::LookAtSwitch),
    row(S::BackedOff, E::SwitchOpen, S::SlowPass, F::SeekSlow),
    row(S::BackedOff, E::SwitchClosed, S::Idle, F::TellStillClosed),

    row(S::SlowPass, E::Contact, S::AtSwitch, F::TakePosition, F::AwaitRest),
    row(S::SlowPass, E::Spike, S::SlowPass, F::SeekOn),
    row(S::SlowPass, E::WayOver, S::SlowPassOver, F::AwaitContact),
    row(S::SlowPassOver, E::Contact, S::AtSwitch, F::TakePosition, F::AwaitRest),
    row(S::SlowPassOver, E::Spike, S::SlowPass, F::SeekOn),
    row(S::SlowPassOver, E::WaitOver, S::Idle, F::TellNoTrigger),

    row(S::AtSwitch, E::WaitOver, S::Approaching, F::KnowPosition, F::Approach),
    row(S::Approaching, E::Arrived, S::Idle, F::TellHomed),

    stop(S::GettingReady, S::Stopping),
    stop(S::FastPass, S::PassStopping),
    stop(S::FastPassOver, S::PassStopping),
    stop(S::BackingOff, S::Stopping),
    stop(S::BackedOff, S::Stopping),
    stop(S::SlowPass, S::PassStopping),
    stop(S::SlowPassOver, S::PassStopping),
    stop(S::AtSwitch, S::Stopping),
    stop(S::Approaching, S::Stopping),
    stop(S::PassStopping, S::PassStopping),
    stop(S::Stopping, S::Stopping),
    row(S::PassStopping, E::Contact, S::Idle, F::TellStopped),
    row(S::PassStopping, E::Spike, S::Idle, F::TellStopped),
    row(S::PassStopping, E::Stopped, S::Idle, F::TellStopped),
    row(S::Stopping, E::Stopped, S::Idle, F::TellStopped),

    failed(S::GettingReady),
    failed(S::FastPass),
    failed(S::FastPassOver),
    failed(S::BackingOff),
    failed(S::BackedOff),
    failed(S::SlowPass),
    failed(S::SlowPassOver),
    failed(S::AtSwitch),
    failed(S::Approaching),
    failed(S::PassStopping),
    failed(S::Stopping),

    aborted(S::GettingReady),
    aborted(S::FastPass),
    aborted(S::FastPassOver),
    aborted(S::BackingOff),
    aborted(S::BackedOff),
    aborted(S::SlowPass),
    aborted(S::SlowPassOver),
    aborted(S::AtSwitch),
    aborted(S::Approaching),
    aborted(S::PassStopping),
    aborted(S::Stopping),
});

}  // namespace

std::span<const HomingTransition> homing_transitions() {
  return kTable;
}

bool is_in_pass(HomingState state) {
  return state == S::FastPass || state == S::FastPassOver || state == S::SlowPass ||
         state == S::SlowPassOver || state == S::PassStopping;
}

std::string_view name_of(HomingState state) {
  switch (state) {
    case S::Idle:
      return "idle";
    case S::GettingReady:
      return "getting ready";
    case S::FastPass:
      return "fast pass";
    case S::FastPassOver:
      return "fast pass over";
    case S::BackingOff:
      return "backing off";
    case S::BackedOff:
      return "backed off";
    case S::SlowPass:
      return "slow pass";
    case S::SlowPassOver:
      return "slow pass over";
    case S::AtSwitch:
      return "at switch";
    case S::Approaching:
      return "approaching";
    case S::PassStopping:
      return "pass stopping";
    case S::Stopping:
      return "stopping";
  }
  return "?";
}

std::string_view name_of(HomingEvent event) {
  switch (event) {
    case E::HomeWanted:
      return "home wanted";
    case E::SwitchOpen:
      return "switch open";
    case E::SwitchClosed:
      return "switch closed";
    case E::Contact:
      return "contact";
    case E::Spike:
      return "spike";
    case E::WayOver:
      return "way over";
    case E::WaitOver:
      return "wait over";
    case E::Arrived:
      return "arrived";
    case E::StopWanted:
      return "stop wanted";
    case E::Stopped:
      return "stopped";
    case E::Failed:
      return "failed";
    case E::Aborted:
      return "aborted";
  }
  return "?";
}

std::string_view name_of(HomingEffect effect) {
  switch (effect) {
    case F::ForgetPosition:
      return "forget position";
    case F::GetReady:
      return "get ready";
    case F::SeekFast:
      return "seek fast";
    case F::SeekSlow:
      return "seek slow";
    case F::SeekOn:
      return "seek on";
    case F::BackOff:
      return "back off";
    case F::AwaitContact:
      return "await contact";
    case F::LookAtSwitch:
      return "look at switch";
    case F::TakePosition:
      return "take position";
    case F::AwaitRest:
      return "await rest";
    case F::KnowPosition:
      return "know position";
    case F::Approach:
      return "approach";
    case F::StopMotor:
      return "stop motor";
    case F::TellHomed:
      return "tell homed";
    case F::TellNoTrigger:
      return "tell no trigger";
    case F::TellStillClosed:
      return "tell still closed";
    case F::TellStopped:
      return "tell stopped";
    case F::TellFailed:
      return "tell failed";
    case F::DropAnswer:
      return "drop answer";
  }
  return "?";
}

}  // namespace contourd
