#include "daemon/print/continuous_print.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/print/layer_durations.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The distance by which the plate moves up after the rise, so that the user can look at the part.
constexpr Nanometers kLookUp{30'000'000};
// A rise gets its planned time, a tenth more for steps that come late, and this.
constexpr Duration kRiseMargin = 2s;

constexpr EnumSet<ContinuousState> kEnding{ContinuousState::Parking, ContinuousState::Ending};
constexpr EnumSet<ContinuousState> kStopping{ContinuousState::Braking, ContinuousState::Darkening,
                                             ContinuousState::Lifting};

// Returns the time of light for a rise that takes this long, with the margin that its lateness may take.
Duration longest_light(Duration rise) {
  return rise * 11 / 10 + kRiseMargin;
}

// True if the plan has rises, and each begins on top of a layer, where the one before ends or higher.
bool rise_in_order(const PrintPlan& plan) {
  Nanometers from{1};
  for (const PlannedRise& rise : plan.rises->each) {
    if (rise.first_layer < 1 || rise.plan.points.size() < 3) return false;
    const Nanometers bottom = rise.plan.points.front().height;
    if (bottom < from || !plan.layers.thickness_at(bottom)) return false;
    from = rise.plan.points.back().height;
  }
  return !plan.rises->each.empty();
}

}  // namespace

ContinuousPrint::ContinuousPrint(Machine& machine, Clock& clock, PrintObserver& observer)
    : MachineProcess(machine, clock, continuous_table()),
      observer_(observer),
      layers_(machine, clock, *this) {}

ContinuousPrint::~ContinuousPrint() {
  make_machine_safe();  // before the wait for the masks' thread
  frames_.reset();
}

void ContinuousPrint::start(PrintPlan plan) {
  expects(!under_way(), "no print is under way");
  expects(plan.layers.thickness_at(Nanometers{}) && plan.exposure, "a print has a layer and its exposure");
  expects(!plan.rises || (rise_in_order(plan) && !plan.undersides && !plan.split),
          "rises follow at least one layer, with masks as they are");
  plan_ = std::move(plan);
  rises_ = {};
  if (plan_->rises) rises_ = {*plan_->rises, plan_->resume.value_or(ResumePoint{}).bottom};
  planned_pause_.reset();
  canceled_ = over_ = pause_wanted_ = false;
  reason_.clear();
  interruption_.clear();
  handle(ContinuousEvent::Started);
}

// --- What the user asks for

void ContinuousPrint::pause() {
  if (layering()) return layers_.pause();
  planned_pause_.reset();
  pause_wanted_ = !is_in(ContinuousState::Paused);
  if (!ends() && !is_in(kStopping)) handle(ContinuousEvent::Interrupted);
}

void ContinuousPrint::pause_at(PausePoint point) {
  expects(under_way(), "a print is under way");
  if (layering()) return layers_.pause_at(point);
  planned_pause_ = point;
}

void ContinuousPrint::set(const PrintSettings& settings) {
  expects(under_way(), "a print is under way");
  if (layering()) return layers_.set(settings);
  plan_->motion = settings.motion;
  left_after_ = durations_to_end(*plan_, machine_.z_axis());
}

std::optional<RisesAhead> ContinuousPrint::rises_ahead() const {
  if (!under_way() || ends() || is_in(kEnding) || !rises_.any_left() || !rises_.can_change())
    return std::nullopt;
  const bool moves = is_in({ContinuousState::Rising, ContinuousState::Slowing});
  RisesAhead ahead = rises_.ahead(moves ? machine_.z_axis().height() : std::nullopt);
  if (light_) ahead.each.front().lit += std::max(clock_.now() - light_->noted, Duration{});
  return ahead;
}

void ContinuousPrint::change(const ChangedRises& rises) {
  expects(under_way() && rises_.any_left(), "a rise is left");
  const double light_before = rises_.settings().light_percent;
  rises_.change(rises, clock_.now());
  if (layering()) return layers_.change(rises);
  take_change(rises, *plan_->rises);
  left_after_ = durations_to_end(*plan_, machine_.z_axis());
  const bool is_lit = is_in({ContinuousState::Rising, ContinuousState::Slowing});
  if (frames_ && (!is_lit || rises.settings.light_percent > light_before)) set_white();
}

