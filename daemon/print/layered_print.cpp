#include "daemon/print/layered_print.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/print/mask_cost.hpp"
#include "hw/z_axis.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The distance by which the plate moves up in a pause, so that the user can look at the part.
constexpr Nanometers kLook{30'000'000};

constexpr Duration kPresentDeadline = 5s;  // for a display that does not answer at all

// The plate is up, or moves up, so that the user can look at the part.
constexpr EnumSet<LayeredState> kUp{LayeredState::Raising, LayeredState::Paused};
// The print ends by itself.
constexpr EnumSet<LayeredState> kOver{LayeredState::Parking, LayeredState::Ending};

}  // namespace

LayeredPrint::LayeredPrint(Machine& machine, Clock& clock, PrintObserver& observer)
    : MachineProcess(machine, clock, layered_table()), observer_(observer) {
  make_safe(machine_);
}

LayeredPrint::~LayeredPrint() {
  machine_.z_axis().on_force({});
  make_machine_safe();
  machine_.projector().power_off();
}

const PrintState& LayeredPrint::state() const {
  return layered_print_states()[static_cast<std::size_t>(layered_state())];
}

std::int32_t LayeredPrint::layer() const {
  expects(under_way(), "a print is under way");
  return layer_;
}

Nanometers LayeredPrint::layer_top() const {
  expects(under_way(), "a print is under way");
  return bottom_ + thickness_;
}

Nanometers LayeredPrint::layer_thickness() const {
  expects(under_way(), "a print is under way");
  return thickness_;
}

bool LayeredPrint::shows_mask() const {
  return is_in({LayeredState::Igniting, LayeredState::Exposing});
}

void LayeredPrint::start(PrintPlan plan) {
  expects(!under_way(), "no print is under way");
  expects(plan.layers.thickness_at(Nanometers{}) && plan.exposure, "a print has a layer and its exposure");
  const ResumePoint from = plan.resume.value_or(ResumePoint{});
  begin(std::move(plan), from.layer, from.bottom);
  pressed_shape_mm4_ = plan_->plate_shape_mm4;
  handle(LayeredEvent::Started);
}

void LayeredPrint::go_on(PrintPlan plan, std::int32_t layer, Nanometers bottom) {
  expects(!under_way(), "no print is under way");
  expects(plan.layers.thickness_at(bottom) && plan.exposure, "a print has a layer and its exposure");
  begin(std::move(plan), layer, bottom);
  if (plan_->pressed) begin_press_shape();
  handle(LayeredEvent::WentOn);
}

void LayeredPrint::begin(PrintPlan plan, std::int32_t layer, Nanometers bottom) {
  plan_ = std::move(plan);
  layer_ = layer;
  pause_wanted_ = resume_wanted_ = canceled_ = false;
  planned_pause_.reset();
  failure_.clear();
  interruption_.clear();
  new_settings_.reset();
  new_exclusions_.clear();
  peels_.reset();
  if (plan_->force) peels_.emplace(plan_->force->least_peel_area_mm2);
  begin_layer(bottom);
  expect_layers();
  if (layer_ > 0 && rise_begins_at(*plan_, bottom)) take_layer_beneath();
}

// Makes the layer beneath the one under way, which has had its light before a power cut. What follows is a
// rise.
void LayeredPrint::take_layer_beneath() {
  --layer_;
  thickness_ = plan_->expected_layers[static_cast<std::size_t>(layer_)];
  begin_layer(bottom_ - thickness_);
  layer_exposed_ = layer_reported_ = true;
}

void LayeredPrint::expect_layers() {
  left_after_ = durations_to_end(*plan_, machine_.z_axis());
}

void LayeredPrint::set(const PrintSettings& settings) {
  expects(under_way(), "a print is under way");
  const PrintSettings of_layer{plan_->exposure_percent, plan_->motion};
  take_settings(settings);
  expect_layers();
  take_settings(of_layer);
  new_settings_ = settings;
}

void LayeredPrint::change(const ChangedRises& rises) {
  expects(under_way() && plan_->rises, "a print with rises is under way");
  take_change(rises, *plan_->rises);
  expect_layers();
}

std::string_view LayeredPrint::why_fixed(std::string_view what) const {
  expects(under_way(), "a print is under way");
  return plan_->rises && what == "exposure" ? kFixedExposure : "";
}

