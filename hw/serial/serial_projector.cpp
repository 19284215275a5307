#include "hw/serial/serial_projector.hpp"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "hw/serial/readable_bytes.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// A reply that is late by more than the timeout again is not waited for: it would be taken for a later
// command's.
constexpr int kLateTimeouts = 2;
// Light on's is longer: taken for light off's it would make a lit projector dark. The longest timeout that a
// table can have.
constexpr Duration kLateLightOn = 30s;
// Between questions whether the projector is on by now, and how long after its warm-up it may say no.
constexpr Duration kAskAgain = 2s;
constexpr Duration kReadyGrace = 60s;
// Between questions whether it still is.
constexpr Duration kWatchInterval = 5s;
// Between attempts to turn it off, before and after that is told: once it does not do so this long after it
// was told to, and was warm.
constexpr Duration kOffAgain = 5s, kOffAgainLater = 60s;
constexpr Duration kOffGrace = 30s;

}  // namespace

SerialProjector::SerialProjector(ByteChannel& channel, Clock& clock, ProjectorTable table,
                                 std::optional<std::int32_t> brightness)
    : channel_(channel), clock_(clock), table_(std::move(table)), reader_(table_) {
  if (brightness) brightness_ = table_.brightness.value().with(*brightness);
  channel_.listen({.bytes = [this](std::string_view bytes) { hear(bytes); },
                   .lost = [this](const std::string& why) { lose(why); }});
}

SerialProjector::~SerialProjector() {
  channel_.listen({});
  const bool light = dark_wanted_ || light_may_be_on_;
  if (light || power_off_waits_) channel_.write_and_wait({}, table_.gap);
  if (light) channel_.write_and_wait(table_.light_off->bytes, table_.gap);
  if (power_off_waits_) channel_.write_and_wait(table_.power_off.bytes, table_.gap);
}

std::string SerialProjector::called() const {
  return "the projector at " + channel_.name();
}

// --- One command at a time ---

void SerialProjector::ask(const ProjectorCommand& command, std::function<void(const Answer&)> done,
                          bool outlives_light_off) {
  queue_.push_back({++last_id_, &command, std::move(done), outlives_light_off});
  next();
}

// All but turning off and what leads to it: that goes on, behind light off where the light may still be on.
void SerialProjector::make_way() {
  std::erase_if(queue_, [](const Request& request) { return !request.outlives_light_off; });
  step_.reset();
  tell_sent_.reset();
  when_dark_ = nullptr;
  if (!current_ || current_->command == light_off_command()) return;
  if (current_->outlives_light_off) {
    if (!table_.light_off || (current_->command == &table_.power_off && !light_may_be_on_)) return;
    queue_.push_front(std::move(*current_));
  }
  current_.reset();
  timer_.reset();
}

void SerialProjector::next() {
  if (current_) return;
  if (dark_wanted_ && !dark_timer_) {
    current_ = Request{dark_id_, light_off_command(), [this](const Answer& answer) { darkened(answer); }};
    dark_asked_at_ = clock_.now();
  } else if (!queue_.empty()) {
    current_ = std::move(queue_.front());
    queue_.pop_front();
  } else {
    return;
  }
  reader_.forget();
  send();
}

void SerialProjector::send() {
  if (clock_.now() < free_at_) {
    timer_ = clock_.call_at(free_at_, [this] { send(); });
    return;
  }
  const ProjectorCommand& command = *current_->command;
  const TimePoint first_byte = clock_.now();
  if (lost_ || !channel_.write(command.bytes)) {
    // Not from inside the caller's own call.
    timer_ = clock_.call_after(Duration{0}, [this] { fail_current(); });
    return;
  }
  ++current_->sent;
  note_sent(command, first_byte);
  const TimePoint sent_at = clock_.now() + table_.wire_time(command);
  free_at_ = sent_at + table_.gap;
  const bool lights = &command == light_on_command();
  reader_.expect(current_->id, command, sent_at,
                 kLateTimeouts * (lights ? std::max(command.timeout, kLateLightOn) : command.timeout));
  if (command.replies.empty()) {
    timer_ = clock_.call_at(free_at_, [this] { finish({}); });
  } else {
    timer_ = clock_.call_at(sent_at + command.timeout, [this] { timed_out(); });
  }
}