// Passes the share of the lamp's light on to the masks.
void ContinuousPrint::set_white() {
  frames_->set_white(white_for(rises_.settings().light_percent, plan_->rises->gamma));
}

void ContinuousPrint::exclude(ExcludedCopy copy) {
  expects(under_way(), "a print is under way");
  expects(layering(), "copies are left dark while layers are printed");
  layers_.exclude(std::move(copy));
}

void ContinuousPrint::resume() {
  if (layering()) return layers_.resume();
  if (!is_in(kStopping) && !is_in(ContinuousState::Paused)) planned_pause_.reset();
  pause_wanted_ = false;
  interruption_.clear();
  if (is_in(ContinuousState::Paused)) handle(next_due());
}

void ContinuousPrint::interrupt(const std::string& what) {
  stop_for(what, ContinuousEvent::Interrupted);
}

void ContinuousPrint::stop_for(const std::string& what, ContinuousEvent event) {
  if (!under_way()) return;
  if (layering()) {
    layers_interruption_ = what;
    return handle(ContinuousEvent::Interrupted);
  }
  const bool is_new = interruption_.find(what) == std::string::npos;
  if (is_new) interruption_ += (interruption_.empty() ? "" : "; ") + what;
  pause_wanted_ = !is_in(ContinuousState::Paused);
  handle(event);
  if (is_new && under_way()) observer_.interrupted(what);
}

void ContinuousPrint::cancel() {
  if (!answers(ContinuousEvent::Canceled)) return;
  canceled_ = !layering();
  handle(ContinuousEvent::Canceled);
}

void ContinuousPrint::fail(const std::string& reason) {
  if (!answers(ContinuousEvent::Failed)) return;
  reason_ = reason;
  handle(ContinuousEvent::Failed);
}

// --- What others see

const PrintState& ContinuousPrint::state() const {
  return layering() ? layers_.state()
                    : continuous_print_states()[static_cast<std::size_t>(continuous_state())];
}

bool ContinuousPrint::pause_pending() const {
  return layering() ? layers_.pause_pending() : is_in(kStopping) && pause_wanted_ && !ends();
}

const std::optional<PausePoint>& ContinuousPrint::planned_pause() const {
  return layering() ? layers_.planned_pause() : planned_pause_;
}

std::string_view ContinuousPrint::why_fixed(std::string_view what) const {
  expects(under_way(), "a print is under way");
  if (is_of_rises(what)) {
    if (!rises_.planned())
      return "the plate of this print does not rise in the light: it has no speed, light or margin to change";
    if (!rises_ahead()) return "no rise follows: what is left is printed in layers";
    return is_in({ContinuousState::Rising, ContinuousState::Slowing}) && rises_.just_changed(clock_.now())
               ? "the rise was changed a moment ago, which stops the plate in the light: try again in three "
                 "seconds"
               : "";
  }
  if (layering()) return layers_.why_fixed(what);
  if (what == "exposure") return LayeredPrint::kFixedExposure;
  return what == "copies" ? "a continuous print leaves copies dark only while it prints layers" : "";
}

PrintSettings ContinuousPrint::settings() const {
  expects(under_way(), "a print is under way");
  if (!layering()) return {plan_->exposure_percent, plan_->motion, rises_.settings()};
  PrintSettings settings = layers_.settings();
  settings.rise = rises_.settings();
  return settings;
}

std::string_view ContinuousPrint::next_pause() const {
  if (layering()) return layers_.next_pause();
  if (ends() || is_in(kEnding)) return "";
  return is_in(kStopping) ? "when the plate is up" : "now";
}

bool ContinuousPrint::can_resume() const {
  return layering() ? layers_.can_resume()
                    : pause_pending() || planned_pause_ || is_in(ContinuousState::Paused);
}

bool ContinuousPrint::can_cancel() const {
  return layering() ? layers_.can_cancel() : canceled_ || !is_in(kEnding);
}

std::string_view ContinuousPrint::why_it_ends() const {
  if (layering()) return layers_.why_it_ends();
  if (canceled_) return "the print is being cancelled";
  return is_in(ContinuousState::Ending) ? "the print is over" : "the plate has risen to the end and goes up";
}