PrintSettings LayeredPrint::settings() const {
  expects(under_way(), "a print is under way");
  return new_settings_.value_or(PrintSettings{plan_->exposure_percent, plan_->motion});
}

void LayeredPrint::exclude(ExcludedCopy copy) {
  expects(under_way(), "a print is under way");
  new_exclusions_.push_back(std::move(copy));
}

void LayeredPrint::take_settings(const PrintSettings& settings) {
  plan_->exposure_percent = settings.exposure_percent;
  plan_->motion = settings.motion;
}

void LayeredPrint::begin_layer(Nanometers bottom) {
  const std::optional<Nanometers> thickness = plan_->layers.thickness_at(bottom);
  if (!thickness) throw std::logic_error("a print has no layer on top of its last");
  bottom_ = bottom;
  thickness_ = *thickness;
  layer_exposed_ = layer_reported_ = layer_peeled_ = false;
  record_ = LayerRecord{};
  record_.layer = layer_;
  record_.bottom = bottom_;
  record_.thickness = thickness_;
  record_.exposure_asked = exposure_of(*plan_, layer_, thickness_);
}

void LayeredPrint::next_layer() {
  ++layer_;
  if (new_settings_) take_settings(*std::exchange(new_settings_, std::nullopt));
  for (const ExcludedCopy& copy : std::exchange(new_exclusions_, {}))
    leave_dark(*plan_, copy, layer_, above_mask());
  begin_layer(layer_top());
}

// Returns the lowest height of this layer that is above the cut of its mask: masks are cut at measured
// heights, so that one may lie above the planned top of its layer.
Nanometers LayeredPrint::above_mask() const {
  return std::clamp(record_.mask_height + Nanometers{1}, bottom_, bottom_ + thickness_);
}

void LayeredPrint::pause() {
  planned_pause_.reset();
  resume_wanted_ = false;
  pause_wanted_ = !is_in(kUp) && !is_in(LayeredState::Held);
}

void LayeredPrint::pause_at(PausePoint point) {
  expects(under_way(), "a print is under way");
  planned_pause_ = point;
}

std::string_view LayeredPrint::next_pause() const {
  expects(under_way(), "a print is under way");
  switch (layered_state()) {
    case LayeredState::Idle:
    case LayeredState::Halting:
    case LayeredState::Parking:
    case LayeredState::Ending:
      return "";
    case LayeredState::Raising:
    case LayeredState::Paused:
    case LayeredState::Held:
      return "now";
    case LayeredState::WarmingUp:
    case LayeredState::Homing:
      return "before the first layer";
    default:
      break;
  }
  if (canceled_) return "";
  if (is_in(LayeredState::AwaitingDark) && !has_all_light()) return "before the light goes on again";
  if (!interruption_.empty()) return "when the plate is up";
  return on_last_layer() ? "" : "after this layer";
}

void LayeredPrint::resume() {
  const bool stopped = is_in(kUp) || is_in(LayeredState::Held);
  if (!stopped || planned_pause_due()) planned_pause_.reset();
  pause_wanted_ = false;
  resume_wanted_ = is_in(LayeredState::Raising);
  interruption_.clear();
  handle(LayeredEvent::Resumed);
}

bool LayeredPrint::can_resume() const {
  return is_in(kUp) || is_in(LayeredState::Held) || pause_wanted_ || planned_pause_;
}

bool LayeredPrint::can_cancel() const {
  expects(under_way(), "a print is under way");
  return canceled_ || !is_in(kOver);
}

std::string_view LayeredPrint::why_it_ends() const {
  expects(under_way(), "a print is under way");
  if (canceled_) return "the print is being cancelled";
  if (is_in(LayeredState::Parking)) return "all layers are printed, the plate goes up";
  if (is_in(LayeredState::Ending)) return "the print is over";
  return "the last layer is under way, the print ends by itself";
}

void LayeredPrint::interrupt(const std::string& what) {
  if (!under_way()) return;
  // The exposure is over, and only the timer's callback has not run yet.
  if (is_in(LayeredState::Exposing) && clock_.now() >= light_end_ && !light_went_off())
    handle(LayeredEvent::WaitOver);
  const bool is_new = interruption_.find(what) == std::string::npos;
  if (is_new) interruption_ += (interruption_.empty() ? "" : "; ") + what;
  resume_wanted_ = false;
  pause_wanted_ = !is_in(kUp) && !is_in(kOver) && !is_in(LayeredState::Halting);
  handle(LayeredEvent::Interrupted);
  if (is_in(LayeredState::Held)) pause_wanted_ = false;
  if (is_new && under_way()) observer_.interrupted(what);
}

