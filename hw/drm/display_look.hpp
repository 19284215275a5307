// A look at a display that is lost, or at one that there may be: what is done about it where blocking is
// allowed. May take 300 ms and more, and 10 s and more when the driver hangs. From any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hw/drm/card.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/drm/output.hpp"

namespace contourd {

// What came of it.
struct DisplayLook {
  std::shared_ptr<Output> output;  // where there is one, back or not; black if it is, else off
  bool is_back = false;
  std::string refusal{};  // back, but of no use: a sentence
  std::optional<std::string> console_warning{};
};

// At an output that was lost. REQUIRES: nobody else has it.
[[nodiscard]] DisplayLook relit(std::shared_ptr<Output> output, const DrmDisplayConfig& config);

// At whatever is connected. No output where there is none, or its card is only just coming.
[[nodiscard]] DisplayLook found_anywhere(const DrmDisplayConfig& config);

// Throws HardwareError.
[[nodiscard]] DisplayLook opened(FoundOutput found, const DrmDisplayConfig& config);

}  // namespace contourd
