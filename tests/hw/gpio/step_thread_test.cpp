// Tests of the real threads in real time. Their delays depend on the computer; their results must not.
#include "hw/gpio/step_thread.hpp"

#include <sched.h>

#include <atomic>
#include <iostream>

#include "hw/gpio/axis_threads.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"
#include "tests/hw/gpio/pipe_input.hpp"

namespace {

// A step line whose steps keep the processor busy for too long; with the 100th step the switch closes.
class LaboriousLine final : public OutputLine {
 public:
  explicit LaboriousLine(PipeInput& contact) : contact_(contact) {}
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active && ++rises == 100) contact_.set(true);
    for (const TimePoint start = monotonic_now(); monotonic_now() < start + 100us;) {
    }
    return true;
  }
  std::atomic<int> rises{0};

 private:
  PipeInput& contact_;
};

// While it exists, this thread and the threads that it creates share one processor.
class OneProcessor {
 public:
  OneProcessor() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;
  ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }

 private:
  cpu_set_t before_{};
};

}  // namespace

TEST_CASE("The threads make a move's steps, then the next move's, and end when destroyed", "[threads]") {
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
    engine.forget_halt();
    engine.start({1'000'000, {1'000, 1'000'000}});  // the threads end during the move
  }
  CHECK_FALSE(engine.moving());
}

TEST_CASE("A switch halts the steps at the next one, even on a processor that they keep fully busy",
          "[threads]") {
  PipeInput contact;
  LaboriousLine step(contact);
  CountingLine direction;
  StepEngine engine(step, direction, {});
  AxisInputs::Lines lines;
  lines.contacts[static_cast<std::size_t>(AxisInput::LimitSwitch)] = {&contact, 5ms};
  AxisInputs inputs(engine, lines);
  const OneProcessor shared;
  const RealtimeAxisThreads threads(engine, inputs, 40);
  if (!threads.refusals().empty()) {
    std::cout << "SKIPPED: " << threads.refusals()[0] << '\n';
    return;
  }
  // Once the steps begin, no other thread runs on this processor.
  inputs.set_limit_rule(LimitRule::AtContact);
  engine.start({5'000, {20'000, 2'000'000}});
  while (engine.moving())
    engine.ended().wait();
  CHECK(engine.last_end() == StepEnd::Halted);
  CHECK(step.rises == 100);  // the step at which the switch closed
}

TEST_CASE("A refused priority is reported in a sentence, and the thread runs", "[threads]") {
  CountingLine step, direction;
  StepEngine engine(step, direction, {});
  const StepThread thread(engine, 1'000);  // the highest is 99
  REQUIRE_FALSE(thread.refusals().empty());
  CHECK(thread.refusals()[0].find("refuses real-time priority 1000 to the thread contourd-steps") !=
        std::string::npos);
  engine.start({10, {20'000, 2'000'000}});
  while (engine.moving())
    engine.ended().wait();
  CHECK(step.rises == 10);
}
