// Encodes masks as PNG pictures (ISO/IEC 15948), 8-bit grey, straight from their runs of equal pixels. A row
// equal to the one above is stored as a zero difference (filter Up), any other row unchanged (filter None).
//
// We have our own encoder because a general compressor looks at every byte: on masks 1920x1080 of a liver,
// libpng at its fastest level takes about twenty times as long (5 ms of CPU a mask; this one 0.25 ms), and
// its files are twice as large.
//
// Deterministic. Not thread-safe. Keeps its memory between calls: allocates only while pictures grow.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image/run_deflater.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

struct Rgb {
  std::uint8_t red = 0, green = 0, blue = 0;
};
// The colour shown for each grey value.
using Palette = std::array<Rgb, 256>;

class MaskPngEncoder {
 public:
  // Returns the file's bytes, at most 9/8 of the pixels plus 200, or plus 1200 with a palette. Valid until
  // the next call. Throws std::invalid_argument for a mask without pixels.
  [[nodiscard]] std::span<const std::uint8_t> encode(const Mask& mask, const Palette* palette = nullptr);

 private:
  void deflate_rows(const Mask& mask);

  RunDeflater deflater_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace contourd
