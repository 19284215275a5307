#include "daemon/print/print_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/print/mask_cost.hpp"
#include "daemon/print/motion_timeout.hpp"
#include "hw/homing_distances.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The distance by which the plate moves up in a pause, so that the user can look at the part.
constexpr Nanometers kLook{30'000'000};

// Deadlines for a device that does not answer at all; otherwise a device reports its own failures.
constexpr Duration kPresentDeadline = 5s;
constexpr Duration kProjectorDeadline = 30s;
// The wait for the light to be confirmed off at a print's end. The projector keeps trying after that.
constexpr Duration kEndingDeadline = 5s;
// A projector may have to cool down before it warms up, and again if it ignored the power-on command.
constexpr Duration kWarmUpDeadline = 1h;

}  // namespace

std::string_view name_of(PrintOutcome outcome) {
  switch (outcome) {
    case PrintOutcome::Done:
      return "done";
    case PrintOutcome::Canceled:
      return "cancelled";
    case PrintOutcome::Failed:
      return "failed";
  }
  return "?";
}

Duration layer_duration(const PrintPlan& plan, std::int32_t layer, const ZAxis& axis) {
  return layer_duration(plan, layer, [&axis](Nanometers distance, MillimetersPerSecond speed) {
    return axis.move_duration(distance, speed);
  });
}

PrintProcess::PrintProcess(Machine& machine, Clock& clock, PrintObserver& observer)
    : machine_(machine), clock_(clock), observer_(observer) {
  make_safe(machine_);
}

PrintProcess::~PrintProcess() {
  make_safe(machine_);
  machine_.projector().when_dark({});  // drops the callback, which refers to this object
  machine_.projector().power_off();
}

void PrintProcess::start(PrintPlan plan) {
  expects(state_ == PrintState::Idle, "no print is under way");
  expects(plan.layers.thickness_at(Nanometers{}) && plan.exposure, "a print has a layer and its exposure");
  plan_ = std::move(plan);
  layer_ = 0;
  pause_wanted_ = resume_wanted_ = canceled_ = false;
  failure_.clear();
  interruption_.clear();
  begin_layer(Nanometers{});
  const Nanometers top =
      std::accumulate(plan_->expected_layers.begin(), plan_->expected_layers.end(), Nanometers{});
  left_after_.assign(plan_->expected_layers.size() + 1, parking_duration(top + plan_->lift));
  for (std::size_t i = plan_->expected_layers.size(); i-- > 0;) {
    left_after_[i] =
        left_after_[i + 1] + layer_duration(*plan_, static_cast<std::int32_t>(i), machine_.z_axis());
  }
  handle(PrintEvent::Started);
}

void PrintProcess::begin_layer(Nanometers bottom) {
  const std::optional<Nanometers> thickness = plan_->layers.thickness_at(bottom);
  if (!thickness) throw std::logic_error("a print has no layer on top of its last");
  bottom_ = bottom;
  thickness_ = *thickness;
  layer_exposed_ = layer_reported_ = false;
  record_ = LayerRecord{};
  record_.layer = layer_;
  record_.bottom = bottom_;
  record_.thickness = thickness_;
  record_.exposure_asked = plan_->exposure(layer_, thickness_);
}

void PrintProcess::pause() {
  resume_wanted_ = false;
  pause_wanted_ = state_ != PrintState::Paused && state_ != PrintState::Raising && state_ != PrintState::Held;
}

std::string_view PrintProcess::next_pause() const {
  expects(state_ != PrintState::Idle, "a print is under way");
  switch (state_) {
    case PrintState::Idle:
    case PrintState::Halting:
    case PrintState::Parking:
    case PrintState::Ending:
      return "";
    case PrintState::Raising:
    case PrintState::Paused:
    case PrintState::Held:
      return "now";
    case PrintState::WarmingUp:
    case PrintState::Homing:
      return "before the first layer";
    default:
      break;
  }
  if (canceled_) return "";
  if (state_ == PrintState::AwaitingDark && !has_all_light()) return "before the light goes on again";
  if (!interruption_.empty()) return "when the plate is up";
  return on_last_layer() ? "" : "after this layer";
}

void PrintProcess::resume() {
  pause_wanted_ = false;
  resume_wanted_ = state_ == PrintState::Raising;
  interruption_.clear();
  if (state_ == PrintState::Held || state_ == PrintState::Paused) handle(PrintEvent::Resumed);
}