void LayeredPrint::cancel() {
  if (!answers(LayeredEvent::Canceled)) return;
  canceled_ = true;
  handle(LayeredEvent::Canceled);
}

void LayeredPrint::fail(const std::string& reason) {
  if (!answers(LayeredEvent::Failed)) return;
  failure_ = reason;
  handle(LayeredEvent::Failed);
}

// A picture of many in an exposure is no news to the observer, whose work would delay the light's end.
void LayeredPrint::performed(LayeredEvent event) {
  if (event == LayeredEvent::PictureDue) return;
  if (is_in(LayeredState::Showing)) observer_.light_due();
  observer_.state_changed(state());
  // A pause that ends at once is none: its height must not be trusted after a power cut.
  if (is_in(LayeredState::Paused) && resume_wanted_) return;
  if (const std::optional<PrintPhase> phase = this->phase()) observer_.progressed(progress(*phase));
}

// Returns the phase that begins with the state. Until a print that goes on moves its plate, it is in the
// phase in which it was cut.
std::optional<PrintPhase> LayeredPrint::phase() const {
  if (!plan_ || !plan_->resume) return phase_of(layered_state());
  if (is_in(LayeredState::Homing)) return PrintPhase::Lifting;
  return is_in(LayeredState::WarmingUp) ? std::nullopt : phase_of(layered_state());
}

// Returns the progress of a phase that has just begun. A cancelled print only moves up.
PrintProgress LayeredPrint::progress(PrintPhase phase) const {
  if (canceled_) phase = PrintPhase::Parking;
  PrintProgress progress{
      phase, layer_, bottom_, thickness_, record_.exposure_asked, record_.exposure_most, layer_exposed_, {}};
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) return progress;
  PrintProgress::Heights plate{*height, *height};
  const Nanometers highest = machine_.z_axis().travel();
  if (phase == PrintPhase::Lowering) plate.least = std::min(layer_top(), *height);
  if (phase == PrintPhase::Lifting) plate.most = std::min(*height + plan_->motion.whole_lift(), highest);
  if (phase == PrintPhase::Raising) plate.most = std::min(*height + kLook, highest);
  if (phase == PrintPhase::Parking) plate.most = highest;
  progress.plate = plate;
  return progress;
}

// An effect that throws while the print is ending only ends it without waiting any longer.
void LayeredPrint::effect_threw(const std::string& what) {
  if (!under_way()) throw;
  is_in(LayeredState::Ending) ? handle(LayeredEvent::GaveUp) : fail(what);
}

void LayeredPrint::settled() {
  if (!under_way() && plan_) finish();
  if (is_in(LayeredState::Paused) && std::exchange(resume_wanted_, false)) handle(LayeredEvent::Resumed);
}

void LayeredPrint::perform(LayeredEffect effect) {
  switch (effect) {
    case LayeredEffect::LightOff:
      return turn_light_off();
    case LayeredEffect::BlackNow:
      return machine_.display().black_now();
    case LayeredEffect::AbortAxis:
      return machine_.z_axis().abort();
    case LayeredEffect::StopAxis:
      return stop_axis();
    case LayeredEffect::PowerOn:
      estimate(plan_->warm_up);
      return power_on_projector();
    case LayeredEffect::PowerOff:
      return machine_.projector().power_off();
    case LayeredEffect::Home:
      return plan_->resume ? find_plate() : home();
    case LayeredEffect::LowerToLayer:
      return lower();
    case LayeredEffect::WaitToSettle:
      take_press_shape();
      record_.settling = settling_duration(*plan_, pressed_shape_mm4_, thickness_);
      wait(record_.settling);
      // The plate is at rest in the dark, and has to wait anyway.
      if (plan_->undersides) plan_->undersides->look_ahead(static_cast<std::size_t>(layer_));
      return;
    case LayeredEffect::ShowMask:
      return show_mask();
    case LayeredEffect::LightOn:
      return expose();
    case LayeredEffect::TimeExposure:
      return time_exposure();
    case LayeredEffect::ShowPicture:
      return show_picture();
    case LayeredEffect::ShowBlack:
      return show_black();
    case LayeredEffect::AwaitDark:
      if (is_in(LayeredState::Ending))
        give_up_within(kDarkDeadline);
      else
        expect_within(kProjectorDeadline, "the projector to confirm that its light is off");
      return expect_darkness();
    case LayeredEffect::RecordLayer:
      return record_layer();
    case LayeredEffect::WaitToRest:
      return wait(plan_->motion.after_light());
    case LayeredEffect::Lift:
      return lift();
    case LayeredEffect::NextLayer:
      return next_layer();
    case LayeredEffect::RaiseForALook:
      if (planned_pause_due()) planned_pause_.reset();
      pause_wanted_ = false;
      return move_to({std::min(current_height() + kLook, machine_.z_axis().travel()), plan_->travel_speed});
    case LayeredEffect::Park:
      return move_to({machine_.z_axis().travel(), plan_->travel_speed});
    case LayeredEffect::Finish:
      return;  // handle() finishes the print after all other effects
  }
}

