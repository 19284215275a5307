// The projector's power and light. Not thread-safe: calls and callbacks happen on the event loop's thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "hw/clock.hpp"
#include "hw/device.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

enum class ProjectorReply {
  Ok,
  Refused,      // the projector answered that it will not
  NoAnswer,     // no answer in time, retries included
  Interlocked,  // the light stays off for someone's safety: not the projector's fault
};

// A projector's answers to questions about its state.
struct ProjectorStatus {
  ProjectorReply reply = ProjectorReply::Ok;  // reply to the first question that failed, if any
  std::string problem;                        // the failure, in a sentence
  std::optional<bool> powered;                // nullopt if the projector cannot be asked
  std::optional<std::int64_t> lamp_hours;     // nullopt if the projector cannot be asked
};

// The time that one light shone, as far as its commands show: within on_earliest to off_latest.
struct LightSpan {
  TimePoint on_earliest{};                // light on's first byte was sent, plus the projector's latency
  std::optional<TimePoint> on_latest;     // light on was confirmed; nullopt if it never was
  std::optional<TimePoint> off_earliest;  // light off's first byte was sent; nullopt before that
  std::optional<TimePoint> off_latest;    // light off was confirmed; nullopt before that

  // Return how long the light has shone at least, and at most: up to `now` while it is not confirmed off.
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

  // Turns the power on and waits until the lamp is warm. The light stays off: Ok means that this is
  // confirmed. Returns at once; the answer may take minutes.
  virtual void power_on(Done done) = 0;

  // Callbacks of light_on(). They run from the event loop, never inside light_on(); light_off() drops both.
  struct LightOn {
    // Called when the command's first byte was sent: from `earliest` on the light may shine, whatever the
    // reply will be.
    std::function<void(TimePoint earliest)> sent;
    // Gets Ok if the light is on, and NoAnswer if that is unknown and light off is under way. May be called
    // after `exposure` is over.
    Done done;
  };
  // Turns the light on; the caller means to turn it off `exposure` after the time that `sent` gets. The
  // command is sent once: if its reply is lost the projector is asked, and light on is never repeated.
  // Returns at once. A projector that knows that it is not on, or that its light may be on already, answers
  // Refused.
  virtual void light_on(Duration exposure, LightOn tell) = 0;

  // Turns the light off now, whatever else was requested, and drops everything pending except when_dark().
  // Harmless if the light is off already.
  virtual void light_off() noexcept = 0;

  // Calls `call` once, from the event loop, as soon as the light is confirmed off and no light off is under
  // way any more. Another when_dark() replaces `call`, an empty one too; light_on() drops it.
  virtual void when_dark(std::function<void()> call) = 0;

  // Returns when the light of the last light_on() shone; nullopt if its command was never sent.
  [[nodiscard]] virtual std::optional<LightSpan> last_light() const = 0;

  // Turns the light and the power off. The lamp may cool down for a while by itself.
  virtual void power_off() noexcept = 0;

  // Asks the projector all questions that it can answer, and changes nothing. Returns at once. light_off()
  // drops `done`.
  using StatusDone = std::function<void(const ProjectorStatus&)>;
  virtual void ask_status(StatusDone done) = 0;

  // Describes the last reply that was not Ok, in a sentence with the port and the bytes that came back.
  [[nodiscard]] virtual std::string last_problem() const = 0;

  // Returns, in a sentence, why light off is not confirmed; empty if the light is off as far as is known.
  // Meaningful only while no light is wanted.
  [[nodiscard]] virtual std::string light_off_unconfirmed() const = 0;

  // The next three are for a projector that an earlier process may have left on; the defaults, for one that
  // starts switched off.
  //
  // Allows for a projector that was turned on a moment ago: until its warm-up would be over, its answer that
  // it is off does not count. Call this before asking the projector anything.
  virtual void may_warm_up() {}
  // Sends light off until it is confirmed. `done` gets Ok when the light is confirmed off or the projector is
  // not even on; otherwise, after enough tries, the last reply (see last_problem()). Drops everything
  // pending, as light_off() does.
  virtual void confirm_dark(Done done) = 0;
  // Turns the projector off if it says that it is on; a projector that may be warming up, or does not answer,
  // is asked again. A power_on() before the answer cancels this.
  virtual void power_off_if_on() {}

  // Returns the handles with which another process can turn the light off; empty if only this process can, or
  // there is no light.
  [[nodiscard]] virtual LightSerialPath light_off_path() const { return {}; }
};

}  // namespace contourd
