// A projector on a serial line, as its table describes it. Event loop's thread only; must not be destroyed
// from inside its own callbacks. Its destructor sends light off once more where that was never confirmed, and
// power off where that still waits; that may block for a second.
//
// Light off is sent at once, or as soon as the table's gap has passed, ahead of all others, and again and
// again until it is confirmed, from the moment that power on is sent, whatever comes of that. So is power
// off. While it is on the projector is asked every few seconds whether it still is. The tables of
// projector_power_states.hpp and projector_light_states.hpp say what follows what.
//
// It has many functions, each of a few lines: those of its interface.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hw/clock.hpp"
#include "hw/machine.hpp"
#include "hw/projector.hpp"
#include "hw/serial/byte_channel.hpp"
#include "hw/serial/command_exchange.hpp"
#include "hw/serial/projector_light.hpp"
#include "hw/serial/projector_power.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

class SerialProjector final : public Projector {
 public:
  // `brightness` is sent after every warm-up. Sends nothing yet. The channel and the clock must outlive the
  // projector.
  SerialProjector(ByteChannel& channel, Clock& clock, ProjectorTable table,
                  std::optional<std::int32_t> brightness = {});
  // With a channel of its own.
  SerialProjector(std::unique_ptr<ByteChannel> channel, Clock& clock, ProjectorTable table,
                  std::optional<std::int32_t> brightness = {});
  ~SerialProjector() override;

  // Asks first: a projector that is on already is not warmed up again, one that warms up already is waited
  // for. Waits out an earlier power_off's cool-down.
  void power_on(Done done) override { power_.turn_on(std::move(done)); }
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override { light_.when_dark(std::move(call)); }
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return light_.last(); }
  void power_off() noexcept override { power_.turn_off(); }
  void may_warm_up() override { power_.may_warm_up(); }
  // REQUIRES: the table has a light off.
  void confirm_dark(Done done) override;
  void power_off_if_on() override { power_.turn_off_if_on(); }
  void ask_status(StatusDone done) override;
  [[nodiscard]] std::string last_problem() const override { return exchange_.problem(); }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return light_.light_off_unconfirmed(); }

  // Of the table's light off.
  [[nodiscard]] LightSerialPath light_off_path() const override;

  // The line is: a new channel and a new projector may find it again.
  [[nodiscard]] bool lost() const override { return exchange_.lost(); }
  // Since light off was given up as unconfirmed and reported, until it is confirmed.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return {}; }
  // The projector does not confirm that the light is off, where it is on or its answers make no sense
  // (Recovery, when it has), or that its lamp is; it is off or silent though it was turned on; it says by
  // itself that something is wrong; or its line is lost.
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }

 private:
  using Answer = CommandExchange::Answer;

  // REQUIRES: a brightness only where the table has one, within its range.
  [[nodiscard]] std::optional<ProjectorCommand> brightness_command(
      std::optional<std::int32_t> brightness) const;
  [[nodiscard]] CommandExchange::Listener listener();
  [[nodiscard]] ProjectorPower::Wiring power_wiring();
  void note_sent(const ProjectorCommand& command, TimePoint first_byte);
  void unasked(const UnaskedLine& line);
  void report(MachineEvent::Kind kind, const std::string& what);
  void suspect_light();
  void make_dark(Done done);
  void ask_lamp_hours(ProjectorStatus status, StatusDone done);

  std::unique_ptr<ByteChannel> own_channel_;  // null where it is somebody else's
  ByteChannel& channel_;
  Clock& clock_;
  const ProjectorTable table_;
  CommandExchange exchange_;
  ProjectorPower power_;
  ProjectorLight light_;
  std::function<void(const MachineEvent&)> on_event_;
  std::unique_ptr<Timer> answer_;  // that needs no command
};

}  // namespace contourd