void SerialProjector::note_sent(const ProjectorCommand& command, TimePoint first_byte) {
  if (&command == light_on_command()) {
    light_may_be_on_ = true;
    light_ = LightSpan{first_byte + table_.latency, {}, {}, {}};
    tell_sent_ = clock_.call_after(Duration{0}, [this] { light_sent_(light_->on_earliest); });
  }
  if (&command == light_off_command() && light_ && !light_->off_earliest) light_->off_earliest = first_byte;
  if (&command == &table_.power_on) {
    // It may be obeyed without an answer, and comes up with a picture of its own.
    warm_at_ = first_byte + table_.warm_up;
    light_may_be_on_ = table_.light_off.has_value();
  }
}

void SerialProjector::hear(std::string_view bytes) {
  // A copy: what is heard leads to calls that may lead back here.
  const std::string all(bytes);
  for (const char byte : all)
    take(reader_.take(byte, clock_.now()));
}

void SerialProjector::take(const ReplyReader::Heard& heard) {
  if (heard.unasked != nullptr) return unasked(*heard.unasked);
  if (!heard.reply) return;
  free_at_ = clock_.now() + table_.gap;
  const bool own = current_ && heard.reply->request == current_->id;  // else late, and somebody else's
  const bool waits = current_ && current_->sent > 0;
  const bool dark_waits = waits && table_.light_off && current_->command == &*table_.light_off;
  const bool off_waits = waits && current_->command == &table_.power_off;
  // Of light off's and light on's nobody knows which this one is, where they look alike: light on's may have
  // been lost, or come late, or twice. The next light off's will tell, sooner than a timeout. So it is with
  // power off's.
  if ((dark_waits && !own) || ((dark_waits || off_waits) && heard.reply->doubtful)) {
    timer_ = clock_.call_at(free_at_, [this] { send(); });
    return;
  }
  if (!own) return;
  if (heard.reply->meaning == ReplyMeaning::Refused) {
    problem_ = called() + " refused \"" + current_->command->name + "\": it answered " +
               readable_bytes(heard.reply->text);
    return finish({ProjectorReply::Refused, ReplyMeaning::Refused, {}});
  }
  finish({ProjectorReply::Ok, heard.reply->meaning, heard.reply->value, heard.reply->doubtful});
}

void SerialProjector::timed_out() {
  const ReplyReader::RequestId id = current_->id;
  take(reader_.end_line(clock_.now()));
  if (!current_ || current_->id != id) return;
  // Once it is known that light off is not heard, it must not keep power off waiting. A light on that may
  // have been obeyed is not sent again.
  const bool hopeless = dark_reported_ && current_->command == light_off_command();
  const bool once = current_->command == light_on_command() && current_->sent > 0;
  if (current_->sent <= table_.retries && !hopeless && !once) return send();
  fail_current();
}

void SerialProjector::fail_current() {
  problem_ = no_answer(*current_);
  finish({ProjectorReply::NoAnswer, {}, {}});
}

std::string SerialProjector::no_answer(const Request& request) const {
  if (lost_ || request.sent == 0) return called() + " cannot be reached: the serial line is lost";
  const std::string tried = std::to_string(request.sent) + (request.sent == 1 ? " try" : " tries");
  const std::string what = "\"" + request.command->name + "\" in " + tried + " of " +
                           std::to_string(request.command->timeout / 1ms) + " ms";
  const std::string baud = std::to_string(table_.baud);
  if (reader_.unexplained().empty())
    return called() + " did not answer " + what + ": is it connected, and set to " + baud + " baud?";
  return called() + " answered " + what + " with what is no reply of its kind, " +
         readable_bytes(reader_.unexplained()) + ": is its baud rate " + baud +
         ", and is it the projector of the table \"" + table_.name + "\"?";
}

void SerialProjector::finish(const Answer& answer) {
  const Request request = std::move(*current_);
  current_.reset();
  timer_.reset();
  if (request.done) request.done(answer);
  next();
}

