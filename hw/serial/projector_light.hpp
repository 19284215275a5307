// A serial projector's light: takes what happens through the table of projector_light_states.hpp and does
// what its rows say. Event loop's thread only.
//
// It has many functions, each of a few lines: one for each effect that is more than a call. Of its data all
// but the state is who is to be told what, and when.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

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
    std::function<TimePoint()> warm_at;  // until then a light off that is refused is no fault
    std::function<void(MachineEvent::Kind, const std::string&)> report;
  };

  // Exchange, clock and table must outlive it.
  ProjectorLight(CommandExchange& exchange, Clock& clock, const ProjectorTable& table, Wiring wiring);

  // See Projector. REQUIRES: the table has a light on and off; dark().
  void turn_on(Duration exposure, Projector::LightOn tell);
  // REQUIRES: the table has a light off.
  void turn_off() {
    expects(table_.light_off.has_value(), "the table has a light off");
    take(Event::LightOffWanted);
  }
  // Another light on is asked for than the one before, whether it comes to it or not.
  void forget_last();
  void when_dark(std::function<void()> call);
  // Calls `done` when light off is confirmed, or was not often enough; behind turn_off() or suspect().
  void tell_whether_dark(Projector::Done done) { whether_dark_ = std::move(done); }
  // Who waits for an answer is dropped.
  void drop();

  // What happens.
  void light_on_sent(TimePoint first_byte);
  void light_off_sent(TimePoint first_byte);
  void power_on_sent() { take(Event::PowerOnSent); }
  void suspect() { take(Event::Suspected); }
  void power_is_off() { take(Event::PowerIsOff); }

  // As far as anybody can tell, and no light off is under way.
  [[nodiscard]] bool dark() const { return !may_be_on() && !off_waits(); }
  [[nodiscard]] bool may_be_on() const { return may_shine(state_); }
  [[nodiscard]] bool off_waits() const { return is_turned_off(state_); }
  [[nodiscard]] bool overdue() const { return is_overdue(state_); }
  // Why it may be on; empty when it is off as far as anybody can tell.
  [[nodiscard]] std::string light_off_unconfirmed() const;
  [[nodiscard]] std::optional<LightSpan> last() const { return last_; }
  // No light off is under way, or due by the exposure that was asked for before `duration` is over.
  [[nodiscard]] bool leaves_time_for(Duration duration) const;

 private:
  using Answer = CommandExchange::Answer;
  using State = ProjectorLightState;
  using Event = ProjectorLightEvent;
  using Effect = ProjectorLightEffect;

  void take(Event event);
  void carry_out(Effect effect);
  void send_light_off(bool anew);
  void retry_later();
  void stop_sending();
  void ask_whether_lit();
  void ask_whether_on();
  void light_on_answered(const Answer& answer);
  void light_off_answered(const Answer& answer);
  [[nodiscard]] Event unconfirmed(const Answer& answer) const;
  [[nodiscard]] Event whether_on(const Answer& power) const;
  void tell_sent();
  void tell_dark();
  void tell_on(ProjectorReply reply);
  void tell_off(ProjectorReply reply);

  CommandExchange& exchange_;
  Clock& clock_;
  const ProjectorTable& table_;
  const Wiring wiring_;
  State state_ = State::Dark;
  CommandExchange::RequestId off_id_ = 0;
  std::string off_problem_;                  // why light off was not confirmed
  ProjectorReply on_reply_{}, off_reply_{};  // to light on and light off, the last
  std::optional<LightSpan> last_;            // of the last turn_on(), once that was sent
  Duration exposure_{};                      // that it was asked for
  Projector::LightOn tell_;                  // who asked for it
  Projector::Done whether_dark_;
  std::function<void()> dark_;  // asked for by when_dark()
  std::unique_ptr<Timer> retry_, tell_sent_, tell_dark_;
};

}  // namespace contourd
