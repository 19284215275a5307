#include "hw/gpio/gpio_axis.hpp"

#include <array>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/hardware_error.hpp"
#include "hw/homing_distances.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {
namespace {

const GpioAxisConfig& checked(const GpioAxisConfig& config) {
  if (const auto what = contradiction(config)) throw HardwareError(*what);
  return config;
}

AxisInputs::Lines input_lines(const GpioAxisConfig& config, const AxisLines& lines) {
  AxisInputs::Lines inputs;
  const std::array debounce{config.limit_switch.debounce,
                            config.second_switch ? config.second_switch->debounce : Duration{},
                            config.emergency_stop ? config.emergency_stop->debounce : Duration{},
                            config.lid ? config.lid->debounce : Duration{}};
  for (std::size_t i = 0; i < kAxisInputs; ++i)
    inputs.contacts[i] = {lines.inputs[i].get(), debounce[i]};
  inputs.encoder_a = lines.encoder_a.get();
  inputs.encoder_b = lines.encoder_b.get();
  inputs.encoder_index = lines.encoder_index.get();
  return inputs;
}

GpioAxis::Parts real_parts(const GpioAxisConfig& config) {
  return {take_lines(checked(config)), monotonic_now,
          [priority = config.realtime_priority](StepEngine& engine, AxisInputs& inputs) {
            return std::make_unique<RealtimeAxisThreads>(engine, inputs, priority);
          }};
}

}  // namespace

std::unique_ptr<ZAxis> open_device(const GpioAxisConfig& config, Clock& clock, DescriptorWatcher& watcher) {
  return std::make_unique<GpioAxis>(clock, watcher, config);
}

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config)
    : GpioAxis(clock, watcher, config, real_parts(config)) {}

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config, Parts parts)
    : config_(checked(config)),
      lines_(std::move(parts.lines)),
      engine_(*lines_.step, *lines_.direction, {config.pulse_width, config.direction_setup}, parts.now),
      inputs_(engine_, input_lines(config, lines_), parts.now),
      position_(config_, engine_, inputs_),
      drive_(clock, config_, lines_.enable.get(), engine_, inputs_, position_, drive_wiring()),
      approach_(drive_, position_, {drive_wiring().fail, drive_wiring().notice}),
      homing_(config_, homing_wiring()),
      interlocks_(config_, engine_, inputs_, interlocks_wiring()),
      watch_end_(watcher.when_readable(engine_.ended().descriptor(), [this] { drive_.engine_ended(); })),
      watch_inputs_(watcher.when_readable(inputs_.changes().descriptor(), [this] { inputs_changed(); })),
      threads_(parts.start_threads(engine_, inputs_)) {}

GpioAxis::~GpioAxis() {
  engine_.inhibit();
}

AxisDrive::Wiring GpioAxis::drive_wiring() {
  return {.fail = [this](const AxisFault& fault) { this->fail(fault); },
          .notice =
              [this](const std::string& what) {
                report({MachineEvent::Kind::Notice, what});
              },
          .stopped =
              [this] {
                if (homing_.under_way()) return homing_.stopped();
                end_move(MoveResult::Stopped);
              },
          .blocked = [this] { interlocks_.blocked(); },
          .take_changes = [this] { inputs_changed(); },
          .take_contact = [this] { return take_contact(); }};
}

Homing::Wiring GpioAxis::homing_wiring() {
  const auto towards_switch = [this](Nanometers distance) {
    return (config_.homes_upwards ? 1 : -1) * position_.screw().nearest_step(distance);
  };
  return {
      .forget_position = [this] { position_.homing_begins(); },
      .get_ready = [this](Homing::Call ready) { drive_.begin(std::move(ready)); },
      .switch_closed = [this] { return inputs_.active(AxisInput::LimitSwitch); },
      .run = [this, towards_switch](
                 AxisDrive::RunKind kind, Nanometers distance, MillimetersPerSecond speed,
                 Homing::Call over) { drive_.run(kind, towards_switch(distance), speed, std::move(over)); },
      .run_on = [this] { drive_.run_on(); },
      .end_run = [this] { drive_.end_run(); },
      .turning = [this] { return drive_.turning(); },
      .after = [this](Duration time, Homing::Call call) { drive_.after(time, std::move(call)); },
      .take_position = [this](TimePoint edge) { position_.take_switch(edge); },
      .know_position = [this] { position_.become_known(); },
      .approach =
          [this](Homing::Call there) {
            approach_.begin(position_.screw().nearest_step(config_.switch_height), config_.homing_speed,
                            std::move(there));
          },
      .stop = [this] { drive_.stop(); },
      .forget = [this] { drive_.forget(); }};
}

