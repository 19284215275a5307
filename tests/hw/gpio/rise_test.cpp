// Tests of rises: the step thread's pulses, and the axis around them.
#include "hw/gpio/gpio_axis.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/hw/rises.hpp"

namespace {

constexpr double kRiseStepsPerMm = 800;

// A homed plant that follows plans from where its plate is.
struct RisingPlant : HomedPlant {
  explicit RisingPlant(const GpioAxisConfig& of = screw_config()) : HomedPlant(of) {}

  void start(const RisePlan& plan) {
    pulses.clear();
    result.reset();
    axis->rise(plan, [this](MoveResult r) { result = r; });
  }
  std::optional<MoveResult> rise(const RisePlan& plan) {
    start(plan);
    run([this] { return result.has_value(); });
    return result;
  }
  [[nodiscard]] Nanometers at() const { return axis->height().value(); }

  std::optional<MoveResult> result;
};

RisePlan usual_rise(Nanometers from = Nanometers{0}) {
  const double low = in_mm(from);
  return {{rise_point(low, 0), rise_point(low + 0.1, 0.5), rise_point(low + 2, 0.5),
           rise_point(low + 2.2, 0.05), rise_point(low + 2.3, 0)}};
}

}  // namespace

TEST_CASE("The planned times of a rise's microsteps are those of a numerical integration, each once") {
  CHECK(rc::check([] {
    for (int plans = 0; plans < 20; ++plans) {
      const Nanometers from{draw(0, 40'000) * 1'250};
      const RisePlan plan = draw_rise(from + Nanometers{draw(-600, 600)}, 12);
      const double origin = in_mm(from) * kRiseStepsPerMm;
      const RiseCurve curve(plan, kRiseStepsPerMm, origin);
      const auto total = std::llround(curve.end());
      StepPlanner steps(total, curve, {1'600, 20'000});
      const double tolerance = 2e-4 * curve.duration_s() + 1e-9;
      Duration last{-1};
      for (std::int64_t k = 0; k < total; ++k, steps.advance()) {
        RC_ASSERT(!steps.finished());
        RC_ASSERT(steps.next() > last);
        last = steps.next();
        if (k % 50 != 0) continue;
        const double due = rise_time(plan, (origin + static_cast<double>(k) + 0.5) / kRiseStepsPerMm);
        RC_ASSERT(std::fabs(in_seconds(last) - due) <= tolerance);
        RC_ASSERT(steps.due_by(last + 1ns) == k + 1);  // times are rounded to a nanosecond
      }
      RC_ASSERT(steps.finished());
      RC_ASSERT(last <= steps.duration());
    }
  }));
}

TEST_CASE("Each microstep of a rise comes at the time that a numerical integration gives, and none twice") {
  CHECK(rc::check([] {
    RisingPlant plant;
    for (int plans = 0; plans < 3; ++plans) {
      const RisePlan plan = draw_rise(plant.at(), 12);
      const std::int64_t from = plant.plate();
      RC_ASSERT(plant.rise(plan) == MoveResult::Reached);
      const auto total = std::llround(in_mm(plan.points.back().height) * kRiseStepsPerMm) - from;
      RC_ASSERT(plant.plate() == from + total);
      RC_ASSERT(std::ssize(plant.pulses) == total);
      const auto due = [&](std::int64_t step) {
        return rise_time(plan, (static_cast<double>(from + step) + 0.5) / kRiseStepsPerMm);
      };
      const double whole = rise_time(plan, 1'000);
      const TimePoint first = plant.pulses.front();
      for (std::int64_t k = 1; k < total; k += 1 + total / 40) {
        const double apart = in_seconds(plant.pulses[static_cast<std::size_t>(k)] - first);
        // The integration; the thread looks every 10 ms, is 20 us late and may be early by nothing.
        RC_ASSERT(std::fabs(apart - (due(k) - due(0))) <= 2e-4 * whole + 40e-6);
      }
      RC_ASSERT(plant.axis->late_steps().count == 0);
    }
  }));
}

TEST_CASE("The height at a time ahead within a rise is the one that the plate has then, to the microstep") {
  CHECK(rc::check([] {
    RisingPlant plant;
    for (int plans = 0; plans < 3; ++plans) {
      const RisePlan plan = draw_rise(plant.at(), 12);
      plant.start(plan);
      const auto whole = Duration{static_cast<Duration::rep>(rise_time(plan, 1'000) * 1e9)};
      plant.run_for(1ms);  // the plate has approached the rise's start
      for (int looks = 0; looks < 20 && !plant.result; ++looks) {
        const TimePoint then = plant.clock.now() + whole * draw(1, 100) / 1'000;
        const Nanometers height = plant.axis->height_at(then).value();
        plant.run_for(then - plant.clock.now());
        RC_ASSERT(std::llabs((plant.at() - height).count()) <= 1'250);
      }
      plant.run([&] { return plant.result.has_value(); });
      RC_ASSERT(plant.result == MoveResult::Reached);
    }
  }));
}

TEST_CASE("A rise that is stopped anywhere slows down within the axis' acceleration and knows its height") {
  CHECK(rc::check([] {
    RisingPlant plant;
    for (int plans = 0; plans < 3; ++plans) {
      const RisePlan plan = draw_rise(plant.at(), 12);
      const double whole = rise_time(plan, 1'000);
      const RiseCurve curve(plan, kRiseStepsPerMm, 0);
      const TimePoint begun = plant.clock.now();
      plant.start(plan);
      plant.run_for(Duration{static_cast<Duration::rep>(draw_real(0, whole) * 1e9)});
      const std::int64_t then = plant.plate();
      plant.axis->stop();
      const double speed = curve.at(in_seconds(plant.clock.now() - begun)).speed;
      plant.run([&] { return plant.result.has_value(); });
      const bool at_end = plant.at() >= plan.points.back().height - Nanometers{625};
      RC_ASSERT((plant.result == MoveResult::Stopped || (at_end && plant.result == MoveResult::Reached)));
      // 50 mm/s2; the step that is due, and the rounding to whole steps.
      RC_ASSERT(static_cast<double>(plant.plate() - then) <= speed * speed / (2 * 50 * 800) + 2);
      RC_ASSERT(std::llabs(plant.at().count() - plant.plate() * 1'250) == 0);
      RC_ASSERT(plant.move_to(in_mm(plant.at()) + 0.1) == MoveResult::Reached);
    }
  }));
}

TEST_CASE("A late step shifts the rest of a rise, which makes no step twice and none in a burst") {
  for (const Duration held : {1ms, 20ms, 400ms, 3'000ms}) {
    CAPTURE(in_seconds(held));
    RisingPlant plant;
    plant.start(usual_rise());
    plant.run_for(1s);
    plant.hold_up_steps(held);
    const TimePoint ahead = plant.clock.now() + held + 500ms;
    plant.run_for(held + 100ms);
    const Nanometers foreseen = plant.axis->height_at(ahead).value();
    plant.run_for(ahead - plant.clock.now());
    CHECK(std::llabs((plant.at() - foreseen).count()) <= 1'250);
    plant.run([&] { return plant.result.has_value(); });
    CHECK(plant.result == MoveResult::Reached);
    CHECK(plant.plate() == 1'840);
    CHECK(std::ssize(plant.pulses) == 1'840);
    // At 0.5 mm/s a step has 2.5 ms: only a step that is later than a quarter of that shifts the rest.
    CHECK(plant.axis->late_steps().count <= 1);
    if (held > 10ms) CHECK(plant.axis->late_steps().count == 1);
    Duration shortest = 1s;
    for (std::size_t i = 1; i < plant.pulses.size(); ++i)
      shortest = std::min(shortest, plant.pulses[i] - plant.pulses[i - 1]);
    CHECK(shortest >= 2'500us * 3 / 4);  // 0.5 mm/s
    CHECK(plant.events.empty());
  }
}

TEST_CASE("A rise that the axis cannot follow, or that starts elsewhere, is refused and nothing moves") {
  const auto refused = [](RisePlan plan, GpioAxisConfig config = screw_config()) {
    RisingPlant plant(config);
    const auto result = plant.rise(plan);
    CHECK(plant.pulses.empty());
    CHECK_FALSE(plant.axis->moving());
    return result;
  };
  const auto with = [](std::size_t point, double height, double speed) {
    RisePlan plan = usual_rise();
    plan.points[point] = rise_point(height, speed);
    return plan;
  };
  CHECK(refused({}) == MoveResult::PlanRefused);
  CHECK(refused(with(1, 0.1, 2.6)) == MoveResult::PlanRefused);    // half the homing speed is 2.5 mm/s
  CHECK(refused(with(1, 0.002, 0.5)) == MoveResult::PlanRefused);  // 62 mm/s2
  CHECK(refused(with(0, -0.1, 0)) == MoveResult::OutsideTravel);
  CHECK(refused(with(4, 100.001, 0)) == MoveResult::OutsideTravel);
  CHECK(refused(usual_rise(mm(0.002))) == MoveResult::PlanRefused);
  GpioAxisConfig slow = screw_config();
  slow.top_speed = MillimetersPerSecond{0.4};
  CHECK(refused(usual_rise(), slow) == MoveResult::PlanRefused);

  BuiltPlant unhomed;
  std::optional<MoveResult> result;
  unhomed.axis->rise(usual_rise(), [&](MoveResult r) { result = r; });
  unhomed.run([&] { return result.has_value(); });
  CHECK(result == MoveResult::NotHomed);
  CHECK(unhomed.pulses.empty());
}

TEST_CASE("A rise takes up the screw's backlash before it starts, also after a stopped move downwards") {
  GpioAxisConfig config = screw_config();
  config.backlash = Nanometers{50'000};
  RisingPlant plant(config);
  plant.slack = 40;
  REQUIRE(plant.move_to(10) == MoveResult::Reached);
  std::optional<MoveResult> moved;
  plant.axis->move_to(mm(2), MillimetersPerSecond{2}, [&](MoveResult r) { moved = r; });
  plant.run_for(1s);
  plant.axis->stop();
  plant.run([&] { return moved.has_value(); });
  const Nanometers from = plant.at();
  CHECK(plant.rise(usual_rise(from)) == MoveResult::Reached);
  CHECK(plant.at() - from == mm(2.3));
  CHECK(plant.pulses.size() == 1'840 + 40);
}

TEST_CASE("An encoder that lags behind a rise ends it as a fault") {
  RisingPlant plant(with_encoder(EncoderConfig::Policy::Fault));
  CHECK(plant.rise(usual_rise()) == MoveResult::Reached);
  plant.start(usual_rise(plant.at()));
  plant.run_for(1s);
  plant.dead = true;
  plant.run([&] { return plant.result.has_value(); });
  CHECK(plant.result == MoveResult::Fault);
  CHECK_FALSE(plant.axis->height());
  REQUIRE(plant.events.size() == 1);
  CHECK(plant.events[0].kind == MachineEvent::Kind::Fault);
}

TEST_CASE("The emergency stop, an abort and the switch at the top end a rise") {
  GpioAxisConfig config = with_second_switch();
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "25", false}};
  SECTION("An emergency stop that lasts") {
    RisingPlant plant(config);
    plant.start(usual_rise());
    plant.run_for(1s);
    plant.press(AxisInput::EmergencyStop, true);
    plant.run([&] { return plant.result.has_value(); });
    CHECK(plant.result == MoveResult::Fault);
    CHECK(plant.pulses.size() < 500);
  }
  SECTION("A disturbance of the emergency stop: the rise does not go on by itself") {
    RisingPlant plant(config);
    plant.start(usual_rise());
    plant.run_for(1s);
    plant.press(AxisInput::EmergencyStop, true);
    plant.run_for(1ms);
    plant.press(AxisInput::EmergencyStop, false);
    plant.run([&] { return plant.result.has_value(); });
    CHECK(plant.result == MoveResult::Stopped);
    CHECK(plant.at().count() == plant.plate() * 1'250);
    CHECK(plant.plate() < 500);
  }
  SECTION("An abort") {
    RisingPlant plant(config);
    plant.start(usual_rise());
    plant.run_for(1s);
    plant.axis->abort();
    const auto made = plant.pulses.size();
    plant.run_for(5s);
    CHECK(plant.pulses.size() == made);
    CHECK_FALSE(plant.result);
    CHECK_FALSE(plant.axis->height());
    CHECK(plant.home() == HomingResult::Homed);
  }
  SECTION("The second switch") {
    RisingPlant plant(config);
    plant.second.at = plant.plate() + 800;
    CHECK(plant.rise(usual_rise()) == MoveResult::Fault);
    CHECK(plant.pulses.size() < 810);
  }
}