void PrintProcess::interrupt(const std::string& what) {
  if (state_ == PrintState::Idle) return;
  // The exposure is over, and only the timer's callback has not run yet.
  if (state_ == PrintState::Exposing && clock_.now() >= exposure_end_ && !light_went_off())
    handle(PrintEvent::WaitOver);
  const bool is_new = interruption_.find(what) == std::string::npos;
  if (is_new) interruption_ += (interruption_.empty() ? "" : "; ") + what;
  resume_wanted_ = false;
  const bool goes_up_already = state_ == PrintState::Raising || state_ == PrintState::Paused;
  const bool goes_on =
      state_ != PrintState::Halting && state_ != PrintState::Parking && state_ != PrintState::Ending;
  pause_wanted_ = goes_on && !goes_up_already;
  handle(PrintEvent::Interrupted);
  if (state_ == PrintState::Held) pause_wanted_ = false;
  if (is_new && state_ != PrintState::Idle) observer_.interrupted(what);
}

void PrintProcess::cancel() {
  if (print_table().find(state_, PrintEvent::Canceled) == nullptr) return;
  canceled_ = true;
  handle(PrintEvent::Canceled);
}

void PrintProcess::fail(const std::string& reason) {
  if (print_table().find(state_, PrintEvent::Failed) == nullptr) return;
  failure_ = reason;
  handle(PrintEvent::Failed);
}

void PrintProcess::handle(PrintEvent event) {
  const PrintTransition* transition = print_table().find(state_, event);
  if (transition == nullptr) return;
  const PrintState next = transition->next(state_);
  if (next != state_) {
    ++states_entered_;
    wait_.reset();
    deadline_.reset();
    estimated_end_.reset();
    state_ = next;
  }
  try {
    for (const PrintEffect effect : transition->done())
      perform(effect);
    observer_.state_changed(state_);
  } catch (const std::exception& error) {
    machine_.projector().light_off();
    // An effect that throws while the print is ending only ends it without waiting any longer.
    if (state_ == PrintState::Idle) throw;
    state_ == PrintState::Ending ? handle(PrintEvent::GaveUp) : fail(error.what());
  }
  if (state_ == PrintState::Idle && plan_) finish();
  if (state_ == PrintState::Paused && std::exchange(resume_wanted_, false)) handle(PrintEvent::Resumed);
}

void PrintProcess::perform(PrintEffect effect) {
  switch (effect) {
    case PrintEffect::LightOff:
      machine_.projector().light_off();
      if (light_asked_ && !light_) light_ = machine_.projector().last_light();
      return expect_darkness();
    case PrintEffect::BlackNow:
      return machine_.display().black_now();
    case PrintEffect::AbortAxis:
      return machine_.z_axis().abort();
    case PrintEffect::StopAxis:
      expect_within(kStopTimeout, "the axis to stop");
      return machine_.z_axis().stop();
    case PrintEffect::PowerOn:
      return power_on();
    case PrintEffect::PowerOff:
      return machine_.projector().power_off();
    case PrintEffect::Home:
      return home();
    case PrintEffect::LowerToLayer:
      return move_to(layer_top(), layer_ == 0 ? plan_->travel_speed : plan_->retract_speed);
    case PrintEffect::WaitToSettle:
      return wait(plan_->settle);
    case PrintEffect::ShowMask:
      return show_mask();
    case PrintEffect::LightOn:
      return light_on();
    case PrintEffect::TimeExposure:
      return time_exposure();
    case PrintEffect::ShowBlack:
      return show_black();
    case PrintEffect::AwaitDark:
      if (state_ == PrintState::Ending) {
        deadline_ = clock_.call_after(kEndingDeadline, [this] { handle(PrintEvent::GaveUp); });
      } else {
        expect_within(kProjectorDeadline, "the projector to confirm that its light is off");
      }
      return expect_darkness();
    case PrintEffect::RecordLayer:
      return record_layer();
    case PrintEffect::WaitToRest:
      return wait(plan_->rest);
    case PrintEffect::Lift:
      return move_to(std::min(current_height() + plan_->lift, machine_.z_axis().travel()), plan_->lift_speed);
    case PrintEffect::NextLayer:
      ++layer_;
      return begin_layer(layer_top());
    case PrintEffect::RaiseForALook:
      pause_wanted_ = false;
      return move_to(std::min(current_height() + kLook, machine_.z_axis().travel()), plan_->travel_speed);
    case PrintEffect::Park:
      return move_to(machine_.z_axis().travel(), plan_->travel_speed);
    case PrintEffect::Finish:
      return;  // handle() finishes the print after all other effects
  }
}