const std::string& ContinuousPrint::interruption() const {
  return layering() ? layers_.interruption() : interruption_;
}

std::int32_t ContinuousPrint::layer() const {
  return layering() ? layers_.layer() : record_.layer;
}

Nanometers ContinuousPrint::layer_top() const {
  return layering() ? layers_.layer_top() : record_.bottom + record_.thickness;
}

Nanometers ContinuousPrint::layer_thickness() const {
  return layering() ? layers_.layer_thickness() : record_.thickness;
}

ShownMask ContinuousPrint::shown() const {
  if (layering() || !frames_) return layers_.shown();
  ShownMask shown = frames_->shown();
  shown.layer = record_.layer;
  return shown;
}

bool ContinuousPrint::shows_mask() const {
  return layering() ? layers_.shows_mask()
                    : is_in({ContinuousState::Igniting, ContinuousState::Rising, ContinuousState::Slowing});
}

std::optional<Duration> ContinuousPrint::state_left() const {
  if (layering()) return layers_.state_left();
  if (!estimated_end_) return std::nullopt;
  return std::max(*estimated_end_ - clock_.now(), Duration{0});
}

Duration ContinuousPrint::time_left() const {
  if (layering()) return layers_.time_left();
  return state_left().value_or(Duration{0}) + left_after_state();
}

Duration ContinuousPrint::left_after_state() const {
  if (is_in(kEnding)) return Duration{0};
  if (ends()) return parking_duration();
  const auto next = static_cast<std::size_t>(record_.layer);
  if (!rises_.begun()) {
    const bool rests = is_in(ContinuousState::Recovering);
    return left_after_[next] - (rests ? rises_.current().rest : Duration{0});
  }
  const Nanometers top = rise_top();
  std::size_t above = next;
  for (Nanometers bottom = record_.bottom; bottom < top; ++above)
    bottom += plan_->expected_layers[above];
  const Duration lift = lift_duration(plan_->motion, moves_of(machine_.z_axis()));
  return left_after_[above] + lift + (is_in(ContinuousState::Rising) ? Duration{0} : rise_left());
}

Duration ContinuousPrint::rise_left() const {
  return rises_.begun() ? std::chrono::duration_cast<Duration>(duration(rises_.rest())) : Duration{0};
}

Duration ContinuousPrint::parking_duration() const {
  const ZAxis& axis = machine_.z_axis();
  const Nanometers from = axis.height().value_or(layer_top());
  return axis.move_duration(std::max(axis.travel() - from, Nanometers{}), plan_->travel_speed);
}

// --- The layered print

// The layered print becomes idle before it says how it has ended.
void ContinuousPrint::state_changed(const PrintState& state) {
  if (state != kIdle) observer_.state_changed(state);
}

void ContinuousPrint::print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) {
  plan_ = std::move(plan);
  layers_outcome_ = outcome;
  reason_ = reason;
  if (outcome != PrintOutcome::Done || !rises_.any_left()) return handle(ContinuousEvent::LayeringEnded);
  planned_pause_ = layers_.planned_pause();
  left_after_ = durations_to_end(*plan_, machine_.z_axis());
  rises_.reach();
  record_ = {};
  record_.layer = rises_.current().first_layer - 1;
  begin_slice(rises_.current().plan.points.front().height);
  handle(next_due());
}

// --- The table

void ContinuousPrint::performed(ContinuousEvent) {
  if (is_in(ContinuousState::Layering)) return;
  if (is_in(ContinuousState::Showing)) observer_.light_due();
  observer_.state_changed(state());
  if (is_in({ContinuousState::Recovering, ContinuousState::Lowering, ContinuousState::Lifting,
             ContinuousState::Paused, ContinuousState::Parking}))
    report_progress();
}

// Returns what comes next, once the plate is up in the dark.
ContinuousEvent ContinuousPrint::next_due() const {
  if (ends()) return ContinuousEvent::RisesOver;
  if (pause_wanted_) return ContinuousEvent::PauseDue;
  switch (rises_.next()) {
    case NextPart::Layers:
      return ContinuousEvent::LayersDue;
    case NextPart::Rest:
      return ContinuousEvent::RestDue;
    case NextPart::Rise:
      break;
  }
  return ContinuousEvent::RiseDue;
}

