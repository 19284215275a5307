// The threads themselves, in real time: how long they wait is the machine's matter, what they do is not.
#include "hw/gpio/step_thread.hpp"

#include <atomic>

#include "hw/gpio/axis_threads.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

class CountingLine final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active) ++rises;
    return true;
  }
  std::atomic<int> rises{0};
};

}  // namespace

TEST_CASE("The threads make a move's steps, then the next move's, and end when told") {
  CountingLine step, direction;
  StepEngine engine(step, direction, {});
  AxisInputs inputs(engine, {});
  {
    const RealtimeAxisThreads threads(engine, inputs, 50);
    for (const std::int64_t steps : {200, -150}) {
      const int before = step.rises;
      engine.start({steps, {20'000, 2'000'000}});
      while (engine.moving())
        engine.ended().wait();
      engine.ended().clear();
      CHECK(engine.last_end() == StepEnd::Completed);
      CHECK(step.rises - before == std::abs(steps));
    }
    engine.start({1'000'000, {1'000, 1'000'000}});
    while (engine.position() < 60)
      sched_yield();
    engine.halt();
    const int made = step.rises;
    while (engine.moving())
      engine.ended().wait();
    CHECK(engine.last_end() == StepEnd::Halted);
    CHECK(step.rises == made);
    CHECK(engine.position() == 50 + made - 350);
    engine.ended().clear();
    engine.start({1'000'000, {1'000, 1'000'000}});  // the threads end under way
  }
  CHECK_FALSE(engine.moving());
}

TEST_CASE("A priority that the system refuses is told in a sentence, and the thread runs") {
  CountingLine step, direction;
  StepEngine engine(step, direction, {});
  const StepThread thread(engine, 1'000);  // there is none above 99
  REQUIRE_FALSE(thread.refusals().empty());
  CHECK(thread.refusals()[0].find("refuses real-time priority 1000 to the thread contourd-steps") !=
        std::string::npos);
  engine.start({10, {20'000, 2'000'000}});
  while (engine.moving())
    engine.ended().wait();
  CHECK(step.rises == 10);
}
