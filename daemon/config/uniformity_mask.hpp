// The picture that evens out a projector's light, as a printer's file names it. Thread-safe (no shared
// state).
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

// Nothing where the printer's file names none. Blocks. Adds to the printer's document what is wrong with it,
// and a warning where the old key names it. `folder` is the file's.
[[nodiscard]] std::optional<UniformityMask> load_uniformity_mask(JsonDocument& printer,
                                                                 const std::filesystem::path& folder);

}  // namespace contourd