void SerialProjector::lose(const std::string& why) {
  lost_ = true;
  if (current_) timer_ = clock_.call_after(Duration{0}, [this] { fail_current(); });
  report(Disturbance::Kind::Fault, why + (light_may_be_on_ ? "; the projector's light may be on" : ""));
}

void SerialProjector::unasked(const UnaskedLine& line) {
  const std::string what = called() + " says: " + line.means;
  switch (line.kind) {
    case UnaskedLine::Kind::Nothing:
      return;
    case UnaskedLine::Kind::Off:
      if (power_ != Power::On) return;
      power_ = Power::Unknown;
      return report(Disturbance::Kind::Fault, what);
    case UnaskedLine::Kind::Interruption:
      return report(Disturbance::Kind::Interruption, what);
    case UnaskedLine::Kind::Fault:
      return report(Disturbance::Kind::Fault, what);
  }
}

void SerialProjector::report(Disturbance::Kind kind, const std::string& what) {
  if (disturbed_) disturbed_({kind, what});
}

// --- Power ---

void SerialProjector::power_on(Done done) {
  power_off_waits_ = power_off_reported_ = off_if_on_ = false;
  power_off_timer_.reset();
  off_if_on_timer_.reset();
  if (warms_up_ && clock_.now() < warm_at_) return wait_until_warm(std::move(done), ready_by(clock_.now()));
  if (!table_.power) return power_ == Power::On ? prepare(done) : switch_on_when_cool(std::move(done));
  ask(*table_.power, [this, done = std::move(done)](const Answer& answer) mutable {
    if (answer.meaning == ReplyMeaning::On && answer.reply == ProjectorReply::Ok)
      return prepare_when_warm(std::move(done));
    // No answer: some are deaf to questions while they are off.
    switch_on_when_cool(std::move(done));
  });
}

TimePoint SerialProjector::ready_by(TimePoint start) const {
  return start + table_.cool_down + 2 * table_.warm_up + kReadyGrace;
}

void SerialProjector::switch_on_when_cool(Done done) {
  const TimePoint cool_at = off_at_ ? *off_at_ + table_.cool_down : clock_.now();
  const TimePoint ready = ready_by(std::max(cool_at, clock_.now()));
  step_ = clock_.call_at(
      cool_at, [this, ready, done = std::move(done)]() mutable { switch_on(std::move(done), ready); });
}

void SerialProjector::switch_on(Done done, TimePoint ready_by) {
  power_ = Power::Unknown;
  ask(table_.power_on, [this, ready_by, done = std::move(done)](const Answer& answer) mutable {
    if (answer.reply != ProjectorReply::Ok) return done(answer.reply);
    warms_up_ = true;
    warm_at_ = clock_.now() + table_.warm_up;
    wait_until_warm(std::move(done), ready_by);
    if (table_.light_off) suspect_light();
  });
}

void SerialProjector::wait_until_warm(Done done, TimePoint ready_by) {
  step_ = clock_.call_at(warm_at_, [this, ready_by, done = std::move(done)]() mutable {
    if (!table_.power) return prepare(done);
    wait_until_on(std::move(done), ready_by);
  });
}

// It may have ignored the command because it still cooled down from before this program: then it gets
// another.
void SerialProjector::wait_until_on(Done done, TimePoint ready_by) {
  ask(*table_.power, [this, ready_by, done = std::move(done)](const Answer& answer) mutable {
    if (answer.reply == ProjectorReply::NoAnswer) return done(answer.reply);
    if (answer.meaning == ReplyMeaning::On) return prepare(done);
    if (clock_.now() + kAskAgain > ready_by) {
      problem_ = called() + " says that it is off, long after it was turned on";
      return done(ProjectorReply::Refused);
    }
    step_ = clock_.call_after(kAskAgain, [this, ready_by, off = answer.meaning == ReplyMeaning::Off,
                                          done = std::move(done)]() mutable {
      off ? switch_on(std::move(done), ready_by) : wait_until_on(std::move(done), ready_by);
    });
  });
}

