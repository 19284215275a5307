// A serial projector's light: looks each event up in the table of projector_light_states.hpp and carries out
// the effects of its row. Event loop's thread only.
//
// The state alone decides what happens; all other members only hold callbacks, their arguments and their
// times.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/clock.hpp"
#include "hw/machine.hpp"
#include "hw/projector.hpp"
#include "hw/serial/command_exchange.hpp"
#include "hw/serial/projector_light_states.hpp"

namespace contourd {

class ProjectorLight {
 public:
  struct Wiring {
    std::function<TimePoint()> warm_at;  // end of the warm-up; until then a refused light off is no fault
    std::function<void(MachineEvent::Kind, const std::string&)> report;
  };

  // The exchange, the clock and the table must outlive the light.
  ProjectorLight(CommandExchange& exchange, Clock& clock, const ProjectorTable& table, Wiring wiring);

  // Turns the light on, see Projector::light_on(). REQUIRES: the table has a light on and off; dark().
  void turn_on(Duration exposure, Projector::LightOn tell);
  // Turns the light off. REQUIRES: the table has a light off.
  void turn_off() {
    expects(table_.light_off.has_value(), "the table has a light off");
    take(Event::LightOffWanted);
  }
  // Forgets the last light on, because another is requested, which may not even be sent.
  void forget_last();
  void when_dark(std::function<void()> call);
  // Calls `done` when light off is confirmed, or has failed often enough. To be called after turn_off() or
  // suspect().
  void tell_whether_dark(Projector::Done done) { whether_dark_ = std::move(done); }
  // Drops the callbacks that wait for an answer.
  void drop();

  // Events.
  void light_on_sent(TimePoint first_byte);
  void light_off_sent(TimePoint first_byte) {
    if (last_ && !last_->off_earliest) last_->off_earliest = first_byte;
  }
  void power_on_sent() { take(Event::PowerOnSent); }
  void suspect() { take(Event::Suspected); }
  void power_is_off() { take(Event::PowerIsOff); }

  // True if the light is off as far as is known, and no light off is under way.
  [[nodiscard]] bool dark() const { return !may_be_on() && !off_waits(); }
  [[nodiscard]] bool may_be_on() const { return may_shine(state_); }
  [[nodiscard]] bool off_waits() const { return is_turned_off(state_); }
  [[nodiscard]] bool overdue() const { return is_overdue(state_); }
  // Returns why the light may be on; empty if it is off as far as is known.
  [[nodiscard]] std::string light_off_unconfirmed() const;
  [[nodiscard]] std::optional<LightSpan> last() const { return last_; }
  // True if no light off is under way, and the exposure of a light that is on lasts at least `duration` more.
  [[nodiscard]] bool leaves_time_for(Duration duration) const;

 private:
  using Answer = CommandExchange::Answer;
  using State = ProjectorLightState;
  using Event = ProjectorLightEvent;
  using Effect = ProjectorLightEffect;

  void take(Event event);
  void carry_out(Effect effect);
  void send_light_off(bool new_request);
  void retry_later() {
    retry_ = clock_.call_after(table_.light_off->timeout, [this] { take(Event::RetryDue); });
  }
  void stop_sending();
  void ask_whether_lit();
  void ask_whether_on();
  void light_on_answered(const Answer& answer);
  void light_off_answered(const Answer& answer);
  [[nodiscard]] Event unconfirmed(const Answer& answer) const;
  [[nodiscard]] Event whether_on(const Answer& power) const;
  void tell_sent() {
    tell_sent_ = clock_.call_after(Duration{0}, [this] { tell_.sent(last_->on_earliest); });
  }
  void tell_dark();
  void answer_on(ProjectorReply reply) {
    if (const auto done = std::exchange(tell_.done, nullptr)) done(reply);
  }
  void answer_off(ProjectorReply reply) {
    if (const auto done = std::exchange(whether_dark_, nullptr)) done(reply);
  }

  CommandExchange& exchange_;
  Clock& clock_;
  const ProjectorTable& table_;
  const Wiring wiring_;
  State state_ = State::Dark;
  CommandExchange::RequestId off_id_ = 0;
  std::string off_problem_;                  // why light off was not confirmed
  ProjectorReply on_reply_{}, off_reply_{};  // the last replies to light on and light off
  std::optional<LightSpan> last_;            // the light of the last turn_on(), once that was sent
  Duration exposure_{};                      // from the last turn_on()
  Projector::LightOn tell_;                  // from the last turn_on()
  Projector::Done whether_dark_;
  std::function<void()> dark_;  // from the last when_dark()
  std::unique_ptr<Timer> retry_, tell_sent_, tell_dark_;
};

}  // namespace contourd
