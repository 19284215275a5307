// A mask that was passed to the display, and its origin. ShownMask only refers to the mask: the function that
// returns it says how long it stays valid.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/mask/mask.hpp"

namespace contourd {

struct ShownMask {
  const Mask* mask = nullptr;           // null if no mask is shown
  std::uint64_t number = 0;             // running number of the masks of one process, from 1
  std::string_view name{};              // the job's name, or the picture's
  std::optional<std::int32_t> layer{};  // from 0; nullopt if the mask belongs to no layer
  Nanometers cut_at{};                  // height above the plate at which the layer was cut
};

}  // namespace contourd
