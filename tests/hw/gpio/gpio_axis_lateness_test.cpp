// Tests of an axis whose step thread is delayed: the motor comes to rest meanwhile, and the known position of
// the plate must be true.

#include "hw/gpio/gpio_axis.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"
#include "tests/random_shapes.hpp"

namespace {

// 4,000 steps/s at homing speed. The motor can start and stop dead up to half of it, 2,000, and a little
// beyond, since its speed is not known to the step.
constexpr double kPullIn = 2'300;

GpioAxisConfig late_config(std::optional<EncoderConfig::Policy> encoder = std::nullopt,
                           bool s_curve = false) {
  GpioAxisConfig config = encoder ? testing::with_encoder(*encoder) : testing::screw_config();
  if (s_curve) config.jerk_mm_s3 = 500;
  return config;
}

// The plate's position according to the axis, if it is known.
bool believed_is_true(const Plant& plant, Nanometers within = Nanometers{0}) {
  const auto height = plant.axis->height();
  return !height || std::llabs(height->count() - plate_above_switch(plant) * 1'250) <= within.count();
}

std::size_t notices(const Plant& plant) {
  return static_cast<std::size_t>(
      std::count_if(plant.events.begin(), plant.events.end(),
                    [](const MachineEvent& d) { return d.kind == MachineEvent::Kind::Notice; }));
}

}  // namespace

TEST_CASE(
    "A motor that was delayed at speed stops stepping and reports its position as unknown, with figures") {
  for (const bool s_curve : {false, true}) {
    for (const Duration held : {100ms, 1'000ms, 4'000ms}) {
      Plant plant(late_config(std::nullopt, s_curve));
      plant.pull_in = kPullIn;
      plant.build_homed();
      std::size_t made = 0;
      const auto hold_up = plant.clock.call_after(2s, [&] {
        plant.hold_up_steps(held);
        made = plant.pulses.size();
      });
      CHECK(plant.move_to(50) == MoveResult::Fault);
      CHECK(plant.pulses.size() == made);
      CHECK_FALSE(plant.axis->height());
      REQUIRE(plant.events.size() == 1);
      CHECK(plant.events[0].kind == MachineEvent::Kind::Fault);
      const std::string ms = std::to_string(held / 1ms - 1);  // 1 ms less: the next step was due later
      INFO(plant.events[0].what << " for " << ms);
      CHECK(plant.events[0].what.find("at 5 mm/s a step came ") != std::string::npos);
      CHECK(plant.move_to(1) == MoveResult::NotHomed);
      CHECK(plant.home() == HomingResult::Homed);
      CHECK(plate_above_switch(plant) == 0);
    }
  }
}

TEST_CASE("Up to its pull-in speed a delayed motor ramps up again and its position stays known") {
  Plant plant(late_config());
  plant.pull_in = kPullIn;
  plant.build_homed();
  const auto hold_up = plant.clock.call_after(2s, [&] { plant.hold_up_steps(3s); });
  CHECK(plant.move_to(20, 2.5) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 16'000);
  CHECK(plant.axis->height() == Nanometers{20'000'000});
  CHECK(plant.events.empty());
}

TEST_CASE("Homing continues after its motor was delayed, reports that, and is exact") {
  for (const Duration at : {300ms, 1'200ms, 1'700ms, 2'500ms, 3'500ms}) {
    Plant plant(late_config());
    plant.pull_in = kPullIn;
    plant.build();
    const auto hold_up = plant.clock.call_after(at, [&] { plant.hold_up_steps(700ms); });
    CHECK(plant.home() == HomingResult::Homed);
    CHECK(plate_above_switch(plant) == 0);
    CHECK(plant.events.size() == notices(plant));
    if (at == 300ms) CHECK(notices(plant) == 1);
  }
}

TEST_CASE("With an encoder a move continues after a delay, and the encoder tells whether steps were lost") {
  for (const double pull_in : {kPullIn, 1e9}) {
    for (const auto policy : {EncoderConfig::Policy::Fault, EncoderConfig::Policy::Correct}) {
      HomedPlant plant(late_config(policy));
      plant.pull_in = pull_in;
      bool told_at_once = false;
      const auto hold_up = plant.clock.call_after(1s, [&] { plant.hold_up_steps(1s); });
      const auto look = plant.clock.call_after(2'020ms, [&] { told_at_once = notices(plant) == 1; });
      CHECK(plant.move_to(10) == MoveResult::Reached);
      CHECK(told_at_once);
      CHECK(plant.events.size() == 1);
      CHECK(believed_is_true(plant));
      CHECK(std::llabs(plate_above_switch(plant) - 8'000) <= 1);  // the step at which the motor overran
    }
  }
}

TEST_CASE("With an encoder, steps lost in a delay are a fault or are corrected, by policy") {
  for (const auto policy : {EncoderConfig::Policy::Fault, EncoderConfig::Policy::Correct}) {
    HomedPlant plant(late_config(policy));
    int lost = 0;
    const auto hold_up = plant.clock.call_after(1s, [&] {
      plant.hold_up_steps(1s);
      plant.loses_step = [&] { return lost < 64 && ++lost > 0; };  // 80 um
    });
    const auto result = plant.move_to(10);
    if (policy == EncoderConfig::Policy::Correct) {
      CHECK(result == MoveResult::Reached);
      CHECK(plate_above_switch(plant) == 8'000);
      CHECK(notices(plant) == 2);
    } else {
      CHECK(result == MoveResult::Fault);
      CHECK_FALSE(plant.axis->height());
    }
  }
}

TEST_CASE(
    "After delays about as long as the motor needs to come to rest, its position is either true or unknown") {
  struct Case {
    double mm_s;
    Duration at, limit;  // the limit is 16 intervals at the speed at that time, at most 5 ms
  };
  for (const Case& c : {Case{4.7, 300ms, 4'260us}, Case{4.7, 773ms, 4'880us}, Case{4.7, 810ms, 5'000us},
                        Case{10, 300ms, 2'000us}, Case{10, 400ms, 2'550us}}) {
    for (Duration held = c.limit * 9 / 10; held < c.limit * 23 / 20; held += 50us) {
      Plant plant(late_config());
      plant.pull_in = kPullIn;
      plant.build_homed();
      const auto hold_up = plant.clock.call_after(c.at, [&] { plant.hold_up_steps(held); });
      INFO("at " << c.mm_s << " mm/s, after " << c.at / 1ms << " ms, held up for " << held / 1us << " us");
      (void)plant.move_to(3.57, c.mm_s);
      CHECK(believed_is_true(plant));
    }
  }
}

TEST_CASE("However the step thread is delayed, the plate's position is either true or unknown") {
  CHECK(rc::check([] {
    Plant plant(late_config(std::nullopt, draw(0, 1) != 0));
    plant.pull_in = kPullIn;
    plant.build();
    RC_ASSERT(plant.home() == HomingResult::Homed);
    for (int i = 0; i < 3; ++i) {
      const Duration held = draw(0, 1) != 0 ? std::chrono::microseconds{draw(0, 8'000)}
                                            : Duration{std::chrono::milliseconds{draw(0, 4'000)}};
      const auto hold_up = plant.clock.call_after(std::chrono::milliseconds{draw(0, 1'500)},
                                                  [&plant, held] { plant.hold_up_steps(held); });
      std::unique_ptr<Timer> stop;
      if (draw(0, 1) != 0)
        stop = plant.clock.call_after(std::chrono::milliseconds{draw(0, 3'000)}, [&] { plant.axis->stop(); });
      const double target = draw_real(0, 8), speed = draw_real(0.5, 10);
      (void)plant.move_to(target, speed);
      RC_ASSERT(believed_is_true(plant));
      stop.reset();
      if (!plant.axis->height()) RC_ASSERT(plant.home() == HomingResult::Homed);
    }
  }));
}
