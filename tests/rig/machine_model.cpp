#include "tests/rig/machine_model.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "hw/projector_with_light_line.hpp"

namespace contourd::rig {
namespace {

using namespace std::chrono_literals;

// Time for the first answers: light off and the query of the light, three tries of a second each, and some
// warm-up.
constexpr Duration kFirstAnswers = 7s;
constexpr Pixels kWidth{16}, kHeight{12};
// Four full steps, for a motor driven in full steps.
constexpr std::int64_t kFieldPeriod = 4;

// A coarse screw for prints without a rise, so that a step is long (12.5 um) and a print takes few of them.
GpioAxisConfig axis_of(const Scenario& scenario, Nanometers contact_from) {
  GpioAxisConfig config;
  config.travel = Nanometers{5'000'000};
  config.microsteps_per_mm = scenario.steps_per_mm();
  config.top_speed = MillimetersPerSecond{10};
  config.acceleration = MillimetersPerSecondSquared{50};
  if (scenario.backlash) config.backlash = Nanometers{50'000};
  config.step.line = "17";
  config.limit_switch.line.line = "23";
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}};
  config.lid = GpioInputConfig{{"gpiochip0", "6", false}};
  config.force = ForceConfig{.input = {{"gpiochip0", "12", false}}, .contact_from = contact_from};
  if (scenario.encoder == EncoderKind::None) return config;
  config.encoder = EncoderConfig{};
  config.encoder->counts_per_mm = scenario.steps_per_mm();
  config.encoder->policy = scenario.encoder == EncoderKind::Corrects ? EncoderConfig::Policy::Correct
                                                                     : EncoderConfig::Policy::Fault;
  return config;
}

bool has_line(LightKind kind) {
  return kind != LightKind::Serial;
}
bool has_projector(LightKind kind) {
  return kind != LightKind::Line;
}
bool switches_light(LightKind kind) {
  return kind == LightKind::Serial || kind == LightKind::SerialAndLine;
}

}  // namespace

MachineModel::MachineModel(const Scenario& scenario)
    : plant(axis_of(scenario, kContactFrom)),
      loop(plant.clock),
      screen(plant.clock, loop, kWidth, kHeight),
      kind_(scenario.light),
      table_(table_of(scenario.projector, switches_light(kind_))),
      light_(*this),
      axis_(*this),
      no_projector_(loop),
      model_(std::make_unique<ProjectorModel>(plant.clock, scenario.projector, switches_light(kind_),
                                              scenario.line, scenario.seed)) {
  plant.loop = &loop;
  plant.loop_is_held_up = [this] { return loop.held_up(); };
  plant.motor = std::llround(2 * scenario.steps_per_mm());
  // GpioAxis assumes the pull-in speed of homing's end. The motor's speed is not known to the step: while
  // braking, four steps earlier it was faster by two fifths.
  plant.pull_in = 1.4 * plant.config.homing_speed.count() / 2 * scenario.steps_per_mm();
  plant.stands_after_s += 0.4 / plant.pull_in;
  plant.overrun = 1 + kFieldPeriod;
  model_->changed = screen.changed = [this] { changed(); };
  if (scenario.backlash) plant.slack = std::llround(in_mm(plant.config.backlash) * scenario.steps_per_mm());
  plant.on_event = [this] { tell(plant.events.back()); };
  plant.build();
  if (has_line(kind_)) open_line();
  if (has_projector(kind_)) open_adapter();
  combine();
  projector().light_off();
  if (serial_) serial_->power_off_if_on();
}

MachineModel::~MachineModel() {
  make_safe(*this);
  plant.axis->set_light_cutoff(nullptr);
}

Projector& MachineModel::present_projector() {
  if (combined_) return *combined_;
  if (serial_) return *serial_;
  return no_projector_;
}

void MachineModel::combine() {
  if (combined_ || !has_line(kind_)) return;
  if (serial_) {
    LightLine& line = line_ ? static_cast<LightLine&>(*line_) : no_line_;
    combined_ = std::make_unique<ProjectorWithLightLine>(*serial_, line, loop);
  } else if (line_ && !has_projector(kind_)) {
    combined_ = std::make_unique<LightLineProjector>(*line_, loop, 1s);
  }
}

void MachineModel::open_adapter() {
  port_ = std::make_shared<LineEnd>(*model_, [this] {
    const Duration time = std::exchange(write_takes_, Duration{0});
    if (time > Duration{0}) loop.hold_up_here(time, [this] { turn(); });
  });
  found_at_ = loop.now();
  heard_ = false;
  model_->answers = [this, weak = std::weak_ptr(port_)](const std::string& bytes) {
    loop.post([this, weak, bytes] {
      heard_ = true;
      if (const auto port = weak.lock()) port->bring(bytes);
    });
  };
  serial_ = std::make_unique<SerialProjector>(*port_, loop, table_);
  serial_->on_event([this](const MachineEvent& event) { tell(event); });
  serial_->may_warm_up();
}

