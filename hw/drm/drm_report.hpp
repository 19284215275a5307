// The description of a display output for --check-hardware.
#pragma once

#include <optional>
#include <string>

#include "hw/drm/drm_display_config.hpp"

namespace contourd {

// The facts about an output that --check-hardware prints.
struct DrmReport {
  std::string card, driver, connector, mode;
  std::string formats;                       // "XR24 RG16"
  std::optional<std::string> console;        // the text console on the same card: "/dev/fb0"
  std::optional<std::string> in_use;         // the program that has the card, so the driver was not asked
  std::optional<std::string> range_warning;  // black may be sent as 16: a sentence
  bool atomic = false;
  bool vblank = false;  // the driver reports when a picture is on the screen
};

// Finds the output that a DrmDisplay would use and asks the driver whether it would accept the mode. Changes
// nothing on any screen. Throws HardwareError as DrmDisplay does, and also if no display is connected.
[[nodiscard]] DrmReport check_drm_display(const DrmDisplayConfig& config);
// Returns the report as one line.
[[nodiscard]] std::string describe(const DrmReport& report);

}  // namespace contourd
