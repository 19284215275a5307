#include "daemon/print/manual_process.hpp"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/z_axis.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// A projector that was powered on manually and then forgotten is powered off after this time.
constexpr Duration kPoweredOnUnused = 10min;

}  // namespace

ManualProcess::ManualProcess(Machine& machine, Clock& clock, std::function<void()> changed)
    : MachineProcess(machine, clock, manual_table()), changed_(std::move(changed)) {}

ManualProcess::~ManualProcess() {
  if (state() != ManualState::Idle || !picture_.empty()) make_machine_safe();
}

// --- operations

void ManualProcess::home(MillimetersPerSecond homing_speed) {
  expects(state() == ManualState::Idle, "no operation is under way");
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
  raises_ = false;
  speed_ = speed;
  begin(ManualEvent::Nudge);
}

void ManualProcess::raise(Nanometers distance, MillimetersPerSecond speed) {
  expects(distance >= Nanometers{} && distance <= machine_.z_axis().travel(),
          "the plate rises within its travel");
  nudge_distance_ = distance;
  raises_ = true;
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
  expects(state() == ManualState::Idle, "no operation is under way");
  ++operations_;
  problem_.clear();
  homing_shift_.reset();
  projector_.reset();
  handle(event);
}

void ManualProcess::stop() {
  if (!answers(ManualEvent::Stop)) return;
  problem_ = "stopped";
  handle(ManualEvent::Stop);
}

void ManualProcess::fail(const std::string& what) {
  if (problem_.empty() && state() != ManualState::Idle) problem_ = what;
  hide();
  handle(ManualEvent::Failed);
}

void ManualProcess::give_way() {
  expects(state() == ManualState::Idle, "no operation is under way");
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

void ManualProcess::settled() {
  if (state() == ManualState::Idle) {
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
      return stop_axis();
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
      return handle_at(light_end_, ManualEvent::TimeOver);
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

// --- motion

void ManualProcess::start_home() {
  expect_homing(speed_);
  machine_.z_axis().home([this](HomingResult result) {
    motion_ended(result == HomingResult::Homed, fmt::format("homing failed: {}", name_of(result)));
  });
}

void ManualProcess::start_move() {
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) throw std::runtime_error("the plate's position is unknown");
  expect_move(target_ - *height, speed_, "the move to end");
  machine_.z_axis().expect_contact_at({});
  machine_.z_axis().move_to(target_, speed_, [this](MoveResult result) {
    motion_ended(result == MoveResult::Reached, fmt::format("the plate did not arrive: {}", name_of(result)));
  });
}

void ManualProcess::start_nudge() {
  expect_move(nudge_distance_, speed_, "the move to end");
  const auto ended = [this](MoveResult result) {
    motion_ended(result == MoveResult::Reached || (raises_ && result == MoveResult::AtSwitch),
                 fmt::format("the plate did not go all the way: {}", name_of(result)));
  };
  ZAxis& axis = machine_.z_axis();
  raises_ ? axis.raise(nudge_distance_, speed_, ended) : axis.nudge(nudge_distance_, speed_, ended);
}

// Handles the end of a motion. A motion that was stopped ends in Braking.
void ManualProcess::motion_ended(bool reached, const std::string& why) {
  if (state() == ManualState::Braking) return handle(ManualEvent::MoveEnded);
  if (!reached) return fail(why);
  if (state() != ManualState::Homing) return handle(ManualEvent::MoveEnded);
  homing_shift_ = machine_.z_axis().homing_shift();
  handle(ManualEvent::Homed);
}

// --- light

void ManualProcess::start_power_on() {
  power_end_.reset();
  powered_on_ = true;
  power_on_projector();
}

void ManualProcess::start_light() {
  light_on_for(light_time_, [this, operation = operations_](ProjectorReply, const std::string& problem) {
    if (operation == operations_) fail(problem);
  });
}

void ManualProcess::await_dark() {
  give_up_within(kDarkDeadline);
  machine_.projector().when_dark([this] { handle(ManualEvent::LightIsOff); });
}

void ManualProcess::ask_projector() {
  expect_within(kProjectorDeadline, "the projector's answer");
  machine_.projector().ask_status([this, operation = operations_](const ProjectorStatus& status) {
    if (operation != operations_ || state() != ManualState::Asking) return;
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
