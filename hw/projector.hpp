// The projector's power and light. Not thread-safe: calls and callbacks happen on the event loop's thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "hw/clock.hpp"
#include "hw/device.hpp"
#include "hw/watchdog/device_paths.hpp"

namespace contourd {

enum class ProjectorReply {
  Ok,
  Refused,      // it answered, and said no
  NoAnswer,     // it did not answer in time, retries included
  Interlocked,  // the light stays off for somebody's safety: no fault of the projector's
};
[[nodiscard]] std::string_view describe(ProjectorReply reply);

// What a projector says of itself.
struct ProjectorStatus {
  ProjectorReply reply = ProjectorReply::Ok;  // to the first question that went wrong, if one did
  std::string problem;                        // that, in a sentence
  std::optional<bool> powered;                // nothing where it cannot be asked
  std::optional<std::int64_t> lamp_hours;     // the same
};

// When one light shone, as far as its commands tell: somewhere from on_earliest on, somewhere up to
// off_latest.
struct LightSpan {
  TimePoint on_earliest{};                // light on's first byte was sent, and the projector's latency over
  std::optional<TimePoint> on_latest;     // it was confirmed on; nothing when it never was
  std::optional<TimePoint> off_earliest;  // light off's first byte was sent; nothing before
  std::optional<TimePoint> off_latest;    // it was confirmed off; nothing before

  // How long it has shone, at least and at most; at most as of `now` while it is not confirmed off.
  [[nodiscard]] Duration least() const {
    if (!on_latest || !off_earliest) return Duration{0};
    return std::max(*off_earliest - *on_latest, Duration{0});
  }
  [[nodiscard]] Duration most(TimePoint now) const {
    return std::max(off_latest.value_or(now) - on_earliest, Duration{0});
  }
};

class Projector : public Device {
 public:
  using Done = std::function<void(ProjectorReply)>;

  // Power on, then wait until the lamp is warm. The light stays off: Ok says that this is confirmed. Returns
  // at once; may take minutes.
  virtual void power_on(Done done) = 0;

  // What light_on() tells, from the event loop, never from inside it; light_off() drops both.
  struct LightOn {
    // The command's first byte was sent: from `earliest` on the light may shine, whatever the reply will be.
    std::function<void(TimePoint earliest)> sent;
    // Ok: it is on. NoAnswer: nobody knows, and light off is under way. It may come after `exposure` is over.
    Done done;
  };
  // Light on, which its caller means to turn off `exposure` after the time that `sent` gets. The command is
  // sent once: a reply that is lost is asked after, never answered by another light on. Returns at once. One
  // that knows that it is not on, or that its light may be, answers Refused.
  virtual void light_on(Duration exposure, LightOn tell) = 0;

  // Light off, now, whatever else was asked; what waits is dropped, but for when_dark(). Harmless when it is
  // off already.
  virtual void light_off() noexcept = 0;

  // Calls `call` once, from the event loop, as soon as the light is confirmed off and no light off is under
  // way any more. A later call, also with an empty one, takes this one's place; light_on() drops it.
  virtual void when_dark(std::function<void()> call) = 0;

  // Of the last light_on(); nothing when its command was never sent.
  [[nodiscard]] virtual std::optional<LightSpan> last_light() const = 0;

  // Light off and power off. The lamp may cool down for a while by itself.
  virtual void power_off() noexcept = 0;

  // Asks the projector what it can be asked, and changes nothing. Returns at once. light_off() drops `done`.
  using StatusDone = std::function<void(const ProjectorStatus&)>;
  virtual void ask_status(StatusDone done) = 0;

  // The last reply that was not Ok, in a sentence with the port and what came back.
  [[nodiscard]] virtual std::string last_problem() const = 0;

  // Why light off is not confirmed, in a sentence; empty when the light is off as far as is known. To be
  // asked when no light is wanted.
  [[nodiscard]] virtual std::string light_off_unconfirmed() const = 0;

  // The next three are for a projector that an earlier process may have left on.
  //
  // The projector may have been turned on a moment ago. Until its warm-up would be over, its answer that it
  // is off does not count. Before anything else is asked.
  virtual void may_warm_up() = 0;
  // Sends light off until it is confirmed. `done` gets Ok when the light is confirmed off, or the projector
  // is not even on; else, after enough tries, the last reply (see last_problem()). What waits is dropped, as
  // by light_off().
  virtual void confirm_dark(Done done) = 0;
  // Turns the projector off if it says that it is on; one that may warm up, or does not answer, is asked
  // again. A power_on() that comes first ends this.
  virtual void power_off_if_on() = 0;

  // What another process can turn the light off by. Empty where only this one can, or there is no light.
  [[nodiscard]] virtual LightSerialPath light_off_path() const = 0;
};

}  // namespace contourd
