// Tests that the real-time threads allocate no memory while the motor turns: their calls are made in one
// thread with the test's own clock.

#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/step_engine.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/counting_line.hpp"
#include "tests/hw/gpio/test_time.hpp"
#include "tests/hw/rises.hpp"

namespace {

// An input that delivers one edge on demand.
class TellingLine final : public InputLine {
 public:
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  [[nodiscard]] std::optional<bool> level() noexcept override { return level_; }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept override {
    if (!pending_ || edges.empty()) return 0;
    pending_ = false;
    edges[0] = {level_, test_time};
    return 1;
  }
  void toggle() {
    level_ = !level_;
    pending_ = true;
  }

 private:
  bool level_ = false, pending_ = false;
};

// A whole move, with an encoder edge at every step and a lid that opens and closes.
struct TurningMotor {
  TurningMotor() {
    AxisInputs::Lines lines;
    lines.contacts[static_cast<std::size_t>(AxisInput::Lid)] = {&lid, 1ms};
    lines.encoder_a = &encoder_a;
    lines.encoder_b = &encoder_b;
    inputs.emplace(engine, lines, testing::test_now);
  }
  // True if the move completed.
  bool run(std::int64_t steps, const MotionLimits& limits) { return run({steps, limits}); }
  bool run(const StepMove& move) {
    engine.start(move);
    if (!engine.begin()) return false;
    for (int made = 0; engine.running(); ++made) {
      test_time = std::max(test_time, engine.due());
      engine.act();
      (made % 2 == 0 ? encoder_a : encoder_b).toggle();
      if (made % 1'000 == 0) lid.toggle();
      (void)inputs->serve();
      while (inputs->take_change()) {
      }
    }
    return engine.last_end() == StepEnd::Completed;
  }

  testing::CountingLine step, direction;
  TellingLine lid, encoder_a, encoder_b;
  StepEngine engine{step, direction, {}, testing::test_now};
  std::optional<AxisInputs> inputs;
};

}  // namespace

TEST_CASE("Neither steps nor edges allocate memory, from the first one on") {
  TurningMotor motor;
  const MotionLimits trapezoid{4'000, 20'000};
  MotionLimits s_curve = trapezoid;
  s_curve.jerk = 400'000;
  for (const MotionLimits& limits : {trapezoid, s_curve}) {
    const long before = testing::allocations();
    const bool completed = motor.run(5'000, limits);
    const long taken = testing::allocations() - before;
    CHECK(completed);
    CHECK(taken == 0);
  }
  CHECK(motor.step.rises == 10'000);
  CHECK(std::abs(motor.inputs->encoder_count()) >= 10'000);
}

TEST_CASE("A rise of some thousand points allocates no memory, from its start to a stop or its end") {
  RisePlan plan;
  for (int i = 0; i <= 4'000; ++i)
    plan.points.push_back(testing::rise_point(0.002 * i, i % 4'000 == 0 ? 0 : 0.2 + 0.001 * (i % 7)));
  StepMove move{6'400, {4'000, 20'000}};
  move.rise = std::make_shared<const RiseCurve>(plan, 800, 0);
  TurningMotor motor;
  const long before = testing::allocations();
  const bool completed = motor.run(move);
  const long taken = testing::allocations() - before;
  CHECK(completed);
  CHECK(taken == 0);
  CHECK(motor.step.rises == 6'400);
}
