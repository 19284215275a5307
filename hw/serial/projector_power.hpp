// A serial projector's power: takes what happens through the table of projector_power_states.hpp and does
// what its rows say. Event loop's thread only.
//
// It has many functions, each of a few lines: one for each effect that is more than a call.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hw/clock.hpp"
#include "hw/machine.hpp"
#include "hw/projector.hpp"
#include "hw/serial/command_exchange.hpp"
#include "hw/serial/projector_power_states.hpp"

namespace contourd {

class ProjectorPower {
 public:
  using Done = Projector::Done;

  // What it needs of the projector's light, and who wants to know.
  struct Wiring {
    std::function<void()> light_off;  // as its owner would
    std::function<void()> suspect_light;
    std::function<void(Done)> make_dark;  // suspect_light, and whether it is off then
    std::function<void()> light_is_off;   // since its power is
    // Whether a question that takes so long delays no light off.
    std::function<bool(Duration)> may_ask;
    std::function<void(MachineEvent::Kind, const std::string&)> report;
  };

  // Exchange, clock and table must outlive it. `brightness` is sent after every warm-up.
  ProjectorPower(CommandExchange& exchange, Clock& clock, const ProjectorTable& table,
                 std::optional<ProjectorCommand> brightness, Wiring wiring);

  // Where two wait, only the later one is answered.
  void turn_on(Done done);
  void turn_off();
  void turn_off_if_on();
  // What waits for power is dropped.
  void drop();

  void power_on_sent(TimePoint first_byte) { warm_at_ = first_byte + table_.warm_up; }
  void may_warm_up() { warm_at_ = clock_.now() + table_.warm_up; }
  // The projector says by itself that it is off. Ignored when it was told to.
  void went_off(const std::string& what);

  [[nodiscard]] bool on() const { return is_on(state_); }
  [[nodiscard]] bool off() const { return is_off(state_); }
  [[nodiscard]] bool off_waits() const { return is_turned_off(state_); }
  // Until then its answers are those of a projector that warms up.
  [[nodiscard]] TimePoint warm_at() const { return warm_at_; }

 private:
  using Answer = CommandExchange::Answer;
  using State = ProjectorPowerState;
  using Event = ProjectorPowerEvent;
  using Effect = ProjectorPowerEffect;

  void take(Event event);
  void carry_out(Effect effect);
  void ask(bool known_on, std::function<Event(const Answer&)> meaning);
  [[nodiscard]] Event meaning_of(const Answer& answer) const;
  [[nodiscard]] Event whether_ready(const Answer& answer) const;
  [[nodiscard]] TimePoint ready_by(TimePoint start) const;
  void ask_left_on();
  void wait_until_cool();
  void wait_until_warm();
  void wait(Duration time, Event event = Event::PauseOver);
  void send_power_on();
  void set_brightness();
  void send_power_off();
  void power_off_answered(const Answer& answer);
  void ask_whether_off();
  void make_dark();
  void note_off();
  void watch_over();
  void watch_later();
  void ask_whether_still_on();
  void tell(ProjectorReply reply);
  void tell_refused(const std::string& why);

  CommandExchange& exchange_;
  Clock& clock_;
  const ProjectorTable& table_;
  const std::optional<ProjectorCommand> brightness_;
  const Wiring wiring_;
  State state_ = State::Unknown;
  Done done_;
  ProjectorReply reply_ = ProjectorReply::Ok;  // to what the state waited for
  std::string why_;                            // it is off, or its lamp may be on
  std::optional<TimePoint> off_at_;            // power off was answered last, or not
  TimePoint warm_at_{};
  TimePoint ready_by_{};          // the latest that it may say no
  TimePoint off_asked_at_{};      // first
  std::unique_ptr<Timer> timer_;  // of the state
  std::unique_ptr<Timer> watch_;  // to the next question whether it is still on
};

}  // namespace contourd