void LayeredPrint::wait(Duration duration) {
  estimate(duration);
  handle_at(*estimated_end_, LayeredEvent::WaitOver);
}

Nanometers LayeredPrint::current_height() const {
  const std::optional<Nanometers> height = machine_.z_axis().height();
  if (!height) throw std::runtime_error("the plate's position is unknown");
  return *height;
}

void LayeredPrint::show_black() {
  expect_within(kPresentDeadline, "the display to show black");
  machine_.display().black(while_in_state<std::optional<TimePoint>>([this](std::optional<TimePoint> at) {
    if (at) return handle(LayeredEvent::ScreenBlack);
    display_lost();
  }));
}

// Makes the position known for a print that goes on after a power cut, and peels off what may stick to the
// film. The plate does not move down before its position is known.
void LayeredPrint::find_plate() {
  ZAxis& axis = machine_.z_axis();
  const std::optional<Nanometers> assumed = std::exchange(plan_->resume->height, std::nullopt);
  if (assumed && !axis.height()) axis.assume_height(*assumed);
  const MillimetersPerSecond speed = plan_->motion.lift_speed;
  const Nanometers lift = std::min(plan_->motion.whole_lift(), axis.travel());
  expect_move(lift, speed, "the plate to rise");
  estimate(axis.move_duration(lift, speed));
  if (const std::optional<Nanometers> height = axis.height())
    return axis.move_to(std::min(*height + lift, axis.travel()), speed,
                        while_in_state<MoveResult>([this](MoveResult result) {
                          if (result == MoveResult::Reached) return handle(LayeredEvent::Homed);
                          fail(fmt::format("the plate did not rise: {}", name_of(result)));
                        }));
  if (!axis.homes_upwards())
    throw std::runtime_error("the plate's position was lost, and a part that hangs on it forbids homing");
  axis.raise(lift, speed, while_in_state<MoveResult>([this](MoveResult result) {
               if (result == MoveResult::Reached || result == MoveResult::AtSwitch) return home();
               fail(fmt::format("the plate did not rise: {}", name_of(result)));
             }));
}

void LayeredPrint::home() {
  expect_homing(plan_->homing_speed);
  estimate(homing_duration());
  machine_.z_axis().home(while_in_state<HomingResult>([this](HomingResult result) {
    if (result == HomingResult::Homed) return handle(LayeredEvent::Homed);
    fail(fmt::format("homing failed: {}", name_of(result)));
  }));
}

void LayeredPrint::move_to(Stage first, std::optional<Stage> second) {
  ZAxis& axis = machine_.z_axis();
  const Nanometers distance = first.target - current_height();
  if (second && second->target == first.target) second.reset();
  second_stage_ = second;
  expect_move(distance, first.speed, "a move to end");
  Duration whole = axis.move_duration(distance, first.speed);
  if (second) whole += axis.move_duration(second->target - first.target, second->speed);
  estimate(whole);
  axis.move_to(first.target, first.speed, [this, move_state = layered_state()](MoveResult result) {
    // A move that was stopped ends in Halting or Braking instead of the state in which it began.
    if (is_in({move_state, LayeredState::Halting, LayeredState::Braking})) after_move(move_state, result);
  });
}

// Lowers the plate to the layer's height, slowly at the end, where it presses out resin.
void LayeredPrint::lower() {
  const LayerMotion& motion = plan_->motion;
  const MillimetersPerSecond speed = layer_ == 0 ? plan_->travel_speed : motion.retract_speed;
  const Nanometers slow_from = std::min(layer_top() + motion.slow_retract, current_height());
  machine_.z_axis().expect_contact_at(layer_top());
  if (motion.slow_retract == Nanometers{} || slow_from <= layer_top()) return move_to({layer_top(), speed});
  move_to({slow_from, speed}, Stage{layer_top(), motion.slow_retract_speed});
}

