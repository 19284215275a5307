#include "daemon/print/machine_process.hpp"

#include <fmt/format.h>

#include <chrono>

namespace contourd {
namespace {

// The time for coming to a standstill. A move gets its expected time, a tenth more, and this (Ember's
// figure). An axis reports its own failures; these timeouts catch an axis that does not answer at all.
constexpr Duration kStopTimeout = std::chrono::seconds{15};

}  // namespace

void StateTimers::enter_state() {
  ++states_entered_;
  wait_.reset();
  deadline_.reset();
  picture_.reset();
  estimated_end_.reset();
}

void StateTimers::expect_within(Duration duration, const std::string& what) {
  deadline_ = clock_.call_after(duration, [this, duration, what] {
    fail(fmt::format("timed out after {:.0f} s waiting for {}",
                     std::chrono::duration<double>(duration).count(), what));
  });
}

void StateTimers::expect_move(Nanometers distance, MillimetersPerSecond speed, const std::string& what) {
  expect_within(machine_.z_axis().move_duration(distance, speed) * 11 / 10 + kStopTimeout, what);
}

// Allows twice the time for the travel and 25 mm, which is more than any homing takes. Homing covers the
// travel at most once, and a few millimetres beyond it, back off the switch and to it again, partly at half
// the speed.
void StateTimers::expect_homing(MillimetersPerSecond speed) {
  constexpr Nanometers kExtra{25'000'000};
  const ZAxis& axis = machine_.z_axis();
  expect_within(axis.move_duration(axis.travel() + kExtra, speed) * 2 + kStopTimeout, "the axis to home");
}

void StateTimers::stop_axis() {
  expect_within(kStopTimeout, "the axis to stop");
  machine_.z_axis().stop();
}

void StateTimers::make_machine_safe() {
  make_safe(machine_);
  machine_.projector().when_dark({});
}

}  // namespace contourd