template <typename Answer>
std::function<void(Answer)> PrintProcess::while_in_state(
    std::type_identity_t<std::function<void(Answer)>> call) {
  // This function is called while a transition is performed, so states_entered_ is the state just entered.
  return [this, entered = states_entered_, call = std::move(call)](Answer answer) {
    if (entered == states_entered_) call(answer);
  };
}

void PrintProcess::wait_until(TimePoint when) {
  estimated_end_ = when;
  wait_ = clock_.call_at(when, [this] { handle(PrintEvent::WaitOver); });
}

void PrintProcess::expect_within(Duration duration, const std::string& what) {
  deadline_ = clock_.call_after(duration, [this, duration, what] {
    fail(fmt::format("timed out after {:.0f} s waiting for {}",
                     std::chrono::duration<double>(duration).count(), what));
  });
}

Nanometers PrintProcess::current_height() const {
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) throw std::runtime_error("the plate's position is unknown");
  return *height;
}

void PrintProcess::power_on() {
  expect_within(kWarmUpDeadline, "the projector's lamp to warm up");
  estimate(plan_->warm_up);
  machine_.projector().power_on(while_in_state<ProjectorReply>([this](ProjectorReply reply) {
    if (reply == ProjectorReply::Ok) return handle(PrintEvent::ProjectorReady);
    fail(fmt::format("power on: {}", machine_.projector().last_problem()));
  }));
}

void PrintProcess::show_black() {
  expect_within(kPresentDeadline, "the display to show black");
  machine_.display().black(while_in_state<std::optional<TimePoint>>([this](std::optional<TimePoint> at) {
    if (at) return handle(PrintEvent::ScreenBlack);
    display_lost();
  }));
}

void PrintProcess::home() {
  expect_within(homing_timeout(machine_.z_axis(), plan_->homing_speed), "the axis to home");
  estimate(homing_duration());
  machine_.z_axis().home(while_in_state<HomingResult>([this](HomingResult result) {
    if (result == HomingResult::Homed) return handle(PrintEvent::Homed);
    fail(fmt::format("homing failed: {}", describe(result)));
  }));
}

void PrintProcess::move_to(Nanometers target, MillimetersPerSecond speed) {
  const Nanometers distance = target - current_height();
  expect_within(move_timeout(machine_.z_axis(), distance, speed), "a move to end");
  estimate(machine_.z_axis().move_duration(distance, speed));
  machine_.z_axis().move_to(target, speed, [this, move_state = state_](MoveResult result) {
    // A move that was stopped ends in Halting or Braking instead of the state in which it began.
    const bool stopping = state_ == PrintState::Halting || state_ == PrintState::Braking;
    if (state_ == move_state || stopping) after_move(result);
  });
}

void PrintProcess::after_move(MoveResult result) {
  const bool stopping = state_ == PrintState::Halting || state_ == PrintState::Braking;
  if (result != MoveResult::Reached && !(stopping && result == MoveResult::Stopped))
    return fail(fmt::format("the plate did not arrive: {}", describe(result)));
  handle(PrintEvent::MoveEnded);
}

PrintEvent PrintProcess::next_due() const {
  if (canceled_) return PrintEvent::Canceled;
  const PrintEvent due = !has_all_light()  ? PrintEvent::LayerUnfinished
                         : on_last_layer() ? PrintEvent::LayersDone
                                           : PrintEvent::LayerDue;
  const bool nothing_to_pause = due == PrintEvent::LayersDone && interruption_.empty();
  return pause_wanted_ && !nothing_to_pause ? PrintEvent::PauseDue : due;
}

// Interrupts the print; if the machine has reported the cause already, keeps its more detailed text.
void PrintProcess::display_lost() {
  interrupt(interruption_.empty() ? "the display was lost" : interruption_);
}

// --- Light

void PrintProcess::light_on() {
  expect_within(kProjectorDeadline, "the light-on command to be sent to the projector");
  light_asked_ = true;
  light_.reset();
  const auto sent = while_in_state<TimePoint>([this](TimePoint earliest) {
    exposure_end_ = earliest + exposure_left();
    handle(PrintEvent::LightOnSent);
  });
  machine_.projector().light_on(
      exposure_left(), {.sent = sent, .done = [this](ProjectorReply reply) { light_answered(reply); }});
}

