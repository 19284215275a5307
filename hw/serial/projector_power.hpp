// A serial projector's power: looks each event up in the table of projector_power_states.hpp and carries out
// the effects of its row. Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hw/clock.hpp"
#include "hw/machine.hpp"
#include "hw/projector.hpp"
#include "hw/serial/command_exchange.hpp"
#include "hw/serial/projector_power_states.hpp"

namespace contourd {

class ProjectorPower {
 public:
  using Done = Projector::Done;

  // Functions of the projector's light that its power needs, and the receiver of events.
  struct Wiring {
    std::function<void()> light_off;  // as Projector::light_off()
    std::function<void()> suspect_light;
    std::function<void(Done)> make_dark;  // suspect_light, then answers whether the light is off
    std::function<void()> light_is_off;   // called when the power is off, and so is the light
    // True if a question of this duration delays no light off.
    std::function<bool(Duration)> may_ask;
    std::function<void(MachineEvent::Kind, const std::string&)> report;
  };

  // The exchange, the clock and the table must outlive this object. `brightness` is sent after every warm-up.
  ProjectorPower(CommandExchange& exchange, Clock& clock, const ProjectorTable& table,
                 std::optional<ProjectorCommand> brightness, Wiring wiring);

  // Turns the projector on. Only the last call is answered, if an earlier one is still pending.
  void turn_on(Done done);
  void turn_off();
  void turn_off_if_on() {
    if (table_.power) take(Event::LeftOnSuspected);
  }
  // Drops a pending turn_on().
  void drop();

  void power_on_sent(TimePoint first_byte) { warm_at_ = first_byte + table_.warm_up; }
  void may_warm_up() { warm_at_ = clock_.now() + table_.warm_up; }
  // Notes that the projector says by itself that it is off. Ignored if it was told to turn off.
  void went_off(const std::string& what);

  [[nodiscard]] bool on() const { return is_on(state_); }
  [[nodiscard]] bool off() const { return is_off(state_); }
  [[nodiscard]] bool off_waits() const { return is_turned_off(state_); }
  // Returns the time until which the projector answers as one that is warming up.
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
  void wait_until_warm() {
    timer_ = clock_.call_at(warm_at_, [this] { take(Event::Warm); });
  }
  void wait(Duration time, Event event = Event::PauseOver) {
    timer_ = clock_.call_after(time, [this, event] { take(event); });
  }
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
  void tell(ProjectorReply reply) {
    if (const auto done = std::exchange(done_, nullptr)) done(reply);
  }
  void tell_refused(const std::string& why);

  CommandExchange& exchange_;
  Clock& clock_;
  const ProjectorTable& table_;
  const std::optional<ProjectorCommand> brightness_;
  const Wiring wiring_;
  State state_ = State::Unknown;
  Done done_;
  ProjectorReply reply_ = ProjectorReply::Ok;  // to the command that the state waited for
  std::string why_;                            // why the projector is off, or its lamp may be on
  std::optional<TimePoint> off_at_;            // when power off was last answered or given up
  TimePoint warm_at_{};
  TimePoint ready_by_{};          // until when the projector may say that it is not on
  TimePoint off_asked_at_{};      // when power off was first requested
  std::unique_ptr<Timer> timer_;  // for the current state
  std::unique_ptr<Timer> watch_;  // until the next question whether the projector is still on
};

}  // namespace contourd