// Reports the bounds of the plate's height until the next report. Between two parts, what is printed is known
// to the layer.
void ContinuousPrint::report_progress() {
  PrintProgress progress;
  progress.layer = record_.layer;
  progress.bottom = record_.bottom;
  progress.thickness = record_.thickness;
  if (!rises_.begun()) {
    progress.exposed = true;
    if (!over_) {
      --progress.layer;
      progress.thickness = plan_->expected_layers[static_cast<std::size_t>(progress.layer)];
      progress.bottom -= progress.thickness;
    }
  }
  progress.phase = phase();
  const ZAxis& axis = machine_.z_axis();
  if (const std::optional<Nanometers> height = axis.height()) {
    progress.plate = {*height, *height};
    if (is_in(ContinuousState::Lowering))
      progress.plate = {std::min(*height, rises_.rest().points.front().height),
                        std::max(*height, rises_.rest().points.back().height)};
    if (is_in(ContinuousState::Lifting)) progress.plate->most = std::min(*height + kLookUp, axis.travel());
    if (is_in(ContinuousState::Parking)) progress.plate->most = axis.travel();
  }
  observer_.progressed(progress);
}

// Returns the phase that begins with the state. A cancelled print only moves up.
PrintPhase ContinuousPrint::phase() const {
  if (canceled_ || is_in(ContinuousState::Parking)) return PrintPhase::Parking;
  if (rises_.begun()) return PrintPhase::Rising;
  if (is_in(ContinuousState::Lifting)) return PrintPhase::Lifting;
  return is_in(ContinuousState::Paused) ? PrintPhase::Paused : PrintPhase::Lit;
}

void ContinuousPrint::effect_threw(const std::string& what) {
  if (!under_way()) throw;
  is_in(ContinuousState::Ending) ? handle(ContinuousEvent::GaveUp) : fail(what);
}

void ContinuousPrint::settled() {
  if (is_in(ContinuousState::Idle) && plan_) finish();
}

void ContinuousPrint::perform(ContinuousEffect effect) {
  switch (effect) {
    case ContinuousEffect::PrintLayers:
      return layers_.start(*std::exchange(plan_, std::nullopt));
    case ContinuousEffect::PrintMoreLayers:
      return print_more_layers();
    case ContinuousEffect::InterruptLayers:
      return layers_.interrupt(layers_interruption_);
    case ContinuousEffect::CancelLayers:
      return layers_.cancel();
    case ContinuousEffect::FailLayers:
      return layers_.fail(reason_);
    case ContinuousEffect::LightOff:
      return turn_light_off();
    case ContinuousEffect::BlackNow:
      return machine_.display().black_now();
    case ContinuousEffect::AbortAxis:
      return machine_.z_axis().abort();
    case ContinuousEffect::StopAxis:
      return stop_axis();
    case ContinuousEffect::PowerOff:
      return machine_.projector().power_off();
    case ContinuousEffect::AwaitOxygen:
      estimated_end_ = std::max(rises_.rest_until(clock_.now()), clock_.now());
      return handle_at(*estimated_end_, ContinuousEvent::WaitOver);
    case ContinuousEffect::LowerToRise:
      return lower();
    case ContinuousEffect::WaitToSettle:
      estimate(expected_settling(*plan_, record_.layer));
      return handle_at(*estimated_end_, ContinuousEvent::WaitOver);
    case ContinuousEffect::ShowMask:
      expect_within(5s + plan_->mask_budget, "the first mask to be shown");
      return frames_->show_first([this] { handle(ContinuousEvent::MaskShown); },
                                 [this](const std::string& what) { interrupt(what); });
    case ContinuousEffect::LightOn:
      return expose();
    case ContinuousEffect::Rise:
      show_masks();
      return rise();
    case ContinuousEffect::RiseOn:
      return rise();
    case ContinuousEffect::AwaitDark:
      if (is_in(ContinuousState::Ending))
        give_up_within(kDarkDeadline);
      else
        expect_within(kProjectorDeadline, "the projector to confirm that its light is off");
      return machine_.projector().when_dark([this] { is_dark(); });
    case ContinuousEffect::Lift:
      return lift();
    case ContinuousEffect::Park:
      return move_to(machine_.z_axis().travel(), plan_->travel_speed,
                     [this] { handle(ContinuousEvent::MoveEnded); });
    case ContinuousEffect::Finish:
      return;  // handle() finishes the print after all other effects
  }
}

