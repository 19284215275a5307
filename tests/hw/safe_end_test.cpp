#include "hw/safe_end.hpp"

#include "hw/gpio/step_engine.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"

namespace {

// A clock that is far past the next due step at every call.
TimePoint later() noexcept {
  static TimePoint time{};
  return time += std::chrono::milliseconds{5};
}

// Runs in a child process, because every step engine of a process stands still from then on.
void check_still(int steps_before) {
  testing::CountingLine step, direction;
  StepEngine engine(step, direction, {}, later);
  engine.start({100, {10, 1'000}});
  expects(engine.begin(), "the move begins");
  while (step.rises < steps_before)
    engine.act();
  make_safe_at_once();
  expects(engine.interrupted() && engine.running(), "the thread is woken");
  while (engine.running())
    engine.act();
  expects(step.rises == steps_before, "no further step is made");
  expects(engine.last_end() == StepEnd::Halted, "the move was halted");
  engine.enable();
  engine.forget_halt();
  engine.start({100, {10, 1'000}});
  while (engine.begin() || engine.running())
    engine.act();
  expects(step.rises == steps_before, "no step of a later move is made");
}

}  // namespace

TEST_CASE("A motor that was made safe at once makes no further step of any move") {
  CHECK(testing::contract_broken_by([] { check_still(0); }).empty());
  CHECK(testing::contract_broken_by([] { check_still(7); }).empty());
}
