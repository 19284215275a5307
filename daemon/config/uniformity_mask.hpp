// Loads the picture that evens out a projector's light. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <optional>

#include "core/mask/mask.hpp"
#include "daemon/json/json_document.hpp"

namespace contourd {

struct UniformityMask {
  std::filesystem::path file;
  Mask mask;
};

// Returns the mask that the printer's file names, or nullopt. Blocks. Adds violations to the printer's
// document if the mask is unusable. `folder` is the folder of the printer's file.
[[nodiscard]] std::optional<UniformityMask> load_uniformity_mask(JsonDocument& printer,
                                                                 const std::filesystem::path& folder);

}  // namespace contourd