// It says that it is on, but may have been turned on a moment ago.
void SerialProjector::prepare_when_warm(Done done) {
  if (clock_.now() >= warm_at_) return prepare(done);
  step_ = clock_.call_at(warm_at_, [this, done = std::move(done)] { prepare(done); });
}

// Powered on and warm; whether its light is on nobody knows.
void SerialProjector::prepare(const Done& done) {
  power_ = Power::On;
  warms_up_ = false;
  off_at_.reset();
  watch_over();
  if (!table_.switches_light()) return set_brightness(done);
  suspect_light();
  when_dark_ = [this, done](const Answer& answer) {
    answer.reply == ProjectorReply::Ok ? set_brightness(done) : done(answer.reply);
  };
}

void SerialProjector::set_brightness(const Done& done) {
  if (!brightness_) return done(ProjectorReply::Ok);
  ask(*brightness_, [done](const Answer& answer) { done(answer.reply); });
}

void SerialProjector::watch_over() {
  if (table_.power) watch_ = clock_.call_after(kWatchInterval, [this] { ask_whether_still_on(); });
}

// A lamp that fails, or a projector that turns itself off, may say nothing of it.
void SerialProjector::ask_whether_still_on() {
  watch_over();
  if (power_ != Power::On || power_off_waits_ || lost_) return;
  if (current_ || dark_wanted_ || !queue_.empty()) return;  // what is asked now tells as much
  // Light off is not to wait for this one's reply and gap.
  const bool lit = light_ && !light_->off_earliest;
  if (lit && clock_.now() + table_.power->timeout + table_.gap > light_->on_earliest + exposure_) return;
  const auto heard = [this](const Answer& answer) {
    const bool says_off = answer.reply == ProjectorReply::Ok && answer.meaning == ReplyMeaning::Off;
    if (power_ != Power::On || lost_ || (answer.reply != ProjectorReply::NoAnswer && !says_off)) return;
    power_ = Power::Unknown;
    if (says_off) problem_ = called() + " says that it is off, though nobody has turned it off";
    report(Disturbance::Kind::Fault, problem_);
  };
  // Where light off is a command, that tells as much.
  ask(*table_.power, heard, !table_.light_off);
}

void SerialProjector::power_off_if_on() {
  if (!table_.power) return;
  off_if_on_ = true;
  const auto heard = [this](const Answer& answer) {
    const bool says_on = answer.reply == ProjectorReply::Ok && answer.meaning == ReplyMeaning::On;
    if (!off_if_on_) return;
    if (says_on) return power_off();
    const bool warms_up = clock_.now() < warm_at_;
    off_if_on_ = (warms_up || answer.reply == ProjectorReply::NoAnswer) && !lost_;
    if (!off_if_on_) return;
    // One that is silent may be deaf while it is off, or its line is not plugged in yet.
    off_if_on_timer_ =
        clock_.call_after(warms_up ? kWatchInterval : kOffAgainLater, [this] { power_off_if_on(); });
  };
  ask(*table_.power, heard, true);
}

void SerialProjector::power_off() noexcept {
  light_off();
  warms_up_ = off_if_on_ = false;
  if (power_ == Power::Off || power_off_waits_) return;
  power_off_waits_ = true;
  power_off_asked_at_ = clock_.now();
  ask_power_off();
}

void SerialProjector::ask_power_off() {
  ask(
      table_.power_off, [this](const Answer& answer) { powered_off(answer); }, true);
}

void SerialProjector::powered_off(const Answer& answer) {
  off_at_ = clock_.now();
  power_ = Power::Unknown;
  if (answer.reply == ProjectorReply::Ok && !table_.power_off.replies.empty()) return is_off();
  // Of one that neither answers nor can be asked, nobody will know more.
  if (lost_ || (answer.reply == ProjectorReply::Ok && !table_.power)) power_off_waits_ = false;
  if (answer.reply == ProjectorReply::Ok) problem_ = called() + " has not confirmed that it is off";
  if (power_off_waits_) power_off_later();
}

