// What a display output is, for --check-hardware.
#pragma once

#include <optional>
#include <string>

#include "hw/drm/drm_display_config.hpp"

namespace contourd {

// What --check-hardware tells of an output.
struct DrmReport {
  std::string card, driver, connector, mode;
  std::string formats;                       // "XR24 RG16"
  std::optional<std::string> console;        // the text console on the same card: "/dev/fb0"
  std::optional<std::string> in_use;         // who has the card, so that the driver could not be asked
  std::optional<std::string> range_warning;  // black may be sent as 16: a sentence
  bool atomic = false;
  bool vblank = false;  // the driver tells when a picture is on the screen
};

// Finds what a DrmDisplay would use and asks the driver whether it would do it; changes nothing on any
// screen. Throws HardwareError as DrmDisplay does, also when nothing is connected.
[[nodiscard]] DrmReport check_drm_display(const DrmDisplayConfig& config);
// One line.
[[nodiscard]] std::string describe(const DrmReport& report);

}  // namespace contourd