// Handles the reply to light on. The exposure does not wait for it and may be over already.
void PrintProcess::light_answered(ProjectorReply reply) {
  if (reply == ProjectorReply::Ok) return;
  const std::string what = fmt::format("light on: {}", machine_.projector().last_problem());
  reply == ProjectorReply::Refused ? fail(what) : interrupt(what);
}

void PrintProcess::time_exposure() {
  estimated_end_ = exposure_end_;
  wait_ = clock_.call_at(exposure_end_, [this] {
    if (light_went_off()) return interrupt("the light went off before its exposure was over");
    handle(PrintEvent::WaitOver);
  });
}

// True if something else turned the light off before the end of the exposure, so that the layer lacks light.
bool PrintProcess::light_went_off() const {
  const std::optional<LightSpan> light = machine_.projector().last_light();
  return light && light->off_earliest && *light->off_earliest < exposure_end_;
}

void PrintProcess::expect_darkness() {
  machine_.projector().when_dark([this] { is_dark(); });
}

void PrintProcess::is_dark() {
  count_light();
  if (layer_exposed_ && !layer_reported_) report_layer();
  handle(state_ == PrintState::AwaitingDark ? next_due() : PrintEvent::LightIsOff);
}

// Adds the light that has just gone off to the layer's record; if it is not confirmed off, adds its time so
// far. A projector that was lost in the meantime, and another that was found, know nothing of this light: it
// may still be on.
void PrintProcess::count_light() {
  if (!std::exchange(light_asked_, false)) return;
  observer_.light_gone();
  if (!light_) return;
  const std::optional<LightSpan> known = machine_.projector().last_light();
  if (known && known->on_earliest == light_->on_earliest) light_ = known;
  record_.exposure_least += light_->least();
  record_.exposure_most += light_->most(clock_.now());
  record_.dark_confirmed = record_.dark_confirmed && light_->off_latest;
  ++record_.exposure_parts;
}

bool PrintProcess::has_all_light() const {
  return layer_exposed_ || (record_.exposure_parts > 0 && exposure_left() < kShortestExposure);
}

// Reports the layer to the observer. Called in the dark, since counting the mask's loops takes time.
void PrintProcess::report_layer() {
  layer_reported_ = true;
  record_.complete = layer_exposed_;
  if (layer_exposed_) record_.loops = plan_->engine->count_loops();
  observer_.layer_done(record_);
  if (layer_exposed_) judge_exposure();
}

// Requests a pause if the layer's exposure is less certain than its resin tolerates. No other transition is
// needed: the plate is already up, or is lifted next.
void PrintProcess::judge_exposure() {
  const Duration apart = record_.exposure_most - record_.exposure_least;
  if (apart <= plan_->tolerance.bounds || plan_->tolerance.policy == ExposureTolerance::Policy::Warn) return;
  const std::string what = fmt::format(
      "the exposure of layer {} is uncertain by {:.0f} ms, but its resin tolerates only {:.0f} ms",
      layer_ + 1, std::chrono::duration<double, std::milli>(apart).count(),
      std::chrono::duration<double, std::milli>(plan_->tolerance.bounds).count());
  interruption_ += (interruption_.empty() ? "" : "; ") + what;
  resume_wanted_ = false;
  pause_wanted_ = true;
  observer_.interrupted(what);
}

void PrintProcess::show_mask() {
  // The mask belongs to the plate's actual height, not to its planned height. The new layer lies below the
  // plate's height and is cut at its middle.
  record_.plate_height = current_height();
  record_.mask_height = record_.plate_height - thickness_ / 2;
  shown_.mask = nullptr;
  const auto start = MaskBudget::Clock::now();
  MaskBudget budget(start + plan_->mask_budget);
  const Mask* const mask = plan_->engine->mask_within(record_.mask_height, budget);
  record_.mask_time = MaskBudget::Clock::now() - start;
  if (mask == nullptr) return abandon_mask(budget);
  record_.area_mm2 = plan_->engine->coverage().lit_area() * plan_->pixel_area_mm2;
  record_.intersecting_facets = plan_->engine->intersecting_facets();
  record_.cracks = plan_->engine->cracks();
  shown_ = {mask, shown_.number + 1, plan_->job, layer_, record_.mask_height};
  expect_within(kPresentDeadline, "the display to show the mask");
  machine_.display().show(*mask,
                          while_in_state<std::optional<TimePoint>>([this](std::optional<TimePoint> at) {
                            if (!at) return display_lost();
                            record_.shown_at = *at;
                            handle(PrintEvent::MaskShown);
                          }));
}