// --- Layers on top of a rise

void ContinuousPrint::print_more_layers() {
  frames_.reset();
  layers_.go_on(*std::exchange(plan_, std::nullopt), record_.layer, record_.bottom);
  if (planned_pause_) layers_.pause_at(*std::exchange(planned_pause_, std::nullopt));
}

// --- Moves

// Notes where the plate has come to rest in a rise.
void ContinuousPrint::stop_here() {
  const Nanometers top = rise_top();
  rises_.stop_at(current_height());
  if (rises_.begun()) return;
  while (layer_top() < top) {
    const Nanometers next = layer_top();
    report_slice(true);
    begin_slice(next);
  }
  record_.complete = true;
  over_ = !plan_->layers.thickness_at(top);
}

Nanometers ContinuousPrint::current_height() const {
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) throw std::runtime_error("the plate's position is unknown");
  return *height;
}

void ContinuousPrint::move_to(Nanometers target, MillimetersPerSecond speed, std::function<void()> arrived) {
  ZAxis& axis = machine_.z_axis();
  const Nanometers distance = target - current_height();
  expect_move(distance, speed, "a move to end");
  estimate(axis.move_duration(distance, speed));
  axis.move_to(target, speed, [this, arrived = std::move(arrived)](MoveResult result) {
    if (result == MoveResult::Reached && !is_in(ContinuousState::Braking)) return arrived();
    const bool rests = result == MoveResult::Stopped || result == MoveResult::Resistance;
    if (is_in(ContinuousState::Braking) && (rests || result == MoveResult::Reached))
      return handle(ContinuousEvent::MoveEnded);
    if (result == MoveResult::Resistance) return meet_resistance();
    fail(fmt::format("the plate did not arrive: {}", name_of(result)));
  });
}

// The plate rests where it met resistance, and the print is in the dark.
void ContinuousPrint::meet_resistance() {
  const ForcePolicy policy = plan_->force.value_or(ForcePolicy{});
  const Nanometers target = rises_.rest().points.front().height;
  const std::string what = describe_resistance(current_height(), target, policy);
  if (policy.resistance_fails) return fail(what);
  interrupt(what);
  handle(ContinuousEvent::MoveEnded);
}

// Lowers the plate to the height from which it rises, slowly at the end, where it presses out resin.
void ContinuousPrint::lower() {
  if (!frames_) {
    const Nanometers solid = rises_.current().plan.points.front().height;
    frames_ = std::make_unique<RiseFrames>(machine_, clock_, *plan_, solid);
  }
  rises_.begin();
  set_white();
  const LayerMotion& motion = plan_->motion;
  const Nanometers height = rises_.rest().points.front().height;
  machine_.z_axis().expect_contact_at(height);
  const Nanometers slow_from = std::min(height + motion.slow_retract, current_height());
  const auto there = [this] { handle(ContinuousEvent::MoveEnded); };
  if (slow_from <= height) return move_to(height, motion.retract_speed, there);
  move_to(slow_from, motion.retract_speed,
          [this, height, there] { move_to(height, plan_->motion.slow_retract_speed, there); });
}

// Peels the part off as after a layer; for a pause and at the end, moves the plate further up.
void ContinuousPrint::lift() {
  if (record_.complete) end_rise();
  const LayerMotion& motion = plan_->motion;
  const Nanometers from = current_height(), highest = machine_.z_axis().travel();
  move_to(std::min(from + motion.lift, highest), motion.lift_speed, [this, from, highest] {
    const bool looks = ends() || pause_wanted_;
    const Nanometers whole = looks ? kLookUp : plan_->motion.whole_lift();
    const Nanometers target = std::max(std::min(from + whole, highest), current_height());
    if (target == current_height() || (!looks && plan_->motion.second_lift == Nanometers{}))
      return handle(next_due());
    move_to(target, looks ? plan_->travel_speed : plan_->motion.second_lift_speed,
            [this] { handle(next_due()); });
  });
}

