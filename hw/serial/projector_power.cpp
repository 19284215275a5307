#include "hw/serial/projector_power.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Interval of the questions whether the projector is on yet, and how long after its warm-up it may say no.
constexpr Duration kAskAgain = 2s;
constexpr Duration kReadyGrace = 60s;
// Interval of the questions whether the projector is still on.
constexpr Duration kWatchInterval = 5s;
// Interval of the attempts to turn the projector off, before and after their failure is reported.
constexpr Duration kOffAgain = 5s, kOffAgainLater = 60s;
// How long after power off was requested, and the projector was warm, the failure is reported.
constexpr Duration kOffGrace = 30s;

}  // namespace

ProjectorPower::ProjectorPower(CommandExchange& exchange, Clock& clock, const ProjectorTable& table,
                               std::optional<ProjectorCommand> brightness, Wiring wiring)
    : exchange_(exchange),
      clock_(clock),
      table_(table),
      brightness_(std::move(brightness)),
      wiring_(std::move(wiring)) {}

void ProjectorPower::turn_on(Done done) {
  done_ = std::move(done);
  ready_by_ = ready_by(clock_.now());
  take(Event::PowerOnWanted);
}

void ProjectorPower::turn_off() {
  if (!is_turned_off(state_)) off_asked_at_ = clock_.now();
  take(Event::PowerOffWanted);
}

void ProjectorPower::drop() {
  done_ = nullptr;
  take(Event::Dropped);
}

void ProjectorPower::went_off(const std::string& what) {
  why_ = what;
  take(Event::WentOff);
}

void ProjectorPower::take(Event event) {
  const ProjectorPowerTransition* const row = projector_power_table().find(state_, event);
  if (row == nullptr) return;
  const State next = row->next(state_);
  if (next != state_) timer_.reset();
  state_ = next;
  for (const Effect effect : row->done()) {
    carry_out(effect);
    if (state_ != next) return;  // the effect led to another state, which replaces the other effects
  }
}

void ProjectorPower::carry_out(Effect effect) {
  const auto whether_on = [this](const Answer& answer) { return meaning_of(answer); };
  switch (effect) {
    case Effect::LightOff:
      return wiring_.light_off();
    case Effect::AskWhetherOn:
      return ask(false, whether_on);
    case Effect::AskWhetherStillOn:
      return ask(true, whether_on);
    case Effect::AskWhetherReady:
      return ask(true, [this](const Answer& answer) { return whether_ready(answer); });
    case Effect::AskWhetherLeftOn:
      return ask_left_on();
    case Effect::AskLeftOnSoon:
      return wait(kWatchInterval);
    case Effect::AskLeftOnLater:
      return wait(kOffAgainLater);
    case Effect::WaitUntilCool:
      return wait_until_cool();
    case Effect::SendPowerOn:
      return send_power_on();
    case Effect::DropPowerOn:
      return exchange_.drop(table_.power_on);
    case Effect::SuspectLight:
      return wiring_.suspect_light();
    case Effect::WaitUntilWarm:
      return wait_until_warm();
    case Effect::Pause:
      return wait(kAskAgain);
    case Effect::WatchOver:
      return watch_over();
    case Effect::MakeDark:
      return make_dark();
    case Effect::SetBrightness:
      return set_brightness();
    case Effect::SendPowerOff:
      return send_power_off();
    case Effect::AskWhetherOff:
      return ask_whether_off();
    case Effect::PowerOffAgain:
      return wait(kOffAgain);
    case Effect::PowerOffAgainLater:
      return wait(kOffAgainLater);
    case Effect::NoteOff:
      return note_off();
    case Effect::Tell:
      return tell(reply_);
    case Effect::TellNeverOn:
      return tell_refused(exchange_.called() + " says that it is off, long after it was turned on");
    case Effect::TellWentOff:
      return tell_refused(why_);
    case Effect::ReportWentOff:
      return wiring_.report(MachineEvent::Kind::Fault, why_);
    case Effect::ReportLampOn:
      return wiring_.report(MachineEvent::Kind::Fault, "the lamp may be on: " + why_);
  }
}

// Asks whether the projector is on. Where the table has no query for that, the known state is the answer.
void ProjectorPower::ask(bool known_on, std::function<Event(const Answer&)> meaning) {
  if (!table_.power) return take(known_on ? Event::SaysOn : Event::SaysNothing);
  exchange_.ask(*table_.power, [this, meaning = std::move(meaning)](const Answer& answer) {
    reply_ = answer.reply;
    take(meaning(answer));
  });
}

ProjectorPower::Event ProjectorPower::meaning_of(const Answer& answer) const {
  if (answer.reply == ProjectorReply::NoAnswer) return Event::SaysNothing;
  if (answer.says(ReplyMeaning::On)) return clock_.now() < warm_at_ ? Event::SaysOnEarly : Event::SaysOn;
  return answer.meaning == ReplyMeaning::Off ? Event::SaysOff : Event::SaysUnclear;
}

