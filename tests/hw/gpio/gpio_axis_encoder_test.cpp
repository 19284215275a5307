// Tests of an axis whose encoder loses counts, is disturbed, or has an index.

#include "hw/gpio/gpio_axis.hpp"

#include <random>

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"

namespace {

// Returns an axis with an encoder whose index, if it has one, is marked every 0.5 mm.
GpioAxisConfig corrected_config(EncoderConfig::Policy policy = EncoderConfig::Policy::Correct,
                                bool index = false) {
  GpioAxisConfig config = testing::with_encoder(policy);
  if (!index) return config;
  config.encoder->index = GpioLineConfig{"gpiochip0", "9", false};
  config.encoder->index_every = Nanometers{500'000};
  return config;
}

double plate_mm(const Plant& plant) {
  return static_cast<double>(testing::plate_above_switch(plant)) / 800;
}

// Prints layers of 50 um, each with a lift. True if all were reached.
bool prints(Plant& plant, int layers, double lift_mm = 0.6) {
  for (int layer = 1; layer <= layers; ++layer) {
    for (const double target : {0.05 * (layer - 1) + lift_mm, 0.05 * layer})
      if (plant.move_to(target) != MoveResult::Reached) return false;
  }
  return true;
}

constexpr double kTolerance_mm = 0.05, kStep_mm = 0.00125;

std::size_t told(const Plant& plant, MachineEvent::Kind kind, const std::string& words) {
  return static_cast<std::size_t>(
      std::count_if(plant.events.begin(), plant.events.end(), [&](const MachineEvent& event) {
        UNSCOPED_INFO(event.what);
        return event.kind == kind && event.what.find(words) != std::string::npos;
      }));
}

}  // namespace

TEST_CASE("An encoder that loses a few counts in every lift does not make the plate drift in 200 layers") {
  for (const bool index : {false, true}) {
    HomedPlant plant(corrected_config(EncoderConfig::Policy::Correct, index));
    std::int64_t steps = 0;
    // 4 counts, 5 um, of the way down: 1 mm in 200 layers.
    plant.loses_count = [&] { return !plant.direction->level && ++steps % 110 == 0; };
    if (prints(plant, 200)) {
      CHECK(index);
      CHECK(std::fabs(plate_mm(plant) - 10) <= kTolerance_mm + kStep_mm);
    } else {
      CHECK(told(plant, MachineEvent::Kind::Fault, "the encoder") == 1);
      CHECK_FALSE(plant.axis->height());
    }
  }
}

TEST_CASE("However often an encoder loses counts, 200 layers end in a fault or within the tolerance",
          "[long]") {
  std::minstd_rand random(1);
  for (const unsigned one_in : {15U, 60U, 200U, 800U, 3'000U}) {
    for (const auto& [up, down] : {std::pair{true, false}, std::pair{false, true}, std::pair{true, true}}) {
      HomedPlant plant(corrected_config(EncoderConfig::Policy::Correct, up && down));
      plant.loses_count = [&, loses_up = up, loses_down = down] {
        return (plant.direction->level ? loses_up : loses_down) && random() % one_in == 0;
      };
      INFO("one in " << one_in << (up ? ", up" : "") << (down ? ", down" : ""));
      if (prints(plant, 200, 0.1)) {
        CHECK(std::fabs(plate_mm(plant) - 10) <= kTolerance_mm + kStep_mm);
      } else {
        CHECK(told(plant, MachineEvent::Kind::Fault, "the encoder") == 1);
      }
    }
  }
}

TEST_CASE("A correction is reported with its figures, and one beyond the limit is a fault") {
  HomedPlant plant(corrected_config());
  int lost = 0;
  for (int i = 1; i <= 4; ++i) {
    lost = 0;
    plant.loses_step = [&] { return lost < 100 && ++lost > 0; };  // 0.125 mm
    CHECK(plant.move_to(10.0 * i) == MoveResult::Reached);
    CHECK(plate_mm(plant) == 10.0 * i);
    CHECK(told(plant, MachineEvent::Kind::Notice, "corrected by further steps, ") ==
          static_cast<std::size_t>(i));
  }
  CHECK(plant.events[0].what ==
        "the encoder measures 9.875 mm but the motor's steps make 10.000 mm: steps were lost, or the encoder "
        "does not count; corrected by further steps, 0.125 mm in all since homing");
  lost = 0;
  CHECK(plant.move_to(60) == MoveResult::Fault);
  CHECK(told(plant, MachineEvent::Kind::Fault, "a correction of 0.625 mm since homing, and 0.500 mm") == 1);
  CHECK(plant.home() == HomingResult::Homed);  // resets the sum of corrections
  lost = 0;
  CHECK(plant.move_to(10) == MoveResult::Reached);
}

TEST_CASE("More lost steps in one move than may be corrected are a fault while the motor turns") {
  HomedPlant plant(corrected_config());
  plant.pulses.clear();
  plant.dead = true;
  CHECK(plant.move_to(10) == MoveResult::Fault);
  // 0.25 mm plus 0.05 mm, the distance at top speed in 5 ms, are 240 steps; 10 ms until the check add 40.
  CHECK(plant.pulses.size() <= 290);
}

TEST_CASE("Disturbed encoder lines are a fault while the motor turns, but a few spikes are not") {
  for (const auto policy : {EncoderConfig::Policy::Fault, EncoderConfig::Policy::Correct}) {
    for (const int spikes : {9, 12}) {
      HomedPlant plant(corrected_config(policy));
      std::vector<std::unique_ptr<Timer>> timers;
      for (int i = 0; i < spikes; ++i) {
        timers.push_back(
            plant.clock.call_after(1s + i * 10ms, [&] { plant.encoder_b->spike(plant.clock.now()); }));
      }
      // Each spike makes two illegal edges; 20 are allowed.
      if (spikes * 2 <= 20) {
        CHECK(plant.move_to(50) == MoveResult::Reached);
        CHECK(plant.events.empty());
        continue;
      }
      CHECK(plant.move_to(50) == MoveResult::Fault);
      CHECK(plate_mm(plant) < 10);
      CHECK(told(plant, MachineEvent::Kind::Fault, "impossible edges in one move") == 1);
      CHECK_FALSE(plant.axis->height());
    }
  }
}

TEST_CASE("An encoder whose index agrees causes no report, up and down, reversed or not") {
  for (const bool reversed : {false, true}) {
    Plant plant(corrected_config(EncoderConfig::Policy::Fault, true));
    plant.config.encoder->reversed = reversed;
    plant.counts_down = reversed;
    plant.build_homed();
    CHECK(prints(plant, 20));
    CHECK(plant.events.empty());
  }
}

TEST_CASE("A count that the index finds wrong is a fault, or is corrected to the mark, by policy") {
  for (const bool reversed : {false, true}) {
    for (const auto policy : {EncoderConfig::Policy::Fault, EncoderConfig::Policy::Correct}) {
      GpioAxisConfig c = corrected_config(policy, true);
      c.encoder->reversed = reversed;
      Plant plant(c);
      plant.counts_down = reversed;
      plant.build_homed();
      REQUIRE(plant.move_to(2) == MoveResult::Reached);
      int lost = 0;
      plant.loses_count = [&] { return lost < 60 && ++lost > 0; };  // 0.075 mm
      const auto result = plant.move_to(10);
      if (policy == EncoderConfig::Policy::Fault) {
        CHECK(result == MoveResult::Fault);
        continue;
      }
      CHECK(result == MoveResult::Reached);
      CHECK(told(plant, MachineEvent::Kind::Notice,
                 "(line 9 of gpiochip0) shows that its count is off by 0.075 mm") == 1);
      CHECK(plate_mm(plant) == 10);
      CHECK(plant.axis->height() == Nanometers{10'000'000});
    }
  }
}