// Refused, as while it warms up, not answered, or never answered.
void SerialProjector::power_off_later() {
  const std::string problem = problem_;
  if (clock_.now() > std::max(power_off_asked_at_, warm_at_) + kOffGrace &&
      !std::exchange(power_off_reported_, true)) {
    report(Disturbance::Kind::Fault, "the lamp may be on: " + problem);
  }
  power_off_timer_ =
      clock_.call_after(power_off_reported_ ? kOffAgainLater : kOffAgain, [this] { ask_power_off(); });
  if (!table_.power) return;
  const auto heard = [this](const Answer& answer) {
    // As it warms up it may not call itself on yet.
    if (clock_.now() < warm_at_) return;
    if (answer.reply == ProjectorReply::Ok && answer.meaning == ReplyMeaning::Off) is_off();
  };
  ask(*table_.power, heard);
}

void SerialProjector::is_off() {
  power_ = Power::Off;
  power_off_waits_ = power_off_reported_ = false;
  power_off_timer_.reset();
  warm_at_ = {};
  if (table_.light_off) is_dark();
}

// --- Light ---

void SerialProjector::light_on(Duration exposure, LightOn tell) {
  dark_ = nullptr;
  exposure_ = exposure;
  light_.reset();
  const bool dark = !light_may_be_on_ && !dark_wanted_;
  if (power_ != Power::On || !dark) {
    problem_ = called() + (power_ == Power::On
                               ? " has not confirmed that its light is off, it is not turned on again"
                               : " is not on");
    step_ = clock_.call_after(Duration{0}, [done = std::move(tell.done)] { done(ProjectorReply::Refused); });
    return;
  }
  if (!table_.switches_light()) {
    step_ = clock_.call_after(Duration{0}, [this, tell = std::move(tell)] {
      tell.sent(clock_.now());
      tell.done(ProjectorReply::Ok);
    });
    return;
  }
  light_sent_ = std::move(tell.sent);
  ask(*table_.light_on,
      [this, done = std::move(tell.done)](const Answer& answer) { light_answered(answer, done); });
}

void SerialProjector::light_answered(const Answer& answer, const Done& done) {
  const bool confirmed = answer.reply == ProjectorReply::Ok && !answer.doubtful;
  if (confirmed) {
    light_->on_latest = clock_.now();
    return done(answer.reply);
  }
  if (answer.doubtful) problem_ = called() + " has not confirmed that its light is on";
  if (answer.reply != ProjectorReply::Refused && light_ && table_.light) return ask_whether_lit(done);
  // Doubtful: it may be on, and since when nobody knows.
  if (answer.reply == ProjectorReply::Ok) return done(answer.reply);
  // Not confirmed is not off.
  want_dark();
  done(answer.reply);
}

// Its reply to light on was lost, or the command, or nobody knows whether it has replied.
void SerialProjector::ask_whether_lit(const Done& done) {
  ask(*table_.light, [this, done, problem = problem_](const Answer& answer) {
    if (answer.reply == ProjectorReply::Ok && answer.meaning == ReplyMeaning::On) {
      light_->on_latest = clock_.now();
      return done(ProjectorReply::Ok);
    }
    problem_ = problem;
    want_dark();
    done(ProjectorReply::NoAnswer);
  });
}

void SerialProjector::light_off() noexcept {
  make_way();
  if (!table_.light_off || power_ == Power::Off) return;
  want_dark();
}

void SerialProjector::confirm_dark(Done done) {
  light_off();
  when_dark_ = [done = std::move(done)](const Answer& answer) { done(answer.reply); };
}

void SerialProjector::want_dark() {
  // A reply to an earlier light off confirms this one only if no light on came in between.
  if (!dark_wanted_) dark_id_ = ++last_id_;
  dark_wanted_ = true;
  dark_timer_.reset();
  next();
}

void SerialProjector::darkened(const Answer& answer) {
  if (answer.reply == ProjectorReply::Ok) {
    is_dark();
  } else if (lost_) {
    dark_wanted_ = false;  // the loss was reported, with the light
  } else if (dark_asked_at_ < warm_at_) {
    return try_later();  // whoever waits for darkness goes on waiting
  } else if (light_may_be_on_ && (answer.reply == ProjectorReply::NoAnswer || !table_.power)) {
    keep_trying();
  } else {
    return ask_whether_on(answer);
  }
  tell_darkness(answer);
}