ProjectorPower::Event ProjectorPower::whether_ready(const Answer& answer) const {
  if (answer.reply == ProjectorReply::NoAnswer) return Event::SaysNothing;
  if (answer.meaning == ReplyMeaning::On) return Event::SaysOn;
  if (clock_.now() + kAskAgain > ready_by_) return Event::NeverOn;
  return answer.meaning == ReplyMeaning::Off ? Event::SaysOff : Event::SaysUnclear;
}

void ProjectorPower::ask_left_on() {
  const auto heard = [this](const Answer& answer) {
    if (state_ != State::LeftOn) return;
    if (answer.says(ReplyMeaning::On)) return take(Event::SaysOn);
    if (exchange_.lost()) return take(Event::LineLost);
    if (clock_.now() < warm_at_) return take(Event::NotOnYet);
    if (answer.reply == ProjectorReply::NoAnswer) return take(Event::SaysNothing);
    take(answer.meaning == ReplyMeaning::Off ? Event::SaysOff : Event::SaysUnclear);
  };
  exchange_.ask(*table_.power, heard, true);
}

TimePoint ProjectorPower::ready_by(TimePoint start) const {
  return start + table_.cool_down + 2 * table_.warm_up + kReadyGrace;
}

void ProjectorPower::wait_until_cool() {
  const TimePoint cool_at = std::max(off_at_ ? *off_at_ + table_.cool_down : clock_.now(), clock_.now());
  ready_by_ = ready_by(cool_at);
  wait(cool_at - clock_.now(), Event::Cool);
}

void ProjectorPower::send_power_on() {
  exchange_.ask(table_.power_on, [this](const Answer& answer) {
    reply_ = answer.reply;
    if (answer.reply != ProjectorReply::Ok) return take(Event::PowerOnFailed);
    warm_at_ = clock_.now() + table_.warm_up;
    take(Event::PowerOnAnswered);
  });
}

void ProjectorPower::set_brightness() {
  const auto answered = [this](const Answer& answer) {
    reply_ = answer.reply;
    take(Event::BrightnessAnswered);
  };
  if (!brightness_) return answered({});
  exchange_.ask(*brightness_, answered);
}

void ProjectorPower::send_power_off() {
  exchange_.ask({.command = &table_.power_off,
                 .done = [this](const Answer& answer) { power_off_answered(answer); },
                 .retries = table_.retries,
                 .stays = true,
                 .if_ambiguous = CommandExchange::Ambiguous::SendsAgain});
}

void ProjectorPower::power_off_answered(const Answer& answer) {
  off_at_ = clock_.now();
  const bool accepted = answer.reply == ProjectorReply::Ok;
  if (accepted && !table_.power_off.replies.empty()) return take(Event::PowerOffConfirmed);
  // Power off of a projector that neither answers nor can be asked will never be confirmed.
  if (exchange_.lost() || (accepted && !table_.power)) return take(Event::PowerOffUnknowable);
  if (accepted) exchange_.note_problem(exchange_.called() + " has not confirmed that it is off");
  why_ = exchange_.problem();
  const bool late = clock_.now() > std::max(off_asked_at_, warm_at_) + kOffGrace;
  take(late ? Event::PowerOffLate : Event::PowerOffUnanswered);
}

void ProjectorPower::ask_whether_off() {
  if (!table_.power) return;
  exchange_.ask(*table_.power, [this](const Answer& answer) {
    // A projector that is warming up may not report itself as on yet.
    if (clock_.now() < warm_at_) return;
    if (answer.says(ReplyMeaning::Off)) take(Event::PowerOffConfirmed);
  });
}

void ProjectorPower::make_dark() {
  wiring_.make_dark([this](ProjectorReply reply) {
    reply_ = reply;
    take(reply == ProjectorReply::Ok ? Event::LightIsOff : Event::LightOffFailed);
  });
}

void ProjectorPower::note_off() {
  warm_at_ = {};
  wiring_.light_is_off();
}

void ProjectorPower::watch_over() {
  off_at_.reset();
  watch_later();
}

void ProjectorPower::watch_later() {
  if (table_.power) watch_ = clock_.call_after(kWatchInterval, [this] { ask_whether_still_on(); });
}

// Asks by itself, because a projector whose lamp fails, or that turns itself off, may not report that.
void ProjectorPower::ask_whether_still_on() {
  watch_later();
  // A request under way reveals as much as this question would.
  if (!on() || exchange_.lost() || !exchange_.idle()) return;
  if (!wiring_.may_ask(table_.power->timeout + table_.gap)) return;
  const auto heard = [this](const Answer& answer) {
    const bool says_off = answer.says(ReplyMeaning::Off);
    if (!on() || exchange_.lost() || (answer.reply != ProjectorReply::NoAnswer && !says_off)) return;
    if (says_off)
      exchange_.note_problem(exchange_.called() + " says that it is off, although it was not turned off");
    went_off(exchange_.problem());
  };
  // Light off may drop this question where it is a command itself, which reveals as much.
  exchange_.ask(*table_.power, heard, !table_.light_off);
}

void ProjectorPower::tell_refused(const std::string& why) {
  exchange_.note_problem(why);
  tell(ProjectorReply::Refused);
}

}  // namespace contourd
