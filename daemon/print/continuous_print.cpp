#include "daemon/print/continuous_print.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/rise_curve.hpp"

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
  expects(!plan.rise || (plan.rise->first_layers > 0 && plan.rise->plan.points.size() > 2 &&
                         !plan.undersides && !plan.split),
          "a rise follows at least one layer, with masks as they are");
  plan_ = std::move(plan);
  planned_pause_.reset();
  canceled_ = over_ = resume_wanted_ = false;
  reason_.clear();
  interruption_.clear();
  handle(ContinuousEvent::Started);
}

// --- What the user asks for

void ContinuousPrint::pause() {
  if (layering()) return layers_.pause();
  planned_pause_.reset();
  resume_wanted_ = false;
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
}

void ContinuousPrint::exclude(ExcludedCopy copy) {
  expects(under_way(), "a print is under way");
  expects(layering(), "copies are left dark in the first layers");
  layers_.exclude(std::move(copy));
}

void ContinuousPrint::resume() {
  if (layering()) return layers_.resume();
  if (!is_in(kStopping) && !is_in(ContinuousState::Paused)) planned_pause_.reset();
  resume_wanted_ = pause_pending();
  interruption_.clear();
  handle(ContinuousEvent::Resumed);
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
  resume_wanted_ = false;
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
  return layering() ? layers_.pause_pending() : is_in(kStopping) && !ends();
}

const std::optional<PausePoint>& ContinuousPrint::planned_pause() const {
  return layering() ? layers_.planned_pause() : planned_pause_;
}

std::string_view ContinuousPrint::why_fixed(std::string_view what) const {
  expects(under_way(), "a print is under way");
  if (layering()) return layers_.why_fixed(what);
  if (what == "exposure") return LayeredPrint::kFixedExposure;
  return what == "copies" ? "a continuous print leaves copies dark in its first layers only" : "";
}

PrintSettings ContinuousPrint::settings() const {
  expects(under_way(), "a print is under way");
  if (layering()) return layers_.settings();
  return {plan_->exposure_percent, plan_->motion};
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
  return layering() ? layers_.shows_mask() : is_in({ContinuousState::Igniting, ContinuousState::Rising});
}

std::optional<Duration> ContinuousPrint::state_left() const {
  if (layering()) return layers_.state_left();
  if (!estimated_end_) return std::nullopt;
  return std::max(*estimated_end_ - clock_.now(), Duration{0});
}

Duration ContinuousPrint::time_left() const {
  if (layering()) return layers_.time_left();
  const Duration left = state_left().value_or(Duration{0});
  if (is_in(kEnding)) return left;
  const Duration after = left + parking_duration();
  if (ends() || is_in(ContinuousState::Rising)) return after;
  return after + rise_left();
}

Duration ContinuousPrint::rise_left() const {
  return rise_.points.empty() ? Duration{0} : std::chrono::duration_cast<Duration>(duration(rise_));
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
  handle(outcome == PrintOutcome::Done && plan_->rise ? ContinuousEvent::LayersDone
                                                      : ContinuousEvent::LayeringEnded);
}

// --- The table

void ContinuousPrint::performed(ContinuousEvent) {
  if (is_in(ContinuousState::Layering)) return;
  if (is_in(ContinuousState::Showing)) observer_.light_due();
  observer_.state_changed(state());
  if (is_in({ContinuousState::Lowering, ContinuousState::Lifting, ContinuousState::Paused,
             ContinuousState::Parking}))
    report_progress();
}

// Reports the bounds of the plate's height until the next report.
void ContinuousPrint::report_progress() {
  PrintProgress progress;
  progress.phase = is_in(ContinuousState::Parking) ? PrintPhase::Parking : PrintPhase::Rising;
  progress.layer = record_.layer;
  progress.bottom = record_.bottom;
  progress.thickness = record_.thickness;
  const ZAxis& axis = machine_.z_axis();
  if (const std::optional<Nanometers> height = axis.height()) {
    progress.plate = {*height, *height};
    if (is_in(ContinuousState::Lowering))
      progress.plate = {std::min(*height, rise_.points.front().height),
                        std::max(*height, rise_.points.back().height)};
    if (is_in(ContinuousState::Lifting)) progress.plate->most = std::min(*height + kLookUp, axis.travel());
    if (is_in(ContinuousState::Parking)) progress.plate->most = axis.travel();
  }
  observer_.progressed(progress);
}

void ContinuousPrint::effect_threw(const std::string& what) {
  if (!under_way()) throw;
  is_in(ContinuousState::Ending) ? handle(ContinuousEvent::GaveUp) : fail(what);
}

void ContinuousPrint::settled() {
  if (is_in(ContinuousState::Idle) && plan_) finish();
  if (is_in(ContinuousState::Paused) && std::exchange(resume_wanted_, false))
    handle(ContinuousEvent::Resumed);
}

void ContinuousPrint::perform(ContinuousEffect effect) {
  switch (effect) {
    case ContinuousEffect::PrintLayers:
      return layers_.start(*std::exchange(plan_, std::nullopt));
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

// --- Moves

// Plans the rest of the rise from where the plate has come to rest in it.
void ContinuousPrint::plan_rest() {
  rise_ = rest_of(rise_, std::max(current_height(), rise_.points.front().height));
  over_ = rise_.points.empty();
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
    if (is_in(ContinuousState::Braking) && (result == MoveResult::Stopped || result == MoveResult::Reached))
      return handle(ContinuousEvent::MoveEnded);
    fail(fmt::format("the plate did not arrive: {}", name_of(result)));
  });
}