// Reports the last slice of a rise. The next layer or slice, if there is one, begins.
void ContinuousPrint::end_rise() {
  report_slice(true);
  record_.exposure_parts = 0;
  if (over_) return;
  begin_slice(layer_top());
  if (!planned_pause_ || !is_reached(*planned_pause_, record_.layer, record_.bottom)) return;
  planned_pause_.reset();
  pause_wanted_ = true;
}

// --- Light

// Returns the longest time that what is left of the rise may take, however its speeds change.
Duration ContinuousPrint::longest_rise() const {
  const PlannedRises& plan = *plan_->rises;
  const bool can_change = rises_.can_change() || plan.missed == MissedMasks::Slow;
  if (!can_change) return rise_left();
  const Duration longest = rises_.longest(plan.slowest);
  if (plan.missed == MissedMasks::Slow) return longest;
  const auto window = std::chrono::duration<double>(plan.bounds.window);
  return window < longest ? std::max(std::chrono::duration_cast<Duration>(window), rise_left()) : longest;
}

// The rise itself ends the light.
void ContinuousPrint::expose() {
  const Duration most = longest_light(longest_rise());
  if (plan_->dry) {
    light_end_ = clock_.now() + most;
    return handle_at(clock_.now(), ContinuousEvent::LightOnSent);
  }
  light_on_for(most, [this](ProjectorReply reply, const std::string& problem) {
    reply == ProjectorReply::Refused ? fail(problem) : interrupt(problem);
  });
}

// Returns the height up to which the rise makes the part.
Nanometers ContinuousPrint::rise_top() const {
  return rises_.current().plan.points.back().height;
}

void ContinuousPrint::show_masks() {
  if (!plan_->dry) {
    const LightSpan span = machine_.projector().last_light().value_or(LightSpan{clock_.now(), {}, {}, {}});
    light_ = Light{span, span.on_earliest};
  }
  // The masks of the last rise become dark at its top. Those of others do not show what is on top of them.
  const Nanometers top = rise_top();
  const bool goes_on = plan_->layers.thickness_at(top).has_value();
  frames_->run(
      {.refreshed = [this] { refreshed(); },
       .missed = [this] { missed(); },
       .unsafe = [this](const std::string& what) { interrupt(what); },
       .frame_over =
           [this](FrameRecord frame) {
             frame.layer = record_.layer;
             observer_.frame_over(frame);
           },
       .lit_from = light_ ? std::optional(light_->noted) : std::nullopt,
       .highest = goes_on ? top - Nanometers{1} : Nanometers{std::numeric_limits<std::int64_t>::max()}});
}

void ContinuousPrint::rise() {
  set_white();
  estimate(rise_left());
  wait_ = clock_.call_at(std::min(light_end_, clock_.now() + longest_light(rise_left())),
                         [this] { interrupt("the rise takes longer than planned"); });
  machine_.z_axis().rise(rises_.rest(), [this](MoveResult result) { risen(result); });
}

void ContinuousPrint::risen(MoveResult result) {
  const bool at_rest = result == MoveResult::Reached || result == MoveResult::Stopped;
  if (at_rest) stop_here();
  if (is_in(ContinuousState::Braking) && at_rest) return handle(ContinuousEvent::MoveEnded);
  if (is_in(ContinuousState::Slowing) && at_rest)
    return handle(rises_.begun() ? ContinuousEvent::SlowedDown : ContinuousEvent::MoveEnded);
  if (result == MoveResult::Stopped)
    return stop_for("a disturbance has stopped the plate", ContinuousEvent::RiseBroken);
  if (result != MoveResult::Reached) return fail(fmt::format("the plate did not rise: {}", name_of(result)));
  handle(ContinuousEvent::MoveEnded);
}

// Does what the plan says about a missed mask.
void ContinuousPrint::missed() {
  const PlannedRises& plan = *plan_->rises;
  if (plan.missed == MissedMasks::Pause)
    return interrupt(fmt::format("a mask was missed at {:.3f} mm", in_mm(current_height())));
  if (plan.missed != MissedMasks::Slow || !is_in(ContinuousState::Rising)) return;
  if (!rises_.slow_down(current_height(), plan.slowest, clock_.now())) return;
  frames_->note_slower();
  handle(ContinuousEvent::TooFast);
}

