// A projector on a serial line, as its table describes it. Event loop's thread only; must not be destroyed
// from inside its own callbacks. The destructor sends light off once more if it was never confirmed, and
// power off if it is still pending; this may block for a second.
//
// Light off is sent at once, or as soon as the table's gap has passed, ahead of all other commands, and is
// repeated until it is confirmed, from the moment that power on is sent, whatever its outcome. Power off is
// repeated in the same way. While the projector is on, it is asked every few seconds whether it still is. The
// tables of projector_power_states.hpp and projector_light_states.hpp define the details.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
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
  // Like the other constructor, but takes ownership of the channel.
  SerialProjector(std::unique_ptr<ByteChannel> channel, Clock& clock, ProjectorTable table,
                  std::optional<std::int32_t> brightness = {});
  ~SerialProjector() override;

  // Asks first: a projector that is on already is not warmed up again, and one that is warming up already is
  // waited for. Waits for the cool-down after an earlier power_off() to end.
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

  // Returns the port, with the table's light off.
  [[nodiscard]] LightSerialPath light_off_path() const override;

  // True if the serial line is lost: a new channel and a new projector may find it again.
  [[nodiscard]] bool lost() const override { return exchange_.lost(); }
  // Not empty from the report that light off was not confirmed until it is confirmed.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  [[nodiscard]] std::string description() const override { return table_.name + " at " + channel_.name(); }
  // Reports that the projector does not confirm that its light is off, although it is on or its answers make
  // no sense (and a Recovery once it has confirmed it), or that its lamp is off; that it is off or silent
  // although it was turned on; that it reports a problem by itself; or that its line is lost.
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
  void report(MachineEvent::Kind kind, const std::string& what) {
    if (on_event_) on_event_({kind, what});
  }
  void suspect_light() {
    if (table_.light_off) light_.suspect();
  }
  void make_dark(Done done);
  void ask_lamp_hours(ProjectorStatus status, StatusDone done);

  std::unique_ptr<ByteChannel> own_channel_;  // null if the caller owns the channel
  ByteChannel& channel_;
  Clock& clock_;
  const ProjectorTable table_;
  CommandExchange exchange_;
  ProjectorPower power_;
  ProjectorLight light_;
  std::function<void(const MachineEvent&)> on_event_;
  std::unique_ptr<Timer> answer_;  // an answer that needs no command
};

}  // namespace contourd
