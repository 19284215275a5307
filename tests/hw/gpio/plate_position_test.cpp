#include "hw/gpio/plate_position.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/test_time.hpp"

namespace {

// 800 steps and counts per mm; the switch at 0.5 mm, 400 steps; 40 steps of play.
GpioAxisConfig plate_position_config(bool encoder = false, bool homes_upwards = false) {
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

struct PlatePositionFixture {
  explicit PlatePositionFixture(const GpioAxisConfig& axis_config) : position(axis_config, engine, inputs) {
    test_time = TimePoint{1s};
  }

  // Makes `steps` steps, one per millisecond.
  void run(std::int64_t steps) {
    position.run_begins();
    engine.start({.steps = steps, .limits = {1'000, 1e9}});
    for (bool running = engine.begin(); running; running = engine.running()) {
      test_time = std::max(test_time, engine.due());
      engine.act();
    }
    position.note_rest();
  }
  // Moves the plate by `steps` counts of the encoder.
  void count(std::int64_t steps) {
    for (std::int64_t i = 0; i != steps; i += steps > 0 ? 1 : -1) {
      scale += steps > 0 ? 1 : -1;
      const auto phase = ((scale % 4) + 4) % 4;
      test_time += 1ms;
      a.set(phase == 1 || phase == 2, test_time);
      b.set(phase == 2 || phase == 3, test_time);
      inputs.serve();
    }
    test_time += 1ms;
    inputs.serve();
  }

  PlantOutput step, direction;
  PlantInput limit, a, b;
  std::int64_t scale = 0;
  StepEngine engine{step, direction, {}, testing::test_now};
  AxisInputs inputs{engine,
                    {.contacts = {AxisInputs::Contact{&limit, 5ms}}, .encoder_a = &a, .encoder_b = &b},
                    testing::test_now};
  PlatePosition position;
};

}  // namespace

TEST_CASE("A position is known from homing until it is forgotten") {
  PlatePositionFixture fixture(plate_position_config());
  CHECK_FALSE(fixture.position.height());
  CHECK(fixture.position.where().empty());
  fixture.position.take_switch(test_time);
  CHECK_FALSE(fixture.position.height());
  fixture.position.become_known();
  CHECK(fixture.position.height() == Nanometers{500'000});
  CHECK(fixture.position.where() == " at 0.500 mm");
  fixture.position.forget();
  CHECK_FALSE(fixture.position.height());
  CHECK_FALSE(fixture.position.height_at(test_time));
}

TEST_CASE("The position is taken at the switch's edge, however far the motor has moved since") {
  for (const bool upwards : {false, true}) {
    CAPTURE(upwards);
    const std::int64_t towards = upwards ? 1 : -1;
    PlatePositionFixture fixture(plate_position_config(false, upwards));
    fixture.run(towards * 10);
    // The edge is between the seventh and the eighth step; three more follow.
    fixture.position.take_switch(test_time - 2'500us);
    fixture.position.become_known();
    CHECK(fixture.position.by_steps().plate() == Microsteps{400 + towards * 3});
    // The play is on the side that the motor came from.
    CHECK(fixture.position.by_steps().play == Microsteps{upwards ? 0 : 40});
  }
}

TEST_CASE("Without an encoder the height follows from the steps and the screw's play") {
  PlatePositionFixture fixture(plate_position_config());
  fixture.position.take_switch(test_time);
  fixture.position.become_known();
  fixture.run(40);  // through the play, so the plate rests
  CHECK(fixture.position.height() == Nanometers{500'000});
  fixture.run(80);
  CHECK(fixture.position.height() == Nanometers{600'000});
  fixture.run(-20);
  CHECK(fixture.position.height() == Nanometers{600'000});
  CHECK_FALSE(fixture.position.has_encoder());
  CHECK_FALSE(fixture.position.runaway());
  const AxisEncoder::Finding none = fixture.position.compare_with_encoder();
  CHECK_FALSE(none.fault);
  CHECK_FALSE(none.notice);
}

TEST_CASE("With an encoder the height is the measured one, and take_encoder() sets the steps to it") {
  PlatePositionFixture fixture(plate_position_config(true));
  fixture.inputs.serve();
  fixture.position.take_switch(test_time);
  fixture.position.become_known();
  fixture.position.move_begins();
  fixture.run(120);   // the plate moves 80 steps
  fixture.count(-8);  // the plate has moved the other way
  CHECK(fixture.position.height() == Nanometers{490'000});
  CHECK(fixture.position.by_steps().plate() == Microsteps{480});
  CHECK(fixture.position.compare_with_encoder().notice);
  fixture.position.take_encoder();
  CHECK(fixture.position.by_steps().plate() == Microsteps{392});
  CHECK(fixture.position.height() == Nanometers{490'000});
}
