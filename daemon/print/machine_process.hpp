// The base of the processes that drive the machine by a table of states: entering a state, its effects in
// their order, its timers, and the way of every fault into the table. Event loop's thread only.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "hw/machine.hpp"
#include "hw/state_table.hpp"

namespace contourd {

// The part of the base that needs no table: the machine, and the timers of the current state.
class StateTimers {
 public:
  StateTimers(const StateTimers&) = delete;
  StateTimers& operator=(const StateTimers&) = delete;

 protected:
  StateTimers(Machine& machine, Clock& clock) : machine_(machine), clock_(clock) {}
  virtual ~StateTimers() = default;

  // Ends what is under way because a device failed; `reason` is a sentence.
  virtual void fail(const std::string& reason) = 0;

  // Drops the timers and pending answers of the state before.
  void enter_state();
  // Returns a callback that does nothing once the state has changed, so that late answers are ignored. To be
  // called by an effect: it belongs to the state that is being entered.
  template <typename Answer>
  [[nodiscard]] std::function<void(Answer)> while_in_state(
      std::type_identity_t<std::function<void(Answer)>> call) {
    return [this, entered = states_entered_, call = std::move(call)](Answer answer) {
      if (entered == states_entered_) call(answer);
    };
  }
  // Fails with a sentence about `what` if the state lasts longer.
  void expect_within(Duration duration, const std::string& what);
  void expect_move(Nanometers distance, MillimetersPerSecond speed, const std::string& what);
  void expect_homing(MillimetersPerSecond speed);
  void stop_axis();
  // Makes the machine safe and drops the callback of when_dark(), which refers to this object.
  void make_machine_safe();

  Machine& machine_;
  Clock& clock_;
  std::unique_ptr<Timer> wait_, deadline_, picture_;
  bool light_asked_ = false;                // a light was requested and is not known to be off
  TimePoint light_end_{};                   // when the light's time is over, once its command is sent
  std::optional<TimePoint> estimated_end_;  // of the current state, if an effect knows it

 private:
  std::uint64_t states_entered_ = 0;
};

// Deadlines for a device that does not answer at all; otherwise a device reports its own failures.
inline constexpr Duration kProjectorDeadline = std::chrono::seconds{30};
// The wait for the light to be confirmed off at the end. The projector keeps trying after that.
inline constexpr Duration kDarkDeadline = std::chrono::seconds{5};
// A projector may have to cool down before it warms up, and again if it ignored the power-on command.
inline constexpr Duration kWarmUpDeadline = std::chrono::hours{1};

template <typename Row>
class MachineProcess : protected StateTimers {
 public:
  using State = typename Row::State;
  using Event = typename Row::Event;
  using Effect = typename Row::Effect;

  [[nodiscard]] State state() const { return state_; }

 protected:
  // All arguments must outlive the process.
  MachineProcess(Machine& machine, Clock& clock, const StateTable<Row>& table)
      : StateTimers(machine, clock), table_(table), state_(table.start) {}

  virtual void perform(Effect effect) = 0;
  // Called after the effects of an event's row. An exception counts as one of an effect.
  virtual void performed(Event) {}
  // Called if an effect threw; the light has been turned off. May throw the exception again.
  virtual void effect_threw(const std::string& what) { fail(what); }
  // Called at the end of a transition without exceptions. May handle another event.
  virtual void settled() {}

  [[nodiscard]] bool answers(Event event) const { return table_.find(state_, event) != nullptr; }

  void handle(Event event) {
    const Row* const row = table_.find(state_, event);
    if (row == nullptr) return;
    if (const State next = row->next(state_); next != state_) {
      enter_state();
      state_ = next;
    }
    try {
      for (const Effect effect : row->done())
        perform(effect);
      performed(event);
    } catch (const std::exception& error) {
      machine_.projector().light_off();
      return effect_threw(error.what());
    }
    settled();
  }
  void handle_at(TimePoint when, Event event) {
    wait_ = clock_.call_at(when, [this, event] { handle(event); });
  }
  void give_up_within(Duration duration) {
    deadline_ = clock_.call_after(duration, [this] { handle(Event::GaveUp); });
  }
  void power_on_projector() {
    expect_within(kWarmUpDeadline, "the projector's lamp to warm up");
    machine_.projector().power_on(while_in_state<ProjectorReply>([this](ProjectorReply reply) {
      if (reply == ProjectorReply::Ok) return handle(Event::ProjectorReady);
      fail("power on: " + machine_.projector().last_problem());
    }));
  }
  // Turns the light on for this long. `answered` is called with a reply other than Ok, which may come after
  // the command was sent, or after the light's time.
  void light_on_for(Duration time, std::function<void(ProjectorReply, const std::string& problem)> answered) {
    expect_within(kProjectorDeadline, "the light-on command to be sent to the projector");
    light_asked_ = true;
    const auto sent = while_in_state<TimePoint>([this, time](TimePoint earliest) {
      light_end_ = earliest + time;
      handle(Event::LightOnSent);
    });
    machine_.projector().light_on(
        time, {.sent = sent, .done = [this, answered = std::move(answered)](ProjectorReply reply) {
                 if (reply != ProjectorReply::Ok)
                   answered(reply, "light on: " + machine_.projector().last_problem());
               }});
  }

 private:
  const StateTable<Row>& table_;
  State state_;
};

}  // namespace contourd
