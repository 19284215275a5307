// The configuration of the simulated printer, and of the faults that it simulates.
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

  bool homes_upwards = false;  // the limit switch is at the top of the travel

  enum class Switch { Works, StuckOpen, StuckClosed };
  Switch limit_switch = Switch::Works;
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
