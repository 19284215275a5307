// Probes for a display: for one that was lost, or for any that is connected. A probe blocks for up to 300 ms
// or more, and for 10 s or more if the driver hangs. May be called from any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hw/drm/card.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/drm/output.hpp"

namespace contourd {

// The result of a probe.
struct DisplayProbe {
  std::shared_ptr<Output> output;  // black if is_back, else off; null if there is no output
  bool is_back = false;
  std::string refusal{};  // a sentence if the display is connected but cannot be used
  std::optional<std::string> console_warning{};
};

// Restores an output that was lost. The caller must not share it with another thread.
[[nodiscard]] DisplayProbe restored(std::shared_ptr<Output> output, const DrmDisplayConfig& config);

// Opens the display that the config selects. Returns no output if none is connected or its card is not ready
// yet.
[[nodiscard]] DisplayProbe probe_all(const DrmDisplayConfig& config);

// Blackens the text console and opens the output. Throws HardwareError.
[[nodiscard]] DisplayProbe open_display(FoundOutput found, const DrmDisplayConfig& config);

}  // namespace contourd