// Opens the light line in the dark state.
void MachineModel::open_line() {
  auto output = std::make_unique<testing::PlantOutput>();
  output_ = output.get();
  output_->level = line_level_;
  output_->changed = [this](bool active) {
    line_level_ = active;
    changed();
  };
  static_cast<void>(output_->set(false));
  line_ = std::make_unique<GpioLightLine>(std::move(output), "line 24 of gpiochip0", loop);
  line_->on_event([this](const MachineEvent& event) { tell(event); });
  plant.axis->set_light_cutoff(line_.get());
}

void MachineModel::unplug_adapter(Duration time) {
  if (!port_ || !port_->plugged()) return;
  adapter_there_ = false;
  port_->unplug();
  plug_ = plant.clock.call_after(time, [this] { adapter_there_ = true; });
  loop.post([weak = std::weak_ptr(port_)] {
    if (const auto port = weak.lock()) port->tell_loss();
  });
}

// Closes lost devices and looks for them, as RealMachine does.
void MachineModel::search() {
  const bool line_lost = has_line(kind_) && (!line_ || !line_->refusal().empty());
  const bool serial_lost = serial_ && serial_->lost();
  if (line_lost) {
    if (line_) no_line_.lose(line_->refusal());
    projector().light_off();
    combined_.reset();
    plant.axis->set_light_cutoff(nullptr);
    line_.reset();
    if (!line_refuses_) {
      open_line();
      no_line_.lose("");
    }
  }
  const bool projector_came = serial_lost && adapter_there_;
  if (projector_came) {
    combined_.reset();
    serial_.reset();
    open_adapter();
  }
  combine();
  projector().light_off();
  if (projector_came) serial_->power_off_if_on();
  const bool missing = (has_line(kind_) && !line_) || (serial_ && serial_->lost());
  if (missing) search_ = loop.call_after(5s, [this] { search(); });
  if (projector_came || (line_lost && line_))
    tell({.kind = MachineEvent::Kind::Recovery, .what = "found a missing device"});
}

void MachineModel::lose_display(Duration time) {
  if (!screen.there()) return;
  screen.unplug();
  screen_timer_ = plant.clock.call_after(time, [this] { screen.plug(); });
  loop.post([this] {
    tell({.kind = MachineEvent::Kind::Interlock, .what = "the display on HDMI-A-1 was unplugged"});
  });
}

void MachineModel::refuse_line(Duration time) {
  if (!line_) return;
  line_refuses_ = output_->refuses = true;
  line_timer_ = plant.clock.call_after(time, [this] {
    line_refuses_ = false;
    if (line_) output_->refuses = false;
  });
}

void MachineModel::heal() {
  model_->heal();
  adapter_there_ = true;
  line_refuses_ = false;
  if (line_) output_->refuses = false;
  if (!screen.there()) screen.plug();
  write_takes_ = Duration{0};
}

void MachineModel::tell(const MachineEvent& event) {
  const bool line_lost = line_ && !line_->refusal().empty();
  if ((serial_ && serial_->lost()) || line_lost) search_ = loop.call_after(500ms, [this] { search(); });
  if (on_event_) on_event_(event);
}

std::string MachineModel::why_not_ready() const {
  if (!no_line_.refusal().empty() || (line_ && !line_->refusal().empty())) return "the light may be on";
  if (serial_ && serial_->lost()) return "the projector is lost";
  if (serial_ && !serial_->why_not_ready().empty()) return "the light may be on";
  if (!screen.there()) return "the display is unplugged";
  if (plant.axis->lost()) return "the axis is lost";
  const std::vector<std::string> reasons = plant.axis->why_not_ready();
  return reasons.empty() ? "" : reasons.front();
}

bool MachineModel::light_off_unconfirmed() const {
  if (!no_line_.refusal().empty() || (serial_ && (!heard_ || loop.now() < found_at_ + kFirstAnswers)))
    return true;
  const Projector* present = combined_ ? combined_.get() : serial_.get();
  return present != nullptr && !present->light_off_unconfirmed().empty();
}

bool MachineModel::light_off_due() const {
  const bool reached = serial_ && !serial_->lost() && port_->plugged() && !loop.held_up();
  return reached && table_.switches_light() && !serial_->light_off_unconfirmed().empty();
}

// A light off that is refused is followed by the question whether the projector is on, and that by a pause of
// one timeout.
Duration MachineModel::longest_light_off_pause() const {
  const int timeouts = 1 + (1 + table_.retries) + 1;
  // A command and its reply are on the wire for 20 ms.
  return timeouts * (table_.power_off.timeout + table_.gap + 20ms);
}

bool MachineModel::lit() const {
  if (has_line(kind_) && !line_level_) return false;
  return !has_projector(kind_) || model_->lit();
}

Nanometers MachineModel::plate() const {
  return Nanometers{std::llround(1e6 / plant.config.microsteps_per_mm)} * (plant.plate() - plant.limit.at);
}

void MachineModel::turn() {
  int turns = 0;
  plant.run([&turns] { return turns++ > 0; });
}

}  // namespace contourd::rig