// Interrupts the print because its mask exceeded the budget. The screen is black and stays so. The
// interruption follows in the event loop's next turn, since the current turn has been long already.
void PrintProcess::abandon_mask(const MaskBudget& spent) {
  const std::string what =
      fmt::format("the mask at {:.3f} mm was abandoned because it exceeded mask_budget_ms, {:.0f} ms: {}",
                  to_millimeters(record_.mask_height).count(),
                  std::chrono::duration<double, std::milli>(plan_->mask_budget).count(),
                  describe_mask_cost(*plan_->engine, spent, record_.mask_time));
  wait_ = clock_.call_at(clock_.now(), [this, what] { interrupt(what); });
}

void PrintProcess::record_layer() {
  if (layer_exposed_) return;
  layer_exposed_ = true;
  if (!light_asked_ && !layer_reported_) report_layer();
}

void PrintProcess::finish() {
  const PrintOutcome outcome = !failure_.empty() ? PrintOutcome::Failed
                               : canceled_       ? PrintOutcome::Canceled
                                                 : PrintOutcome::Done;
  count_light();
  if (record_.exposure_parts > 0 && !layer_reported_) report_layer();
  PrintPlan plan = std::move(*plan_);
  plan_.reset();
  shown_.mask = nullptr;
  observer_.print_ended(outcome, failure_, std::move(plan));
}

// --- The time left

std::optional<Duration> PrintProcess::state_left() const {
  expects(state_ != PrintState::Idle, "a print is under way");
  if (!estimated_end_) return std::nullopt;
  return std::max(*estimated_end_ - clock_.now(), Duration{0});
}

Duration PrintProcess::time_left() const {
  expects(state_ != PrintState::Idle, "a print is under way");
  return state_left().value_or(Duration{0}) + left_after_state();
}

// Returns the expected duration of homing: to the switch, back off it and to it again. A plate at an unknown
// height is assumed to be where a print parks it.
Duration PrintProcess::homing_duration() const {
  const ZAxis& axis = machine_.z_axis();
  const MillimetersPerSecond slow{plan_->homing_speed.count() / 2};
  const Nanometers distance = plan_->home_height - axis.height().value_or(axis.travel());
  return axis.move_duration(distance, plan_->homing_speed) +
         axis.move_duration(kBackOff, plan_->homing_speed) + axis.move_duration(kBackOff, slow);
}

Duration PrintProcess::parking_duration(Nanometers from) const {
  const ZAxis& axis = machine_.z_axis();
  return axis.move_duration(std::max(axis.travel() - from, Nanometers{}), plan_->travel_speed);
}

Duration PrintProcess::lowering_duration(std::int32_t layer) const {
  const ZAxis& axis = machine_.z_axis();
  if (layer > 0) return axis.move_duration(-plan_->lift, plan_->retract_speed);
  return axis.move_duration(layer_top() - plan_->home_height, plan_->travel_speed);
}

// Returns the time that the layer under way takes after the current state.
Duration PrintProcess::left_of_layer() const {
  const Duration lift = machine_.z_axis().move_duration(plan_->lift, plan_->lift_speed);
  const Duration light = std::max(exposure_left(), Duration{0});
  const Duration lit = light + plan_->rest + lift;
  const Duration whole = lowering_duration(layer_) + plan_->settle + lit;
  switch (state_) {
    case PrintState::WarmingUp:
      return homing_duration() + whole;
    case PrintState::Held:
      return plan_->warm_up + homing_duration() + whole;
    case PrintState::Lowering:
      return plan_->settle + lit;
    case PrintState::Settling:
    case PrintState::Showing:
    case PrintState::Igniting:
      return lit;
    case PrintState::Exposing:
    case PrintState::Darkening:
    case PrintState::Extinguishing:
      return plan_->rest + lift;
    case PrintState::Resting:
      return lift;
    default:
      return has_all_light() ? Duration{0} : whole;
  }
}

Duration PrintProcess::left_after_state() const {
  if (state_ == PrintState::Parking || state_ == PrintState::Ending) return Duration{0};
  if (canceled_) return parking_duration(machine_.z_axis().height().value_or(layer_top()));
  const std::size_t next = static_cast<std::size_t>(layer_) + 1;
  return left_of_layer() + left_after_[std::min(next, left_after_.size() - 1)];
}

}  // namespace contourd