// The plate rests where it met resistance, and the print is in the dark.
void LayeredPrint::meet_resistance() {
  const ForcePolicy policy = plan_->force.value_or(ForcePolicy{});
  const std::string what = describe_resistance(current_height(), layer_top(), policy);
  if (policy.resistance_fails) return fail(what);
  interrupt(what);
  handle(LayeredEvent::MoveEnded);
}

// Peels the layer off, and rises on so that fresh resin flows in.
void LayeredPrint::lift() {
  watch_peel();
  const LayerMotion& motion = plan_->motion;
  const Nanometers from = current_height(), highest = machine_.z_axis().travel();
  move_to({std::min(from + motion.lift, highest), motion.lift_speed},
          Stage{std::min(from + motion.whole_lift(), highest), motion.second_lift_speed});
}

// Watches the force of a lift that peels off a layer with all its light.
void LayeredPrint::watch_peel() {
  ZAxis& axis = machine_.z_axis();
  const std::optional<bool> force = axis.force();
  let_go_ = false;
  peel_begun_.reset();
  if (!peels_ || !force || !layer_exposed_ || plan_->dry || std::exchange(layer_peeled_, true)) return;
  peel_begun_ = clock_.now();
  peels_->lift(current_height(), *force);
  axis.on_force(while_in_state<ForceChange>([this](const ForceChange& change) { take_force(change); }));
}

// Ends the slow stage of the lift when the layer has let go.
void LayeredPrint::take_force(const ForceChange& change) {
  if (!peel_begun_ || !change.height || !peels_->change(change.active, *change.height)) return;
  if (!second_stage_ || std::exchange(let_go_, true)) return;
  machine_.z_axis().stop();
}

// Reports the peel of a lift that is over, and judges it.
void LayeredPrint::judge_peel() {
  const Duration took = clock_.now() - *std::exchange(peel_begun_, std::nullopt);
  machine_.z_axis().on_force({});
  const PeelFinding finding = peels_->judge(record_.area_mm2);
  PeelRecord peel{peels_->peel().felt, peels_->peel().distance, {}, finding != PeelFinding::None};
  if (let_go_)
    peel.saved = std::max(Duration{}, lift_duration(plan_->motion, moves_of(machine_.z_axis())) - took);
  observer_.layer_peeled(layer_, peel);
  if (finding == PeelFinding::None) return;
  const std::string what =
      finding == PeelFinding::CameOff
          ? fmt::format(
                "no force was felt while layer {} of {:.0f} mm² was peeled off, although smaller "
                "layers were felt: the part has probably come off the plate and lies on the film",
                layer_ + 1, record_.area_mm2)
          : fmt::format(
                "no force was felt in the first {} lifts of at least {:g} mm²: the part does not "
                "stick to the plate, or the force line does not work",
                PeelWatch::kSilentFromStart, plan_->force->least_peel_area_mm2);
  plan_->force->pauses_without_peel ? pause_because(what) : observer_.warned(what);
}

void LayeredPrint::after_move(LayeredState move_state, MoveResult result) {
  const bool stage_over = result == MoveResult::Reached || (let_go_ && result == MoveResult::Stopped);
  if (stage_over && is_in(move_state) && second_stage_)
    return move_to(*std::exchange(second_stage_, std::nullopt));
  const bool rests = result == MoveResult::Stopped || result == MoveResult::Resistance;
  if (result == MoveResult::Resistance && is_in(LayeredState::Lowering)) return meet_resistance();
  if (result != MoveResult::Reached && !(is_in({LayeredState::Halting, LayeredState::Braking}) && rests))
    return fail(fmt::format("the plate did not arrive: {}", name_of(result)));
  if (is_in(LayeredState::Lifting) && peel_begun_) judge_peel();
  handle(LayeredEvent::MoveEnded);
}

bool LayeredPrint::rises_next() const {
  return rise_begins_at(*plan_, layer_top());
}

