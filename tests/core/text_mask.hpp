// Masks written as text: a string for each row, a character for each pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mask/mask_runs.hpp"

namespace contourd::testing {

// Makes a mask of text: '.' is dark, a digit d has the grey value 25 d + 30, '#' is fully lit.
inline Mask mask_of(const std::vector<std::string>& rows) {
  Mask mask(Pixels{static_cast<std::int32_t>(rows[0].size())},
            Pixels{static_cast<std::int32_t>(rows.size())});
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < rows[y].size(); ++x) {
      const char c = rows[y][x];
      mask.row(static_cast<std::int32_t>(y))[x] = static_cast<std::uint8_t>(c == '.'   ? 0
                                                                            : c == '#' ? 255
                                                                                       : 25 * (c - '0') + 30);
    }
  }
  return mask;
}

inline MaskRuns runs_of(const Mask& mask) {
  MaskRuns runs;
  runs.extract(mask);
  return runs;
}
inline MaskRuns runs_of(const std::vector<std::string>& rows) {
  return runs_of(mask_of(rows));
}

}  // namespace contourd::testing
