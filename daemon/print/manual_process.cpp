#include "daemon/print/manual_process.hpp"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/print/motion_timeout.hpp"
#include "hw/homing_distances.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Deadlines for devices that do not answer, the same as in a print.
constexpr Duration kManualProjectorDeadline = 30s;
constexpr Duration kManualWarmUpDeadline = 1h;
constexpr Duration kDarkDeadline = 5s;
// A projector that was powered on manually and then forgotten is powered off after this time.
constexpr Duration kPoweredOnUnused = 10min;

}  // namespace

ManualProcess::ManualProcess(Machine& machine, Clock& clock, std::function<void()> changed)
    : machine_(machine), clock_(clock), changed_(std::move(changed)) {}

ManualProcess::~ManualProcess() {
  if (state_ == ManualState::Idle && picture_.empty()) return;
  make_safe(machine_);
  machine_.projector().when_dark({});  // drops the callback, which refers to this object
}

// --- operations

void ManualProcess::home(MillimetersPerSecond homing_speed) {
  expects(state_ == ManualState::Idle, "no operation is under way");
  speed_ = homing_speed;
  begin(ManualEvent::Home);
}

void ManualProcess::move_to(Nanometers target, MillimetersPerSecond speed) {
  expects(machine_.z_axis().height().has_value(), "the plate's height is known");
  target_ = target;
  speed_ = speed;
  begin(ManualEvent::Move);
}

void ManualProcess::nudge(Nanometers distance, MillimetersPerSecond speed) {
  expects(distance >= -kLongestNudge && distance <= kLongestNudge, "a nudge is short");
  nudge_distance_ = distance;
  speed_ = speed;
  begin(ManualEvent::Nudge);
}

void ManualProcess::power_on() {
  begin(ManualEvent::PowerOn);
}

void ManualProcess::power_off() {
  begin(ManualEvent::PowerOff);
}

void ManualProcess::light_on(Duration time) {
  light_time_ = time;
  begin(ManualEvent::LightOn);
}

void ManualProcess::ask_status() {
  begin(ManualEvent::AskStatus);
}

void ManualProcess::begin(ManualEvent event) {
  expects(state_ == ManualState::Idle, "no operation is under way");
  ++operations_;
  problem_.clear();
  homing_shift_.reset();
  projector_.reset();
  handle(event);
}

void ManualProcess::stop() {
  if (manual_table().find(state_, ManualEvent::Stop) == nullptr) return;
  problem_ = "stopped";
  handle(ManualEvent::Stop);
}

void ManualProcess::fail(const std::string& what) {
  if (problem_.empty() && state_ != ManualState::Idle) problem_ = what;
  hide();
  handle(ManualEvent::Failed);
}

void ManualProcess::give_way() {
  expects(state_ == ManualState::Idle, "no operation is under way");
  hide();
  powered_on_ = false;  // the print powers the projector off
  power_end_.reset();
}

// --- the picture

void ManualProcess::show(Mask picture, const std::string& name, Duration time) {
  expects(!light_may_be_on(), "nothing shines while the picture changes");
  (void)machine_.begin_job("test pattern " +
                           name);  // a machine that saves its masks saves this one separately
  picture_ = name;
  pixels_ = std::move(picture);
  shown_ = {&pixels_, shown_.number + 1, picture_};
  picture_end_ = clock_.call_after(time, [this] { hide(); });
  machine_.display().show(pixels_, [this](std::optional<TimePoint> at) {
    if (!at) hide();
  });
  changed_();
}

void ManualProcess::hide() {
  if (picture_.empty()) return;
  machine_.display().black_now();
  picture_.clear();
  shown_.mask = nullptr;
  pixels_ = Mask();
  picture_end_.reset();
  changed_();
}

// --- the table

void ManualProcess::handle(ManualEvent event) {
  const ManualTransition* const transition = manual_table().find(state_, event);
  if (transition == nullptr) return;
  const ManualState next = transition->next(state_);
  if (next != state_) {
    ++states_entered_;
    wait_.reset();
    deadline_.reset();
    state_ = next;
  }
  try {
    for (const ManualEffect effect : transition->done())
      perform(effect);
  } catch (const std::exception& error) {
    machine_.projector().light_off();
    return fail(error.what());
  }
  if (state_ == ManualState::Idle) {
    light_asked_ = false;
    power_off_later();
  }
  changed_();
}

void ManualProcess::perform(ManualEffect effect) {
  switch (effect) {
    case ManualEffect::LightOff:
      return machine_.projector().light_off();
    case ManualEffect::BlackNow:
      machine_.display().black_now();
      return hide();
    case ManualEffect::AbortAxis:
      return machine_.z_axis().abort();
    case ManualEffect::StopAxis:
      expect_within(kStopTimeout, "the axis to stop");
      return machine_.z_axis().stop();
    case ManualEffect::Home:
      return start_home();
    case ManualEffect::Move:
      return start_move();
    case ManualEffect::Nudge:
      return start_nudge();
    case ManualEffect::PowerOn:
      return start_power_on();
    case ManualEffect::PowerOff:
      powered_on_ = false;
      power_end_.reset();
      return machine_.projector().power_off();
    case ManualEffect::LightOn:
      return start_light();
    case ManualEffect::TimeLight:
      wait_ = clock_.call_at(light_end_, [this] { handle(ManualEvent::TimeOver); });
      return;
    case ManualEffect::AwaitDark:
      return await_dark();
    case ManualEffect::AskStatus:
      return ask_projector();
    case ManualEffect::TellLightMayBeOn:
      problem_ += (problem_.empty() ? "" : "; ") + std::string("the light may be on: ") +
                  machine_.projector().light_off_unconfirmed();
      return;
  }
}

