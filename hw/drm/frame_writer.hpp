// Writes masks into a buffer that is scanned out, and of each only what differs from what the buffer holds.
// Such memory is write-combined: it takes whole cache lines in address order at full speed, and is very slow
// to read. So it is never read back; what it holds is known from a copy in ordinary memory.
// Not thread-safe. Allocates only in the constructor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/mask/mask.hpp"
#include "hw/drm/pixel_format.hpp"

namespace contourd {

class FrameWriter {
 public:
  // A row is compared and written in blocks of this many pixels: 64 bytes of XRGB8888, one cache line.
  static constexpr std::size_t kBlock = 16;

  struct Layout {
    Pixels width, height;
    std::size_t stride_bytes = 0;  // from one row to the next
    PixelFormat format = PixelFormat::Xrgb8888;
  };

  // Blackens the memory, which must outlive the writer. REQUIRES: memory holds height rows of stride_bytes,
  // of which each holds width pixels; it is aligned as a pixel is.
  FrameWriter(const Layout& layout, std::span<std::byte> memory);

  // Makes the memory show the mask. Returns how many bytes it wrote. REQUIRES: the mask has the layout's
  // size.
  std::size_t write(const Mask& mask) noexcept;
  // Writes black everywhere, whatever is there.
  void blacken() noexcept;

  // What the memory shows.
  [[nodiscard]] const Mask& content() const { return content_; }

 private:
  template <PixelFormat kFormat>
  std::size_t write_as(const Mask& mask) noexcept;

  Layout layout_;
  std::span<std::byte> memory_;
  Mask content_;
};

}  // namespace contourd
