// A projector on a serial line, as its table describes it. Event loop's thread only; must not be destroyed
// from inside its own callbacks. Its destructor sends light off once more where that was never confirmed, and
// power off where that still waits; that may block for a second.
//
// Commands go one at a time: the next when the one before was answered or given up, or when light off comes:
// that is sent at once, or as soon as the table's gap has passed, ahead of all others, and again and again
// until it is confirmed, from the moment that power on is sent, whatever comes of that. So is power off.
// While it is on the projector is asked every few seconds whether it still is. "Light on" is sent once: the
// light is taken as on from its first byte, and the reply says only that it is. At 9600 baud a command of 8
// bytes takes 8 ms and so does its reply, and the projector thinks in between.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hw/clock.hpp"
#include "hw/machine.hpp"
#include "hw/projector.hpp"
#include "hw/serial/byte_channel.hpp"
#include "hw/serial/projector_table.hpp"
#include "hw/serial/reply_reader.hpp"

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
  void power_on(Done done) override;
  void light_on(Duration exposure, LightOn tell) override;
  void light_off() noexcept override;
  void when_dark(std::function<void()> call) override;
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return light_; }
  void power_off() noexcept override;
  // It may have been turned on a moment ago, by a process that has died: until its warm-up would be over, it
  // is not believed when it says that it is off. REQUIRES: nothing was asked for before.
  void may_warm_up() { warm_at_ = clock_.now() + table_.warm_up; }
  // Light off, and whether it is: Ok when the projector confirms it, or says that it is not even on; else,
  // when the table's retries are over, what came of them (see last_problem()). REQUIRES: the table has a
  // light off; nothing was asked for before.
  void confirm_dark(Done done);
  // Power off where it says that it is on, or does so while it may warm up, or when it answers at last: a
  // process that has died may have left it so. A power_on() that comes first is left alone.
  void power_off_if_on();
  void ask_status(StatusDone done) override;
  [[nodiscard]] std::string last_problem() const override { return problem_; }
  [[nodiscard]] std::string doubt() const override;

  // Since light off was given up as unconfirmed and reported, until it is confirmed.
  [[nodiscard]] bool dark_overdue() const { return dark_reported_; }
  // The line is lost, for good: a new channel and a new projector may find it again.
  [[nodiscard]] bool lost() const { return lost_; }

  // The projector does not confirm that the light is off, where it is on or its answers make no sense
  // (Recovery, when it has), or that its lamp is; it is off or silent though it was turned on; it says by
  // itself that something is wrong; or its line is lost.
  void on_disturbance(std::function<void(const Disturbance&)> call) { disturbed_ = std::move(call); }

 private:
  struct Answer {
    ProjectorReply reply = ProjectorReply::Ok;
    ReplyMeaning meaning = ReplyMeaning::Accepted;
    std::optional<std::int64_t> value;
    bool doubtful = false;  // it may be an earlier command's reply once more
  };
  struct Request {
    ReplyReader::RequestId id;
    const ProjectorCommand* command;  // of the table, or brightness_
    std::function<void(const Answer&)> done;
    bool outlives_light_off = false;
    int sent = 0;
  };
  enum class Power { Unknown, Off, On };

  void ask(const ProjectorCommand& command, std::function<void(const Answer&)> done,
           bool outlives_light_off = false);
  void make_way();
  void next();
  void send();
  void hear(std::string_view bytes);
  void take(const ReplyReader::Heard& heard);
  void timed_out();
  void finish(const Answer& answer);
  void note_sent(const ProjectorCommand& command, TimePoint first_byte);
  void fail_current();
  void lose(const std::string& why);
  void unasked(const UnaskedLine& line);
  void report(Disturbance::Kind kind, const std::string& what);

  [[nodiscard]] TimePoint ready_by(TimePoint start) const;
  void switch_on_when_cool(Done done);
  void switch_on(Done done, TimePoint ready_by);
  void wait_until_warm(Done done, TimePoint ready_by);
  void wait_until_on(Done done, TimePoint ready_by);
  void prepare_when_warm(Done done);
  void prepare(const Done& done);
  void set_brightness(const Done& done);
  void light_answered(const Answer& answer, const Done& done);
  void ask_whether_lit(const Done& done);
  void tell_dark();
  void watch_over();
  void ask_whether_still_on();
  void ask_power_off();
  void powered_off(const Answer& answer);
  void power_off_later();
  void is_off();
  void want_dark();
  void darkened(const Answer& answer);
  void is_dark();
  void ask_whether_on(const Answer& answer);
  void suspect_light();
  void tell_darkness(const Answer& answer);
  void try_later();
  void keep_trying();
  void ask_lamp_hours(ProjectorStatus status, StatusDone done);

  [[nodiscard]] std::string called() const;  // "the projector at /dev/ttyUSB0"
  [[nodiscard]] std::string no_answer(const Request& request) const;
  // Null where the table has none.
  [[nodiscard]] const ProjectorCommand* light_on_command() const {
    return table_.light_on ? &*table_.light_on : nullptr;
  }
  [[nodiscard]] const ProjectorCommand* light_off_command() const {
    return table_.light_off ? &*table_.light_off : nullptr;
  }

  ByteChannel& channel_;
  Clock& clock_;
  const ProjectorTable table_;
  std::optional<ProjectorCommand> brightness_;
  ReplyReader reader_;
  std::function<void(const Disturbance&)> disturbed_;
  std::string problem_;
  bool lost_ = false;

  std::deque<Request> queue_;
  std::optional<Request> current_;
  ReplyReader::RequestId last_id_ = 0;
  TimePoint free_at_{};           // the gap is over
  std::unique_ptr<Timer> timer_;  // of the current request: its gap, then its reply
  std::unique_ptr<Timer> step_;   // of powering on

  Power power_ = Power::Unknown;
  bool warms_up_ = false;  // power on was accepted, and nothing else has been wanted since
  std::optional<TimePoint> off_at_;
  bool power_off_waits_ = false;  // until it is confirmed, or power on is wanted
  bool off_if_on_ = false;
  std::unique_ptr<Timer> off_if_on_timer_;  // to the next question whether it is on
  TimePoint power_off_asked_at_{};
  bool power_off_reported_ = false;
  std::unique_ptr<Timer> power_off_timer_;  // to the next attempt
  std::unique_ptr<Timer> watch_;            // to the next question whether it is still on

  bool light_may_be_on_ = false;  // asked for, or power on was sent, and not confirmed dark since
  bool dark_wanted_ = false;      // light off is to be sent until it is confirmed
  bool dark_reported_ = false;
  std::string dark_problem_;   // with that; others come in between
  TimePoint warm_at_{};        // until then nobody wonders at a light off that is refused
  TimePoint dark_asked_at_{};  // light off was sent first, of this attempt
  ReplyReader::RequestId dark_id_ = 0;
  std::unique_ptr<Timer> dark_timer_;  // to the next attempt, after the first few
  std::function<void(const Answer&)> when_dark_;

  std::optional<LightSpan> light_;  // of the last light_on(), once that was sent
  Duration exposure_{};             // that it was asked for
  std::function<void(TimePoint)> light_sent_;
  std::function<void()> dark_;  // asked for by when_dark()
  std::unique_ptr<Timer> tell_sent_, tell_dark_;
};

}  // namespace contourd
