// A mask that the display was given, and what it is of. A reference: whoever tells it says for how long it is
// valid.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/mask/mask.hpp"

namespace contourd {

struct ShownMask {
  const Mask* mask = nullptr;           // null: none
  std::uint64_t number = 0;             // of all that one has shown, from 1
  std::string_view name{};              // of the job, or of the picture
  std::optional<std::int32_t> layer{};  // from 0; nothing where it is no layer's
  Nanometers cut_at{};                  // the layer's, above the plate
};

}  // namespace contourd