LayeredEvent LayeredPrint::next_due() const {
  if (canceled_) return LayeredEvent::Canceled;
  const LayeredEvent due = !has_all_light()  ? LayeredEvent::LayerUnfinished
                           : on_last_layer() ? LayeredEvent::LayersDone
                           : rises_next()    ? LayeredEvent::RiseDue
                                             : LayeredEvent::LayerDue;
  const bool nothing_to_pause = due == LayeredEvent::LayersDone && interruption_.empty();
  return (pause_wanted_ || planned_pause_due()) && !nothing_to_pause ? LayeredEvent::PauseDue : due;
}

// True if the planned pause comes after the layer under way, which has had all its light.
bool LayeredPrint::planned_pause_due() const {
  return planned_pause_ && has_all_light() && is_reached(*planned_pause_, layer_ + 1, layer_top());
}

// Interrupts the print; if the machine has reported the cause already, keeps its more detailed text.
void LayeredPrint::display_lost() {
  interrupt(interruption_.empty() ? "the display was lost" : interruption_);
}

// --- Light

// The exposure does not wait for the reply to light on, and may be over by then.
void LayeredPrint::expose() {
  light_.reset();
  if (plan_->dry) {
    light_end_ = clock_.now() + exposure_left();
    return handle_at(clock_.now(), LayeredEvent::LightOnSent);
  }
  light_on_for(exposure_left(), [this](ProjectorReply reply, const std::string& problem) {
    reply == ProjectorReply::Refused ? fail(problem) : interrupt(problem);
  });
}

void LayeredPrint::time_exposure() {
  estimated_end_ = light_end_;
  wait_ = clock_.call_at(light_end_, [this] {
    if (light_went_off()) return interrupt("the light went off before its exposure was over");
    handle(LayeredEvent::WaitOver);
  });
  await_picture();
}

// Requests the next picture half a refresh before it is due, so that it appears at the refresh that is
// nearest.
void LayeredPrint::await_picture() {
  const std::optional<Duration> due = plan_->split ? plan_->split->next_due() : std::nullopt;
  if (!due) return;
  picture_ = clock_.call_at(light_end_ - record_.exposure_asked + *due - machine_.display().frame() / 2,
                            [this] { handle(LayeredEvent::PictureDue); });
}

void LayeredPrint::show_picture() {
  const Mask& picture = plan_->split->next();
  shown_.mask = &picture;
  ++shown_.number;
  machine_.display().show(
      picture, while_in_state<std::optional<TimePoint>>([this](std::optional<TimePoint> at) {
        if (!at) return display_lost();
        const Duration lit = *at - (light_end_ - record_.exposure_asked);
        record_.late_picture = std::max(record_.late_picture, lit - *plan_->split->next_due());
        plan_->split->shown(lit);
        draw_picture();
      }));
}

// Draws the next picture in several turns of the event loop, so that light off need not wait for it.
void LayeredPrint::draw_picture() {
  if (!plan_->split->draw_some()) return await_picture();
  picture_ = clock_.call_at(clock_.now(), [this] { draw_picture(); });
}

void LayeredPrint::turn_light_off() {
  machine_.projector().light_off();
  if (light_asked_ && !light_) {
    light_ = machine_.projector().last_light();
    note_late_picture();
  }
  expect_darkness();
}

// Records the light that went off while a picture was due that was not on the screen yet.
void LayeredPrint::note_late_picture() {
  const std::optional<Duration> due = plan_->split ? plan_->split->next_due() : std::nullopt;
  if (!due || !light_) return;
  const Duration lit = record_.exposure_most + (clock_.now() - light_->on_earliest);
  record_.late_picture = std::max(record_.late_picture, lit - *due);
}

// True if something else turned the light off before the end of the exposure, so that the layer lacks light.
bool LayeredPrint::light_went_off() const {
  if (plan_->dry) return false;
  const std::optional<LightSpan> light = machine_.projector().last_light();
  return light && light->off_earliest && *light->off_earliest < light_end_;
}

void LayeredPrint::expect_darkness() {
  machine_.projector().when_dark([this] { is_dark(); });
}

void LayeredPrint::is_dark() {
  count_light();
  if (layer_exposed_ && !layer_reported_) report_layer();
  handle(is_in(LayeredState::AwaitingDark) ? next_due() : LayeredEvent::LightIsOff);
}

