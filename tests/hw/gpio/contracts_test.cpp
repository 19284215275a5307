// Tests that the functions of hw/gpio check their preconditions.
#include "hw/gpio/homing.hpp"
#include "hw/gpio/plate_approach.hpp"
#include "hw/gpio/plate_position.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/gpio/step_planner.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"

namespace {

constexpr MotionLimits kLimits{1'000, 10'000};

}  // namespace

TEST_CASE("StepPlanner requires a non-negative number of steps, and a step of the move") {
  CHECK(contract_broken_by([] { StepPlanner(-1, kLimits); }) == "the distance is not negative");
  StepPlanner plan(2, kLimits);
  CHECK(contract_broken_by([&] { (void)plan.due(2); }).empty());
  for (const std::int64_t step : {-1, 3})
    CHECK(contract_broken_by([&] { (void)plan.due(step); }) == "the step is one of the move's");
  plan.advance();
  CHECK(contract_broken_by([&] { (void)plan.next(); }).empty());
  plan.advance();
  if (!testing::costly_checks_are_off())
    CHECK(contract_broken_by([&] { (void)plan.next(); }) == "a step is still to be made");
}

TEST_CASE("StepEngine's functions for the event loop require that no move is under way") {
  testing::PlantOutput step, direction;
  StepEngine engine(step, direction, {});
  engine.start({10, kLimits});
  const std::string idle = "no move is under way";
  CHECK(contract_broken_by([&] { engine.start({10, kLimits}); }) == idle);
  CHECK(contract_broken_by([&] { engine.forget_halt(); }) == idle);
  CHECK(contract_broken_by([&] { engine.set_position(0); }) == idle);
  CHECK(contract_broken_by([&] { (void)engine.last_end(); }) == idle);
}

TEST_CASE("StepEngine's checks allocate no memory") {
  testing::PlantOutput step, direction;
  StepEngine engine(step, direction, {});
  const long before = testing::allocations();
  engine.forget_halt();
  engine.set_position(3);
  (void)engine.last_end();
  CHECK(testing::allocations() == before);
}

TEST_CASE("GpioAxis requires that it does not move before homing and moves") {
  testing::Plant plant{GpioAxisConfig{}};
  plant.build();
  plant.axis->home([](HomingResult) {});
  CHECK(contract_broken_by([&] { plant.axis->home([](HomingResult) {}); }) == "the axis does not move");
  CHECK(contract_broken_by([&] {
          plant.axis->move_to(Nanometers{0}, MillimetersPerSecond{1}, [](MoveResult) {});
        }) == "the axis does not move");
  const auto nudge = [&plant](Nanometers way) {
    plant.axis->nudge(way, MillimetersPerSecond{1}, [](MoveResult) {});
  };
  CHECK(contract_broken_by([&] { nudge(Nanometers{1}); }) == "the axis does not move");
  const auto raise = [&plant](Nanometers distance) {
    plant.axis->raise(distance, MillimetersPerSecond{1}, [](MoveResult) {});
  };
  CHECK(contract_broken_by([&] { raise(Nanometers{1}); }) == "the axis does not move");
  CHECK(contract_broken_by([&] { plant.axis->assume_height(Nanometers{1}); }) == "the axis does not move");
  plant.axis->abort();
  for (const Nanometers distance : {Nanometers{-1}, plant.axis->travel() + Nanometers{1}})
    CHECK(contract_broken_by([&] { raise(distance); }) == "the plate rises within its travel");
  for (const int way : {2'000'001, -2'000'001})
    CHECK(contract_broken_by([&] { nudge(Nanometers{way}); }) == "a nudge is short");
}

TEST_CASE("PlatePosition requires a resting motor, and an encoder before its position is taken") {
  testing::PlantOutput step, direction;
  StepEngine engine(step, direction, {});
  const AxisInputs inputs(engine, {});
  PlatePosition position(GpioAxisConfig{}, engine, inputs);
  CHECK(contract_broken_by([&] { position.take_encoder(); }) == "the axis has an encoder");
  engine.start({10, kLimits});
  const std::string rests = "the motor rests";
  CHECK(contract_broken_by([&] { position.note_rest(); }) == rests);
  CHECK(contract_broken_by([&] { position.take_switch(TimePoint{}); }) == rests);
  CHECK(contract_broken_by([&] { position.become_known(); }) == rests);
}

TEST_CASE("Homing requires that none is under way before it begins") {
  const GpioAxisConfig config;
  Homing::Wiring wiring;
  wiring.forget_position = [] {};
  wiring.get_ready = [](const Homing::Call&) {};
  Homing homing(config, wiring);
  homing.begin([](HomingResult) {});
  CHECK(contract_broken_by([&] { homing.begin([](HomingResult) {}); }) == "no homing is under way");
}