// Returns a callback that does nothing once the state has changed, so that late answers are ignored.
template <typename Answer>
std::function<void(Answer)> ManualProcess::while_in_state(std::function<void(Answer)> call) {
  return [this, entered = states_entered_, call = std::move(call)](Answer answer) {
    if (entered == states_entered_) call(answer);
  };
}

void ManualProcess::expect_within(Duration duration, const std::string& what) {
  deadline_ = clock_.call_after(duration, [this, duration, what] {
    fail(fmt::format("timed out after {:.0f} s waiting for {}",
                     std::chrono::duration<double>(duration).count(), what));
  });
}

// --- motion

void ManualProcess::start_home() {
  expect_within(homing_timeout(machine_.z_axis(), speed_), "the axis to home");
  machine_.z_axis().home([this](HomingResult result) {
    motion_ended(result == HomingResult::Homed, fmt::format("homing failed: {}", describe(result)));
  });
}

void ManualProcess::start_move() {
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) throw std::runtime_error("the plate's position is unknown");
  expect_within(move_timeout(machine_.z_axis(), target_ - *height, speed_), "the move to end");
  machine_.z_axis().move_to(target_, speed_, [this](MoveResult result) {
    motion_ended(result == MoveResult::Reached,
                 fmt::format("the plate did not arrive: {}", describe(result)));
  });
}

void ManualProcess::start_nudge() {
  expect_within(move_timeout(machine_.z_axis(), nudge_distance_, speed_), "the move to end");
  machine_.z_axis().nudge(nudge_distance_, speed_, [this](MoveResult result) {
    motion_ended(result == MoveResult::Reached,
                 fmt::format("the plate did not go all the way: {}", describe(result)));
  });
}

// Handles the end of a motion. A motion that was stopped ends in Braking.
void ManualProcess::motion_ended(bool reached, const std::string& why) {
  if (state_ == ManualState::Braking) return handle(ManualEvent::MoveEnded);
  if (!reached) return fail(why);
  if (state_ != ManualState::Homing) return handle(ManualEvent::MoveEnded);
  homing_shift_ = machine_.z_axis().homing_shift();
  handle(ManualEvent::Homed);
}

// --- light

void ManualProcess::start_power_on() {
  power_end_.reset();
  powered_on_ = true;
  expect_within(kManualWarmUpDeadline, "the projector's lamp to warm up");
  machine_.projector().power_on(while_in_state<ProjectorReply>([this](ProjectorReply reply) {
    if (reply == ProjectorReply::Ok) return handle(ManualEvent::ProjectorReady);
    fail(fmt::format("power on: {}", machine_.projector().last_problem()));
  }));
}

void ManualProcess::start_light() {
  expect_within(kManualProjectorDeadline, "the light-on command to be sent to the projector");
  light_asked_ = true;
  const auto sent = while_in_state<TimePoint>([this](TimePoint earliest) {
    light_end_ = earliest + light_time_;
    handle(ManualEvent::LightOnSent);
  });
  // The reply may arrive after the light-on command was sent, in state Lit.
  const auto answered = [this, operation = operations_](ProjectorReply reply) {
    if (operation == operations_) light_answered(reply);
  };
  machine_.projector().light_on(light_time_, {.sent = sent, .done = answered});
}

void ManualProcess::light_answered(ProjectorReply reply) {
  if (reply == ProjectorReply::Ok) return;
  fail(fmt::format("light on: {}", machine_.projector().last_problem()));
}

void ManualProcess::await_dark() {
  deadline_ = clock_.call_after(kDarkDeadline, [this] { handle(ManualEvent::GaveUp); });
  machine_.projector().when_dark([this] { handle(ManualEvent::LightIsOff); });
}

void ManualProcess::ask_projector() {
  expect_within(kManualProjectorDeadline, "the projector's answer");
  machine_.projector().ask_status([this, operation = operations_](const ProjectorStatus& status) {
    if (operation != operations_ || state_ != ManualState::Asking) return;
    projector_ = status;
    if (status.reply != ProjectorReply::Ok) problem_ = status.problem;
    handle(ManualEvent::StatusTold);
  });
}

void ManualProcess::power_off_later() {
  if (!powered_on_) return;
  power_end_ = clock_.call_after(kPoweredOnUnused, [this] {
    if (!picture_.empty()) return power_off_later();  // a picture is shown, so the projector is in use
    powered_on_ = false;
    machine_.projector().power_off();
  });
}

}  // namespace contourd
