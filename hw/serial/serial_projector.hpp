// A projector on a serial line, as its table describes it. Event loop's thread only; must not be destroyed
// from inside its own callbacks. Its destructor sends light off once more where that was never confirmed, and
// power off where that still waits; that may block for a second.
//
// Light off is sent at once, or as soon as the table's gap has passed, ahead of all others, and again and
// again until it is confirmed, from the moment that power on is sent, whatever comes of that. So is power
// off. While it is on the projector is asked every few seconds whether it still is. What follows what is in
// the tables of projector_power_states.hpp and projector_light_states.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

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
  // projector. REQUIRES: a brightness only where the table has one, within its range.
  SerialProjector(ByteChannel& channel, Clock& clock, ProjectorTable table,
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
  // It may have been turned on a moment ago, by a process that has died: until its warm-up would be over, it
  // is not believed when it says that it is off. REQUIRES: nothing was asked for before.
  void may_warm_up() { power_.may_warm_up(); }
  // Light off, and whether it is: Ok when the projector confirms it, or says that it is not even on; else,
  // when the table's retries are over, what came of them (see last_problem()). REQUIRES: the table has a
  // light off; nothing was asked for before.
  void confirm_dark(Done done);
  // Power off where it says that it is on, or does so while it may warm up, or when it answers at last: a
  // process that has died may have left it so. A power_on() that comes first is left alone.
  void power_off_if_on() { power_.turn_off_if_on(); }
  void ask_status(StatusDone done) override;
  [[nodiscard]] std::string last_problem() const override { return exchange_.problem(); }
  [[nodiscard]] std::string doubt() const override { return light_.doubt(); }

  // Since light off was given up as unconfirmed and reported, until it is confirmed.
  [[nodiscard]] bool dark_overdue() const { return light_.overdue(); }
  // The line is lost, for good: a new channel and a new projector may find it again.
  [[nodiscard]] bool lost() const { return exchange_.lost(); }

  // The projector does not confirm that the light is off, where it is on or its answers make no sense
  // (Recovery, when it has), or that its lamp is; it is off or silent though it was turned on; it says by
  // itself that something is wrong; or its line is lost.
  void on_disturbance(std::function<void(const Disturbance&)> call) { disturbed_ = std::move(call); }

 private:
  using Answer = CommandExchange::Answer;

  [[nodiscard]] std::optional<ProjectorCommand> brightness_command(
      std::optional<std::int32_t> brightness) const;
  [[nodiscard]] CommandExchange::Listener listener();
  [[nodiscard]] ProjectorPower::Wiring power_wiring();
  void note_sent(const ProjectorCommand& command, TimePoint first_byte);
  void unasked(const UnaskedLine& line);
  void report(Disturbance::Kind kind, const std::string& what);
  void suspect_light();
  void make_dark(Done done);
  void ask_lamp_hours(ProjectorStatus status, StatusDone done);

  Clock& clock_;
  const ProjectorTable table_;
  CommandExchange exchange_;
  ProjectorPower power_;
  ProjectorLight light_;
  std::function<void(const Disturbance&)> disturbed_;
  std::unique_ptr<Timer> answer_;  // that needs no command
};

}  // namespace contourd
