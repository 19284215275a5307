// Probes for a display: for one that was lost, or for any that is connected. For a thread that may block. May
// take 300 ms and more, and 10 s and more when the driver hangs. From any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hw/drm/card.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/drm/output.hpp"

namespace contourd {

// What came of it.
struct DisplayProbe {
  std::shared_ptr<Output> output;  // where there is one, back or not; black if it is, else off
  bool is_back = false;
  std::string refusal{};  // back, but of no use: a sentence
  std::optional<std::string> console_warning{};
};

// At an output that was lost, and which nobody else has.
[[nodiscard]] DisplayProbe restored(std::shared_ptr<Output> output, const DrmDisplayConfig& config);

// Opens whatever is connected. No output where there is none, or its card is not ready yet.
[[nodiscard]] DisplayProbe probe_all(const DrmDisplayConfig& config);

// Throws HardwareError.
[[nodiscard]] DisplayProbe open_display(FoundOutput found, const DrmDisplayConfig& config);

}  // namespace contourd
