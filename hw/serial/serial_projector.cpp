#include "hw/serial/serial_projector.hpp"

#include <utility>

#include "core/contract/expects.hpp"
#include "hw/real_machine_config.hpp"
#include "hw/serial/serial_port.hpp"

namespace contourd {

std::unique_ptr<Projector> open_device(const SerialProjectorConfig& config, Clock& clock,
                                       DescriptorWatcher& watcher) {
  return std::make_unique<SerialProjector>(
      std::make_unique<SerialPort>(config.port, config.table.baud, watcher), clock, config.table,
      config.brightness);
}

SerialProjector::SerialProjector(ByteChannel& channel, Clock& clock, ProjectorTable table,
                                 std::optional<std::int32_t> brightness)
    : channel_(channel),
      clock_(clock),
      table_(std::move(table)),
      exchange_(channel, clock, table_, listener()),
      power_(exchange_, clock, table_, brightness_command(brightness), power_wiring()),
      light_(exchange_, clock, table_,
             {.warm_at = [this] { return power_.warm_at(); },
              .report = [this](MachineEvent::Kind kind, const std::string& what) { report(kind, what); }}) {}

SerialProjector::SerialProjector(std::unique_ptr<ByteChannel> channel, Clock& clock, ProjectorTable table,
                                 std::optional<std::int32_t> brightness)
    : SerialProjector(*channel, clock, std::move(table), brightness) {
  own_channel_ = std::move(channel);
}

SerialProjector::~SerialProjector() {
  const bool light = !light_.dark(), power = power_.off_waits();
  if (light || power) exchange_.write_and_wait({});
  if (light) exchange_.write_and_wait(table_.light_off->bytes);
  if (power) exchange_.write_and_wait(table_.power_off.bytes);
}

std::optional<ProjectorCommand> SerialProjector::brightness_command(
    std::optional<std::int32_t> brightness) const {
  expects(!brightness || table_.brightness, "the table has a brightness, where one is to be sent");
  if (!brightness) return std::nullopt;
  return table_.brightness->with(*brightness);
}

CommandExchange::Listener SerialProjector::listener() {
  return {.sent = [this](const ProjectorCommand& command,
                         TimePoint first_byte) { note_sent(command, first_byte); },
          .unasked = [this](const UnaskedLine& line) { unasked(line); },
          .lost =
              [this](const std::string& why) {
                report(MachineEvent::Kind::Fault,
                       why + (light_.may_be_on() ? "; the projector's light may be on" : ""));
              }};
}

ProjectorPower::Wiring SerialProjector::power_wiring() {
  return {.light_off = [this] { light_off(); },
          .suspect_light = [this] { suspect_light(); },
          .make_dark = [this](Done done) { make_dark(std::move(done)); },
          .light_is_off =
              [this] {
                if (table_.light_off) light_.power_is_off();
              },
          .may_ask = [this](Duration duration) { return light_.leaves_time_for(duration); },
          .report = [this](MachineEvent::Kind kind, const std::string& what) { report(kind, what); }};
}

void SerialProjector::note_sent(const ProjectorCommand& command, TimePoint first_byte) {
  if (table_.light_on && &command == &*table_.light_on) return light_.light_on_sent(first_byte);
  if (table_.light_off && &command == &*table_.light_off) return light_.light_off_sent(first_byte);
  if (&command != &table_.power_on) return;
  // The projector may obey power on without an answer, and comes up with a picture of its own.
  power_.power_on_sent(first_byte);
  if (table_.light_off) light_.power_on_sent();
}

void SerialProjector::unasked(const UnaskedLine& line) {
  const std::string what = exchange_.called() + " says: " + line.means;
  switch (line.kind) {
    case UnaskedLine::Kind::Nothing:
      return;
    case UnaskedLine::Kind::Off:
      return power_.went_off(what);
    case UnaskedLine::Kind::Interruption:
      return report(MachineEvent::Kind::Interlock, what);
    case UnaskedLine::Kind::Fault:
      return report(MachineEvent::Kind::Fault, what);
  }
}

void SerialProjector::make_dark(Done done) {
  if (!table_.switches_light()) return done(ProjectorReply::Ok);
  light_.suspect();
  light_.tell_whether_dark(std::move(done));
}

void SerialProjector::light_on(Duration exposure, LightOn tell) {
  light_.forget_last();
  if (!power_.on() || !light_.dark()) {
    exchange_.note_problem(
        exchange_.called() +
        (power_.on() ? " has not confirmed that its light is off; it is not turned on again" : " is not on"));
    answer_ =
        clock_.call_after(Duration{0}, [done = std::move(tell.done)] { done(ProjectorReply::Refused); });
    return;
  }
  if (table_.switches_light()) return light_.turn_on(exposure, std::move(tell));
  answer_ = clock_.call_after(Duration{0}, [this, tell = std::move(tell)] {
    tell.sent(clock_.now());
    tell.done(ProjectorReply::Ok);
  });
}

// Turns the light off. A power off under way goes on, after light off where the light may still be on.
void SerialProjector::light_off() noexcept {
  exchange_.preempt(!light_.may_be_on());
  answer_.reset();
  power_.drop();
  light_.drop();
  if (table_.light_off && !power_.off()) light_.turn_off();
  exchange_.go_on();
}

void SerialProjector::confirm_dark(Done done) {
  expects(table_.light_off.has_value(), "the table has a light off");
  light_off();
  light_.tell_whether_dark(std::move(done));
}

LightSerialPath SerialProjector::light_off_path() const {
  if (lost() || !table_.light_off) return {};
  return {channel_.descriptor(), table_.light_off->bytes, table_.gap + table_.wire_time(*table_.light_off)};
}

std::vector<std::string> SerialProjector::why_not_ready() const {
  if (!light_.overdue()) return {};
  return {"the light may be on: " + light_off_unconfirmed()};
}

void SerialProjector::ask_status(StatusDone done) {
  if (!table_.power) return ask_lamp_hours({}, std::move(done));
  exchange_.ask(*table_.power, [this, done = std::move(done)](const Answer& answer) mutable {
    ProjectorStatus status{answer.reply, {}, {}, {}};
    if (answer.reply != ProjectorReply::Ok) {
      status.problem = last_problem();
      return done(status);
    }
    status.powered = answer.meaning == ReplyMeaning::On;
    // Many projectors do not answer the question for lamp hours while they are off.
    if (!*status.powered) return done(status);
    ask_lamp_hours(status, std::move(done));
  });
}

void SerialProjector::ask_lamp_hours(ProjectorStatus status, StatusDone done) {
  if (!table_.lamp_hours) {
    answer_ = clock_.call_after(Duration{0}, [status, done = std::move(done)] { done(status); });
    return;
  }
  exchange_.ask(*table_.lamp_hours, [this, status, done = std::move(done)](const Answer& answer) mutable {
    status.reply = answer.reply;
    status.lamp_hours = answer.value;
    if (answer.reply != ProjectorReply::Ok) status.problem = last_problem();
    done(status);
  });
}

}  // namespace contourd
