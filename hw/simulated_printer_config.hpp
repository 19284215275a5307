// The configuration of the simulated printer, and of the faults that it simulates.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The force on the plate, and the line that is active while it exceeds a threshold of 1 N. The film is a
// spring of 5 N/mm: a layer lets go once the plate has stretched it far enough.
struct SimulatedForceConfig {
  Nanometers contact_from{2'000'000};  // as in ForceConfig
  double pixel_mm = 0.05;
  double peel_kpa = 20;  // a layer lets go at area x (area / (5 mm x perimeter))^(1/3) x this
  std::optional<int> part_lost_after_lifts{};  // peels after which the part stays on the film
  std::optional<Nanometers> obstruction{};     // height of something on the film, met once
  int obstruction_after_lifts = 0;             // peels after which it lies there

  enum class Line { Works, StuckInactive, StuckActive };
  Line line = Line::Works;
};

struct SimulatedAxisConfig {
  Nanometers travel{160'000'000};
  double microsteps_per_mm = 800.0;  // positions are whole steps
  MillimetersPerSecond homing_speed{5.0};
  MillimetersPerSecondSquared acceleration{25.0};
  Nanometers start_height{40'000'000};  // where the plate stands at power-up, unknown to the daemon

  bool homes_upwards = false;  // the limit switch is at the top of the travel

  enum class Switch { Works, StuckOpen, StuckClosed };
  Switch limit_switch = Switch::Works;
  std::optional<SimulatedForceConfig> force;  // nullopt: there is no line
};

struct SimulatedDisplayConfig {
  Pixels width{1920};
  Pixels height{1080};
  Duration frame{16'666'667};  // one refresh: a mask is on the screen at the next multiple of this
  std::optional<std::filesystem::path> masks;  // folder in which each job's masks get a folder of their own
  std::optional<int> lost_after_frames;        // number of masks after which it is unplugged, once
  std::optional<Duration> back_after;          // time after which it is plugged in again
};

struct SimulatedProjectorConfig {
  Duration warm_up{std::chrono::seconds{5}};
  Duration reply{std::chrono::milliseconds{20}};
  Duration timeout{std::chrono::seconds{2}};  // time after which the wait for an answer is given up
  std::optional<int> silent_after_commands;   // number of commands that it answers before it falls silent
};

struct SimulatedPrinterConfig {
  SimulatedAxisConfig axis;
  SimulatedDisplayConfig display;
  SimulatedProjectorConfig projector;
  std::optional<Duration> lid_opened_after_light;  // once, when the light has been on for this long in total
  Duration lid_open_for{std::chrono::seconds{10}};
};

}  // namespace contourd
