#include "hw/gpio/plate_position.hpp"

#include <chrono>
#include <optional>

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::PlantInput;
using testing::PlantOutput;

namespace {

TimePoint bench_time{};  // global because StepEngine takes a plain function

// 800 steps and counts per mm; the switch at 0.5 mm, 400 steps; 40 steps of play.
GpioAxisConfig config(bool encoder = false, bool homes_upwards = false) {
  GpioAxisConfig config;
  config.switch_height = Nanometers{500'000};
  config.backlash = Nanometers{50'000};
  config.homes_upwards = homes_upwards;
  if (encoder) {
    config.encoder = EncoderConfig{};
    config.encoder->counts_per_mm = 800;
    config.encoder->policy = EncoderConfig::Policy::Correct;
  }
  return config;
}

struct Bench {
  explicit Bench(const GpioAxisConfig& axis_config) : position(axis_config, engine, inputs) {
    bench_time = TimePoint{1s};
  }

  // Makes `steps` steps, one per millisecond.
  void run(std::int64_t steps) {
    position.run_begins();
    engine.start({.steps = steps, .limits = {1'000, 1e9}});
    for (bool running = engine.begin(); running; running = engine.running()) {
      bench_time = std::max(bench_time, engine.due());
      engine.act();
    }
    position.note_rest();
  }
  // Moves the plate by `steps` counts of the encoder.
  void count(std::int64_t steps) {
    for (std::int64_t i = 0; i != steps; i += steps > 0 ? 1 : -1) {
      scale += steps > 0 ? 1 : -1;
      const auto phase = ((scale % 4) + 4) % 4;
      bench_time += 1ms;
      a.set(phase == 1 || phase == 2, bench_time);
      b.set(phase == 2 || phase == 3, bench_time);
      inputs.serve();
    }
    bench_time += 1ms;
    inputs.serve();
  }

  PlantOutput step, direction;
  PlantInput limit, a, b;
  std::int64_t scale = 0;
  StepEngine engine{step, direction, {}, []() noexcept { return bench_time; }};
  AxisInputs inputs{engine,
                    {.contacts = {AxisInputs::Contact{&limit, 5ms}}, .encoder_a = &a, .encoder_b = &b},
                    []() noexcept { return bench_time; }};
  PlatePosition position;
};

}  // namespace

TEST_CASE("A position is known from homing until it is forgotten") {
  Bench bench(config());
  CHECK_FALSE(bench.position.height());
  CHECK(bench.position.where().empty());
  bench.position.take_switch(bench_time);
  CHECK_FALSE(bench.position.height());
  bench.position.become_known();
  CHECK(bench.position.height() == Nanometers{500'000});
  CHECK(bench.position.where() == " at 0.500 mm");
  bench.position.forget();
  CHECK_FALSE(bench.position.height());
  CHECK_FALSE(bench.position.height_at(bench_time));
}

TEST_CASE("The position is taken at the switch's edge, however far the motor has moved since") {
  for (const bool upwards : {false, true}) {
    CAPTURE(upwards);
    const std::int64_t towards = upwards ? 1 : -1;
    Bench bench(config(false, upwards));
    bench.run(towards * 10);
    // The edge is between the seventh and the eighth step; three more follow.
    bench.position.take_switch(bench_time - 2'500us);
    bench.position.become_known();
    CHECK(bench.position.by_steps().plate() == Microsteps{400 + towards * 3});
    // The play is on the side that the motor came from.
    CHECK(bench.position.by_steps().play == Microsteps{upwards ? 0 : 40});
  }
}

TEST_CASE("Without an encoder the height follows from the steps and the screw's play") {
  Bench bench(config());
  bench.position.take_switch(bench_time);
  bench.position.become_known();
  bench.run(40);  // through the play, so the plate rests
  CHECK(bench.position.height() == Nanometers{500'000});
  bench.run(80);
  CHECK(bench.position.height() == Nanometers{600'000});
  bench.run(-20);
  CHECK(bench.position.height() == Nanometers{600'000});
  CHECK_FALSE(bench.position.has_encoder());
  CHECK_FALSE(bench.position.runaway());
  const AxisEncoder::Finding none = bench.position.compare_with_encoder();
  CHECK_FALSE(none.fault);
  CHECK_FALSE(none.notice);
}

TEST_CASE("With an encoder the height is the measured one, and take_encoder() sets the steps to it") {
  Bench bench(config(true));
  bench.inputs.serve();
  bench.position.take_switch(bench_time);
  bench.position.become_known();
  bench.position.move_begins();
  bench.run(120);   // the plate moves 80 steps
  bench.count(-8);  // the plate has moved the other way
  CHECK(bench.position.height() == Nanometers{490'000});
  CHECK(bench.position.by_steps().plate() == Microsteps{480});
  CHECK(bench.position.compare_with_encoder().notice);
  bench.position.take_encoder();
  CHECK(bench.position.by_steps().plate() == Microsteps{392});
  CHECK(bench.position.height() == Nanometers{490'000});
}