void SerialProjector::is_dark() {
  dark_wanted_ = light_may_be_on_ = false;
  dark_timer_.reset();
  if (light_ && !light_->off_latest) light_->off_latest = clock_.now();
  tell_dark();
  if (std::exchange(dark_reported_, false))
    report(Disturbance::Kind::Recovery, called() + " has confirmed that its light is off");
}

void SerialProjector::when_dark(std::function<void()> call) {
  dark_ = std::move(call);
  tell_dark();
}

void SerialProjector::tell_dark() {
  if (!dark_) return;
  tell_dark_ = clock_.call_after(Duration{0}, [this] {
    if (light_may_be_on_ || dark_wanted_) return;  // is_dark() comes back here
    if (const auto dark = std::exchange(dark_, nullptr)) dark();
  });
}

void SerialProjector::tell_darkness(const Answer& answer) {
  if (const auto when_dark = std::exchange(when_dark_, nullptr)) when_dark(answer);
}

// It does not confirm that there is no light: as many do while they are off.
void SerialProjector::ask_whether_on(const Answer& answer) {
  dark_wanted_ = false;
  if (!reader_.unexplained().empty()) return suspect_light();
  tell_dark();
  if (!table_.power) return tell_darkness(answer);
  ask(*table_.power, [this, answer, problem = problem_](const Answer& power) {
    const bool says_off = power.reply == ProjectorReply::Ok && power.meaning == ReplyMeaning::Off;
    const bool says_on = power.reply == ProjectorReply::Ok && !says_off;
    // As it warms up it may not call itself on yet.
    if (light_may_be_on_ && clock_.now() < warm_at_) {
      dark_wanted_ = true;
      return try_later();
    }
    if (says_off) {
      is_dark();
      return tell_darkness({});
    }
    problem_ = problem;
    if (light_may_be_on_) {
      dark_wanted_ = true;
      keep_trying();
    } else if (says_on || !reader_.unexplained().empty()) {
      return suspect_light();
    }
    tell_darkness(answer);
  });
}

void SerialProjector::suspect_light() {
  light_may_be_on_ = true;
  want_dark();
}

void SerialProjector::try_later() {
  dark_timer_ = clock_.call_after(table_.light_off->timeout, [this] {
    dark_timer_.reset();
    next();
  });
}

void SerialProjector::keep_trying() {
  try_later();
  // No light on behind a light off that failed.
  std::erase_if(queue_, [this](const Request& request) { return request.command == light_on_command(); });
  dark_problem_ = problem_;
  if (!std::exchange(dark_reported_, true))
    report(Disturbance::Kind::Fault, "the light may be on: " + dark_problem_);
}

std::string SerialProjector::doubt() const {
  if (!light_may_be_on_) return {};
  return dark_reported_ ? dark_problem_ : called() + " has not confirmed that its light is off";
}

// --- Status ---

void SerialProjector::ask_status(StatusDone done) {
  if (!table_.power) return ask_lamp_hours({}, std::move(done));
  ask(*table_.power, [this, done = std::move(done)](const Answer& answer) mutable {
    ProjectorStatus status{answer.reply, {}, {}, {}};
    if (answer.reply != ProjectorReply::Ok) {
      status.problem = problem_;
      return done(status);
    }
    status.powered = answer.meaning == ReplyMeaning::On;
    // Off, many do not answer this.
    if (!*status.powered) return done(status);
    ask_lamp_hours(status, std::move(done));
  });
}

void SerialProjector::ask_lamp_hours(ProjectorStatus status, StatusDone done) {
  if (!table_.lamp_hours) {
    step_ = clock_.call_after(Duration{0}, [status, done = std::move(done)] { done(status); });
    return;
  }
  ask(*table_.lamp_hours, [this, status, done = std::move(done)](const Answer& answer) mutable {
    status.reply = answer.reply;
    status.lamp_hours = answer.value;
    if (answer.reply != ProjectorReply::Ok) status.problem = problem_;
    done(status);
  });
}

}  // namespace contourd