// Adds the light that has just gone off to the layer's record; if it is not confirmed off, adds its time so
// far. A projector that was lost in the meantime, and another that was found, know nothing of this light: it
// may still be on.
void LayeredPrint::count_light() {
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

bool LayeredPrint::has_all_light() const {
  return layer_exposed_ || (record_.exposure_parts > 0 && exposure_left() < kShortestExposure);
}

// Reports the layer to the observer. Called in the dark, since counting the mask's loops takes time.
void LayeredPrint::report_layer() {
  layer_reported_ = true;
  record_.complete = layer_exposed_ && !plan_->dry;
  if (layer_exposed_) {
    record_.loops = plan_->engine->count_loops();
    if (plan_->pressed) begin_press_shape();
  }
  observer_.layer_done(record_);
  if (layer_exposed_) judge_exposure();
}

// Begins to compute the factor of the face with the last mask, which takes milliseconds, on a thread of its
// own. The engine makes no mask before take_press_shape().
void LayeredPrint::begin_press_shape() {
  const Mask& mask = plan_->engine->coverage();
  const Micrometers pitch{1000 * std::sqrt(plan_->pixel_area_mm2)};
  // Without a free thread, the factor is computed when it is taken.
  next_shape_ = std::async(std::launch::async | std::launch::deferred,
                           [&mask, pitch] { return press_shape_mm4(mask, pitch); });
  if (clock_.skips_waiting()) take_press_shape();
}

// Takes the factor over. The plate has been lifted and lowered since it was begun.
void LayeredPrint::take_press_shape() {
  if (next_shape_.valid()) pressed_shape_mm4_ = next_shape_.get();
}

// Requests a pause if the layer's exposure is less certain than its resin tolerates.
void LayeredPrint::judge_exposure() {
  const Duration apart = record_.exposure_most - record_.exposure_least;
  if (apart <= plan_->tolerance.bounds || plan_->tolerance.policy == ExposureTolerance::Policy::Warn) return;
  const std::string what = fmt::format(
      "the exposure of layer {} is uncertain by {:.0f} ms, but its resin tolerates only {:.0f} ms",
      layer_ + 1, std::chrono::duration<double, std::milli>(apart).count(),
      std::chrono::duration<double, std::milli>(plan_->tolerance.bounds).count());
  pause_because(what);
}

// Requests a pause, for which the plate is up already or is lifted next.
void LayeredPrint::pause_because(const std::string& what) {
  interruption_ += (interruption_.empty() ? "" : "; ") + what;
  resume_wanted_ = false;
  pause_wanted_ = true;
  observer_.interrupted(what);
}

void LayeredPrint::show_mask() {
  // The mask belongs to the plate's actual height, not to its planned height. The new layer lies below the
  // plate's height and is cut at its middle. Finished layers belong to their numbers: none is left out, and
  // none is shown twice, however far the plate is from its planned height.
  record_.plate_height = current_height();
  const auto models = plan_->engine->models();
  const bool is_finished = !models.empty() && models.front().has_finished_layers();
  record_.mask_height = (is_finished ? layer_top() : record_.plate_height) - thickness_ / 2;
  shown_.mask = nullptr;
  const auto start = MaskBudget::Clock::now();
  MaskBudget budget(start + plan_->mask_budget);
  const Mask* mask = plan_->engine->mask_within(record_.mask_height, budget);
  const Mask* light = &plan_->engine->coverage();
  if (mask != nullptr && plan_->undersides) {
    const auto layer = static_cast<std::size_t>(layer_);
    mask = &plan_->undersides->mask(layer, *light);
    light = &plan_->undersides->light();
    record_.undersides_found = plan_->undersides->are_found(layer);
  }
  record_.mask_time = MaskBudget::Clock::now() - start;
  if (mask == nullptr) return abandon_mask(budget);
  record_.area_mm2 = light->lit_area() * plan_->pixel_area_mm2;
  record_.intersecting_facets = plan_->engine->intersecting_facets();
  record_.cracks = plan_->engine->cracks();
  if (plan_->split) {
    mask = &plan_->split->begin(*mask,
                                {record_.exposure_asked, record_.exposure_most, machine_.display().frame()});
    record_.pictures = plan_->split->pictures();
    record_.light_error = plan_->split->light_error();
  }
  shown_ = {mask, shown_.number + 1, plan_->job, layer_, record_.mask_height};
  expect_within(kPresentDeadline, "the display to show the mask");
  machine_.display().show(*mask,
                          while_in_state<std::optional<TimePoint>>([this](std::optional<TimePoint> at) {
                            if (!at) return display_lost();
                            record_.shown_at = *at;
                            handle(LayeredEvent::MaskShown);
                          }));
}

// Interrupts the print because its mask exceeded the budget. The screen is black and stays so. The
// interruption follows in the event loop's next turn, since the current turn has been long already.
void LayeredPrint::abandon_mask(const MaskBudget& spent) {
  const std::string what =
      fmt::format("the mask at {:.3f} mm was abandoned because it exceeded mask_budget_ms, {:.0f} ms: {}",
                  to_millimeters(record_.mask_height).count(),
                  std::chrono::duration<double, std::milli>(plan_->mask_budget).count(),
                  describe_mask_cost(*plan_->engine, spent, record_.mask_time));
  wait_ = clock_.call_at(clock_.now(), [this, what] { interrupt(what); });
}

void LayeredPrint::record_layer() {
  if (layer_exposed_) return;
  layer_exposed_ = true;
  if (!light_asked_ && !layer_reported_) report_layer();
}

void LayeredPrint::finish() {
  const PrintOutcome outcome = !failure_.empty() ? PrintOutcome::Failed
                               : canceled_       ? PrintOutcome::Canceled
                                                 : PrintOutcome::Done;
  count_light();
  if (record_.exposure_parts > 0 && !layer_reported_) report_layer();
  take_press_shape();
  if (plan_->rises) {  // what follows goes on with what was changed since the last layer began
    if (new_settings_) take_settings(*new_settings_);
    for (const ExcludedCopy& copy : new_exclusions_)
      leave_dark(*plan_, copy, layer_ + 1, above_mask());
  }
  PrintPlan plan = std::move(*plan_);
  plan_.reset();
  shown_.mask = nullptr;
  observer_.print_ended(outcome, failure_, std::move(plan));
}

// --- The time left

std::optional<Duration> LayeredPrint::state_left() const {
  expects(under_way(), "a print is under way");
  if (!estimated_end_) return std::nullopt;
  return std::max(*estimated_end_ - clock_.now(), Duration{0});
}

Duration LayeredPrint::time_left() const {
  expects(under_way(), "a print is under way");
  return state_left().value_or(Duration{0}) + left_after_state();
}

// Returns the expected duration of homing. A plate at an unknown height is assumed to be where a print parks
// it.
Duration LayeredPrint::homing_duration() const {
  const ZAxis& axis = machine_.z_axis();
  return contourd::homing_duration(*plan_, axis.height().value_or(axis.travel()), moves_of(axis));
}

Duration LayeredPrint::parking_duration(Nanometers from) const {
  const ZAxis& axis = machine_.z_axis();
  return axis.move_duration(std::max(axis.travel() - from, Nanometers{}), plan_->travel_speed);
}

Duration LayeredPrint::lowering_duration() const {
  const LayerMotion& motion = plan_->motion;
  const auto move = moves_of(machine_.z_axis());
  if (layer_ > 0) return contourd::lowering_duration(motion, thickness_, move);
  return contourd::lowering_duration(motion, plan_->home_height - layer_top(), plan_->travel_speed, move);
}

// Returns the time that the layer under way takes after the current state.
Duration LayeredPrint::left_of_layer() const {
  const Duration lift = lift_duration(plan_->motion, moves_of(machine_.z_axis()));
  const Duration light = std::max(exposure_left(), Duration{0});
  const Duration lit = light + plan_->motion.after_light() + lift;
  const Duration settling = settling_duration(*plan_, pressed_shape_mm4_, thickness_);
  const Duration whole = lowering_duration() + settling + lit;
  switch (layered_state()) {
    case LayeredState::WarmingUp:
      return homing_duration() + whole;
    case LayeredState::Held:
      return plan_->warm_up + homing_duration() + whole;
    case LayeredState::Lowering:
      return settling + lit;
    case LayeredState::Settling:
    case LayeredState::Showing:
    case LayeredState::Igniting:
      return lit;
    case LayeredState::Exposing:
    case LayeredState::Darkening:
    case LayeredState::Extinguishing:
      return plan_->motion.after_light() + lift;
    case LayeredState::Resting:
      return lift;
    default:
      return has_all_light() ? Duration{0} : whole;
  }
}

Duration LayeredPrint::left_after_state() const {
  if (is_in(kOver)) return Duration{0};
  if (canceled_) return parking_duration(machine_.z_axis().height().value_or(layer_top()));
  const std::size_t next = static_cast<std::size_t>(layer_) + 1;
  return left_of_layer() + left_after_[std::min(next, left_after_.size() - 1)];
}

}  // namespace contourd
