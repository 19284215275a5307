#include "hw/serial/projector_light.hpp"

#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {

ProjectorLight::ProjectorLight(CommandExchange& exchange, Clock& clock, const ProjectorTable& table,
                               Wiring wiring)
    : exchange_(exchange), clock_(clock), table_(table), wiring_(std::move(wiring)) {}

// Sends light on without retries, because one that may have been obeyed is not sent again.
void ProjectorLight::turn_on(Duration exposure, Projector::LightOn tell) {
  expects(table_.light_on && table_.light_off, "the table has a light on and off");
  expects(dark(), "the light is known to be off");
  exposure_ = exposure;
  tell_ = std::move(tell);
  exchange_.ask({.command = &*table_.light_on,
                 .done = [this](const Answer& answer) { light_on_answered(answer); },
                 .retries = 0});
}

void ProjectorLight::forget_last() {
  dark_ = nullptr;
  last_.reset();
}

void ProjectorLight::when_dark(std::function<void()> call) {
  dark_ = std::move(call);
  tell_dark();
}

void ProjectorLight::drop() {
  tell_ = {};
  whether_dark_ = nullptr;
  tell_sent_.reset();
}

std::string ProjectorLight::light_off_unconfirmed() const {
  if (!may_be_on()) return {};
  return overdue() ? off_problem_ : exchange_.called() + " has not confirmed that its light is off";
}

bool ProjectorLight::leaves_time_for(Duration duration) const {
  if (off_waits()) return false;
  const bool lit = last_ && !last_->off_earliest;
  return !lit || clock_.now() + duration <= last_->on_earliest + exposure_;
}

void ProjectorLight::take(Event event) {
  const ProjectorLightTransition* const row = projector_light_table().find(state_, event);
  if (row == nullptr) return;
  state_ = row->next(state_);
  for (const Effect effect : row->done())
    carry_out(effect);
}

void ProjectorLight::carry_out(Effect effect) {
  switch (effect) {
    case Effect::SendLightOff:
      return send_light_off(true);
    case Effect::RepeatLightOff:
      return send_light_off(false);
    case Effect::RetryLater:
      return retry_later();
    case Effect::StopSending:
      return stop_sending();
    case Effect::AskWhetherLit:
      return ask_whether_lit();
    case Effect::AskWhetherOn:
      return ask_whether_on();
    case Effect::NoteLightOn:
      return tell_sent();
    case Effect::NoteLit:
      last_->on_latest = clock_.now();
      return;
    case Effect::NoteDark:
      if (last_ && !last_->off_latest) last_->off_latest = clock_.now();
      return;
    case Effect::DropLightOn:
      if (table_.light_on) exchange_.drop(*table_.light_on);
      return;
    case Effect::TellLit:
      return answer_on(ProjectorReply::Ok);
    case Effect::TellUnlit:
      return answer_on(on_reply_);
    case Effect::TellDark:
      return tell_dark();
    case Effect::TellConfirmed:
      return answer_off(ProjectorReply::Ok);
    case Effect::TellUnconfirmed:
      return answer_off(off_reply_);
    case Effect::ReportOverdue:
      return wiring_.report(MachineEvent::Kind::Fault, "the light may be on: " + off_problem_);
    case Effect::ReportDark:
      return wiring_.report(MachineEvent::Kind::Recovery,
                            exchange_.called() + " has confirmed that its light is off");
  }
}

void ProjectorLight::light_on_sent(TimePoint first_byte) {
  last_ = LightSpan{first_byte + table_.latency, {}, {}, {}};
  on_reply_ = ProjectorReply::NoAnswer;
  take(Event::LightOnSent);
}

void ProjectorLight::light_on_answered(const Answer& answer) {
  on_reply_ = answer.reply;
  const bool accepted = answer.reply == ProjectorReply::Ok;
  if (accepted && !answer.ambiguous) return take(Event::LightOnConfirmed);
  if (accepted) exchange_.note_problem(exchange_.called() + " has not confirmed that its light is on");
  const bool sent = last_.has_value();
  if (answer.reply != ProjectorReply::Refused && sent && table_.light) return take(Event::LightOnUnanswered);
  take(accepted ? Event::LightOnAmbiguous : Event::LightOnFailed);
}

void ProjectorLight::ask_whether_lit() {
  exchange_.ask(*table_.light, [this, problem = exchange_.problem()](const Answer& answer) {
    if (answer.says(ReplyMeaning::On)) return take(Event::SaysLit);
    exchange_.note_problem(problem);
    on_reply_ = ProjectorReply::NoAnswer;
    take(Event::SaysUnlit);
  });
}

// Sends light off; with `new_request`, replies to earlier light offs do not confirm it, because light may
// have come on in between. An overdue light off gets no retries, so that it does not keep power off waiting.
void ProjectorLight::send_light_off(bool new_request) {
  retry_.reset();
  if (new_request) off_id_ = exchange_.new_id();
  exchange_.ask_first({.command = &*table_.light_off,
                       .done = [this](const Answer& answer) { light_off_answered(answer); },
                       .retries = overdue() ? 0 : table_.retries,
                       .if_ambiguous = CommandExchange::Ambiguous::SendsAgainAnyway,
                       .id = off_id_});
}

void ProjectorLight::stop_sending() {
  retry_.reset();
  exchange_.drop_first();
}

void ProjectorLight::light_off_answered(const Answer& answer) {
  if (answer.reply == ProjectorReply::Ok) return take(Event::LightOffConfirmed);
  off_reply_ = answer.reply;
  if (exchange_.lost()) return take(Event::LineLost);
  if (answer.begun < wiring_.warm_at()) return take(Event::LightOffTooEarly);
  off_problem_ = exchange_.problem();
  take(unconfirmed(answer));
}

// Returns the event of a light off that was not confirmed. Many projectors do not confirm it while they are
// off.
ProjectorLight::Event ProjectorLight::unconfirmed(const Answer& answer) const {
  const bool refused = answer.reply == ProjectorReply::Refused;
  if (answer.garbled) return refused && table_.power ? Event::LightOffUnclear : Event::LightOffGarbled;
  if (!table_.power) return Event::LightOffFailed;
  return refused ? Event::LightOffRefused : Event::LightOffUnanswered;
}

void ProjectorLight::ask_whether_on() {
  exchange_.ask(*table_.power, [this](const Answer& power) {
    const Event event = whether_on(power);
    if (event != Event::SaysOff) exchange_.note_problem(off_problem_);
    take(event);
  });
}

ProjectorLight::Event ProjectorLight::whether_on(const Answer& power) const {
  // A projector that is warming up may not report itself as on yet.
  if (may_be_on() && clock_.now() < wiring_.warm_at()) return Event::SaysTooEarly;
  if (power.says(ReplyMeaning::Off)) return Event::SaysOff;
  return power.reply == ProjectorReply::Ok || power.garbled ? Event::SaysOn : Event::SaysNothing;
}

void ProjectorLight::tell_dark() {
  if (!dark_) return;
  tell_dark_ = clock_.call_after(Duration{0}, [this] {
    if (!dark()) return;  // called again once it is dark
    if (const auto call = std::exchange(dark_, nullptr)) call();
  });
}

}  // namespace contourd