// Reports the slices that the plate has left, and checks that the light is on.
void ContinuousPrint::refreshed() {
  const std::optional<LightSpan> light = machine_.projector().last_light();
  if (!plan_->dry && light && light->off_earliest) return interrupt("the light went off during the rise");
  if (rises_.is_changed() && is_in(ContinuousState::Rising) && frames_->shows_white())
    return handle(ContinuousEvent::SpeedsChanged);
  const std::optional<Nanometers> gelled = frames_->gelled();
  const Nanometers end = rise_top();
  while (gelled && *gelled >= layer_top() && layer_top() < end) {
    const Nanometers top = layer_top();
    report_slice(true);
    begin_slice(top);
    if (planned_pause_ && is_reached(*planned_pause_, record_.layer, record_.bottom)) {
      planned_pause_.reset();
      pause_wanted_ = true;
      return handle(ContinuousEvent::Interrupted);
    }
  }
}

void ContinuousPrint::begin_slice(Nanometers bottom) {
  const std::optional<Nanometers> thickness = plan_->layers.thickness_at(bottom);
  if (!thickness) throw std::logic_error("a rise begins above the last layer");
  const std::int32_t layer = record_.layer + 1;
  record_ = LayerRecord{};
  record_.layer = layer;
  record_.rises = true;
  record_.bottom = bottom;
  record_.thickness = *thickness;
  record_.plate_height = bottom + *thickness;
  record_.mask_height = bottom + *thickness / 2;
}

// Adds the light since it went on, or since the last call, to the slice, as far as the projector's answers
// show it. A projector that was lost in the meantime, and another that was found, know nothing of this light.
void ContinuousPrint::note_light() {
  if (!light_) return;
  LightSpan& span = light_->span;
  const std::optional<LightSpan> known = machine_.projector().last_light();
  if (known && known->on_earliest == span.on_earliest) span = *known;
  const TimePoint now = clock_.now();
  if (now <= light_->noted) return;
  const TimePoint from = std::exchange(light_->noted, now);
  const auto since_then = [now, from](TimePoint on, std::optional<TimePoint> off) {
    return std::max(std::min(off.value_or(now), now) - std::max(on, from), Duration{0});
  };
  const Duration most = since_then(span.on_earliest, span.off_latest);
  rises_.add_light(most);
  if (light_->wanted) record_.exposure_asked += now - from;
  record_.exposure_most += most;
  if (span.on_latest) record_.exposure_least += since_then(*span.on_latest, span.off_earliest);
  record_.exposure_parts = 1;
}

// Adds the rest of a light that is confirmed off, or of whose end nothing more will be known.
void ContinuousPrint::end_light() {
  if (std::exchange(light_asked_, false)) observer_.light_gone();
  note_light();
  if (light_) record_.dark_confirmed = record_.dark_confirmed && light_->span.off_latest;
  light_.reset();
}

void ContinuousPrint::report_slice(bool complete) {
  note_light();
  record_.complete = complete && !plan_->dry;
  record_.frames = frames_->take_figures();
  record_.mask_time = record_.frames.longest_cut;
  record_.area_mm2 = frames_->take_lit_pixels() * plan_->pixel_area_mm2;
  observer_.layer_done(record_);
}

void ContinuousPrint::turn_light_off() {
  machine_.projector().light_off();
  if (frames_) frames_->stop();
  // A light-on command that was sent without this process having been informed.
  const std::optional<LightSpan> sent =
      light_asked_ && !light_ ? machine_.projector().last_light() : std::nullopt;
  if (sent) light_ = Light{*sent, sent->on_earliest};
  note_light();
  if (light_) light_->wanted = false;
  machine_.projector().when_dark([this] { is_dark(); });
}

void ContinuousPrint::is_dark() {
  end_light();
  handle(ContinuousEvent::LightIsOff);
}

void ContinuousPrint::finish() {
  const PrintOutcome outcome = !reason_.empty() ? PrintOutcome::Failed
                               : canceled_      ? PrintOutcome::Canceled
                                                : layers_outcome_;
  end_light();
  if (frames_ && record_.exposure_parts > 0) report_slice(record_.complete);
  frames_.reset();
  PrintPlan plan = std::move(*plan_);
  plan_.reset();
  observer_.print_ended(outcome, reason_, std::move(plan));
}

}  // namespace contourd