AxisInterlocks::Wiring GpioAxis::interlocks_wiring() {
  return {.fail = [this](const AxisFault& fault) { this->fail(fault); },
          .report = [this](const MachineEvent& event) { this->report(event); },
          .slow_down = [this] { drive_.slow_down(); },
          .halted_for = [this](const AxisFault& cause) { drive_.halted_for(cause); },
          .takes_contact = [this](const InputChange& change) { return takes_contact(change); },
          .where = [this] { return position_.where(); }};
}

void GpioAxis::home(std::function<void(HomingResult)> done) {
  expects(!moving(), "the axis does not move");
  homing_.begin(std::move(done));
}

void GpioAxis::move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  move_done_ = std::move(done);
  if (!position_.known()) return drive_.after(Duration{0}, [this] { end_move(MoveResult::NotHomed); });
  if (target < Nanometers{0} || target > config_.travel)
    return drive_.after(Duration{0}, [this] { end_move(MoveResult::OutsideTravel); });
  drive_.begin([this, speed, plate = position_.screw().nearest_step(target)] {
    approach_.begin(plate, speed, [this] { end_move(MoveResult::Reached); });
  });
}

void GpioAxis::nudge(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  expects(distance >= -kLongestNudge && distance <= kLongestNudge, "a nudge is short");
  move_done_ = std::move(done);
  nudged_ = true;
  position_.forget();
  drive_.begin([this, speed, steps = position_.screw().nearest_step(distance)] {
    const bool towards_switch = (steps > Microsteps{0}) == config_.homes_upwards;
    const bool at_switch = inputs_.active(AxisInput::LimitSwitch);
    if (at_switch && towards_switch) return end_move(MoveResult::AtSwitch);
    // Away from a closed switch, the switch opens on the way; otherwise its first edge halts the motor.
    drive_.run(at_switch ? AxisDrive::RunKind::BackOff : AxisDrive::RunKind::Seek, steps, speed,
               [this] { end_move(MoveResult::Reached); });
  });
}

// Handles a contact of the limit switch that has halted the motor. False unless homing or a nudge expected
// it.
bool GpioAxis::takes_contact(const InputChange& change) {
  if (homing_.in_pass()) {
    homing_.contact(change);
    return true;
  }
  if (!nudged_) return false;
  nudge_met_switch_ = true;
  if (!drive_.turning()) (void)take_contact();
  return true;
}

// Passes the contact on to homing, or ends a nudge, even if the contact did not last.
bool GpioAxis::take_contact() {
  if (homing_.under_way()) return homing_.take_contact();
  if (!nudge_met_switch_) return false;
  end_move(MoveResult::AtSwitch);
  return true;
}

void GpioAxis::stop() {
  if (homing_.under_way()) return homing_.stop();
  if (move_done_) drive_.stop();
}

void GpioAxis::abort() noexcept {
  if (!moving()) return;
  drive_.halt();
  homing_.abort();
  move_done_ = nullptr;
  nudged_ = nudge_met_switch_ = false;
}

bool GpioAxis::release() {
  expects(!moving(), "the axis does not move");
  return drive_.release();
}

void GpioAxis::inputs_changed() {
  interlocks_.take_changes();
  drive_.go_on();
}

void GpioAxis::end_move(MoveResult result) {
  drive_.forget();
  nudged_ = nudge_met_switch_ = false;
  if (const auto done = std::exchange(move_done_, nullptr)) done(result);
}

void GpioAxis::fail(const AxisFault& fault) {
  if (moving()) drive_.halt();
  // The callback may abort the motion; then there is no answer left to give.
  report({MachineEvent::Kind::Fault, fault.what, fault.needs_user});
  if (homing_.under_way()) return homing_.failed(fault.homing);
  if (move_done_) end_move(MoveResult::Fault);
}

void GpioAxis::report(const MachineEvent& event) {
  if (on_event_) on_event_(event);
}

}  // namespace contourd