// Lowers the plate to the height from which it rises, slowly at the end, where it presses out resin.
void ContinuousPrint::lower() {
  if (!frames_) {
    frames_ = std::make_unique<RiseFrames>(machine_, clock_, *plan_);
    rise_ = plan_->rise->plan;
    planned_pause_ = layers_.planned_pause();
    record_ = {};
    record_.layer = plan_->rise->first_layers - 1;
    begin_slice(rise_.points.front().height);
  }
  const LayerMotion& motion = plan_->motion;
  const Nanometers height = rise_.points.front().height;
  const Nanometers slow_from = std::min(height + motion.slow_retract, current_height());
  const auto there = [this] { handle(ContinuousEvent::MoveEnded); };
  if (slow_from <= height) return move_to(height, motion.retract_speed, there);
  move_to(slow_from, motion.retract_speed,
          [this, height, there] { move_to(height, plan_->motion.slow_retract_speed, there); });
}

// Moves the plate up slowly, as after a layer, then further.
void ContinuousPrint::lift() {
  const Nanometers from = current_height(), highest = machine_.z_axis().travel();
  move_to(std::min(from + plan_->motion.lift, highest), plan_->motion.lift_speed, [this, from, highest] {
    move_to(std::min(from + kLookUp, highest), plan_->travel_speed,
            [this] { handle(ends() ? ContinuousEvent::RiseOver : ContinuousEvent::PauseDue); });
  });
}

// --- Light

// The light's time is the rise's, with the margin that its lateness may take; the rise itself ends the light.
void ContinuousPrint::expose() {
  const Duration most = rise_left() * 11 / 10 + kRiseMargin;
  if (plan_->dry) {
    light_end_ = clock_.now() + most;
    return handle_at(clock_.now(), ContinuousEvent::LightOnSent);
  }
  light_on_for(most, [this](ProjectorReply reply, const std::string& problem) {
    reply == ProjectorReply::Refused ? fail(problem) : interrupt(problem);
  });
}

void ContinuousPrint::rise() {
  estimate(rise_left());
  if (!plan_->dry) lit_from_ = clock_.now();
  wait_ = clock_.call_at(light_end_, [this] { interrupt("the rise takes longer than planned"); });
  frames_->run({.refreshed = [this] { refreshed(); },
                .unsafe = [this](const std::string& what) { interrupt(what); },
                .frame_over =
                    [this](FrameRecord frame) {
                      frame.layer = record_.layer;
                      observer_.frame_over(frame);
                    },
                .lit_from = lit_from_});
  machine_.z_axis().rise(rise_, [this](MoveResult result) { risen(result); });
}

void ContinuousPrint::risen(MoveResult result) {
  if (result == MoveResult::Reached || result == MoveResult::Stopped) plan_rest();
  if (is_in(ContinuousState::Braking) && (result == MoveResult::Reached || result == MoveResult::Stopped))
    return handle(ContinuousEvent::MoveEnded);
  if (result == MoveResult::Stopped)
    return stop_for("a disturbance has stopped the plate", ContinuousEvent::RiseBroken);
  if (result != MoveResult::Reached) return fail(fmt::format("the plate did not rise: {}", name_of(result)));
  handle(ContinuousEvent::MoveEnded);
}

// Reports the slices that the plate has left, and checks that the light is on.
void ContinuousPrint::refreshed() {
  const std::optional<LightSpan> light = machine_.projector().last_light();
  if (!plan_->dry && light && light->off_earliest) return interrupt("the light went off during the rise");
  const std::optional<Nanometers> height = machine_.z_axis().height();
  while (height && *height >= layer_top()) {
    const Nanometers top = layer_top();
    if (!plan_->layers.thickness_at(top)) return;
    report_slice(true);
    begin_slice(top);
    if (planned_pause_ && is_reached(*planned_pause_, record_.layer, record_.bottom)) {
      planned_pause_.reset();
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

// Adds the light since it went on, or since the last call, to the slice.
void ContinuousPrint::note_light() {
  if (!lit_from_) return;
  const Duration lit = clock_.now() - *lit_from_;
  lit_from_ = clock_.now();
  record_.exposure_asked += lit;
  record_.exposure_least += lit;
  record_.exposure_most += lit;
  record_.exposure_parts = 1;
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
  note_light();
  lit_from_.reset();
  machine_.projector().when_dark([this] { is_dark(); });
}

void ContinuousPrint::is_dark() {
  if (std::exchange(light_asked_, false)) observer_.light_gone();
  handle(ContinuousEvent::LightIsOff);
}

void ContinuousPrint::finish() {
  const PrintOutcome outcome = !reason_.empty() ? PrintOutcome::Failed
                               : canceled_      ? PrintOutcome::Canceled
                                                : layers_outcome_;
  if (std::exchange(light_asked_, false)) observer_.light_gone();
  if (frames_ && record_.exposure_parts > 0) report_slice(over_);
  frames_.reset();
  PrintPlan plan = std::move(*plan_);
  plan_.reset();
  observer_.print_ended(outcome, reason_, std::move(plan));
}

}  // namespace contourd
