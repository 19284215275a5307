// What the simulated printer is made of, and what goes wrong with it.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct SimulatedAxisConfig {
  Nanometers travel{160'000'000};
  double microsteps_per_mm = 800.0;  // positions are whole steps
  MillimetersPerSecond homing_speed{5.0};
  MillimetersPerSecondSquared acceleration{25.0};
  Nanometers start_height{40'000'000};  // where the plate stands at power-up, unknown to the daemon

  enum class Switch { Works, StuckOpen, StuckClosed };
  Switch limit_switch = Switch::Works;
};

struct SimulatedDisplayConfig {
  Pixels width{1920};
  Pixels height{1080};
  Duration frame{16'666'667};  // one refresh: a mask is on the screen at the next multiple of it
  std::optional<std::filesystem::path> masks;  // each job's masks go to a folder of its own in here
  std::optional<int> lost_after_frames;        // it is unplugged, once, after that many masks
  std::optional<Duration> back_after;          // and plugged in again this much later
};

struct SimulatedProjectorConfig {
  Duration warm_up{std::chrono::seconds{5}};
  Duration reply{std::chrono::milliseconds{20}};
  Duration timeout{std::chrono::seconds{2}};  // after which a projector that does not answer is given up
  std::optional<int> silent_after_commands;   // it answers that many commands, then never again
};

struct SimulatedPrinterConfig {
  SimulatedAxisConfig axis;
  SimulatedDisplayConfig display;
  SimulatedProjectorConfig projector;
  std::optional<Duration> lid_opened_after_light;  // once, when the light has been on for that long in all
  Duration lid_open_for{std::chrono::seconds{10}};
};

}  // namespace contourd
