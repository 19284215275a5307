// Writes masks into a buffer that is scanned out; of each mask only the blocks that differ from the buffer's
// content. Such memory is write-combined: writing whole cache lines in address order is fast, reading is very
// slow. So the buffer is never read back; a copy in ordinary memory holds its content.
// Not thread-safe. Allocates only in the constructor.
#pragma once

#include <cstddef>
#include <span>

#include "core/mask/mask.hpp"
#include "hw/drm/drm_display_config.hpp"

namespace contourd {

class FrameWriter {
 public:
  // A row is compared and written in blocks of this many pixels: 64 bytes of XRGB8888, one cache line.
  static constexpr std::size_t kBlock = 16;

  struct Layout {
    Pixels width, height;
    std::size_t stride_bytes = 0;  // distance from one row to the next
    PixelFormat format = PixelFormat::Xrgb8888;
  };

  // Blackens the memory, which must outlive the writer. REQUIRES: the memory holds `height` rows of
  // stride_bytes bytes; a row holds `width` pixels; the memory is aligned to a pixel's size.
  FrameWriter(const Layout& layout, std::span<std::byte> memory);

  // Makes the memory show the mask. Returns the number of bytes written. REQUIRES: the mask has the layout's
  // size.
  std::size_t write(const Mask& mask) noexcept;
  // Writes black to the whole memory, including parts that are black already.
  void blacken() noexcept;

  // Returns the mask that the memory shows.
  [[nodiscard]] const Mask& content() const { return content_; }

 private:
  template <PixelFormat kFormat>
  std::size_t write_as(const Mask& mask) noexcept;

  Layout layout_;
  std::span<std::byte> memory_;
  Mask content_;
};

}  // namespace contourd
