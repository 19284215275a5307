// Memory that a card can scan out: a mapped dumb buffer and its framebuffer. Destroying the framebuffer frees
// all of it; the kernel turns off an output that still shows it. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hw/drm/card.hpp"
#include "hw/drm/frame_writer.hpp"

namespace contourd {

// Returns the kernel's code for the format, DRM_FORMAT_*.
[[nodiscard]] std::uint32_t fourcc_of(PixelFormat format);

// A buffer of the kernel's, mapped into this process.
class DumbBuffer {
 public:
  // Throws HardwareError. The card must outlive the buffer.
  DumbBuffer(const Card& card, Pixels width, Pixels height, PixelFormat format);
  ~DumbBuffer();
  DumbBuffer(const DumbBuffer&) = delete;
  DumbBuffer& operator=(const DumbBuffer&) = delete;

  [[nodiscard]] std::uint32_t handle() const { return handle_; }
  [[nodiscard]] std::uint32_t stride_bytes() const { return stride_bytes_; }
  // Returns memory that may be written but not read.
  [[nodiscard]] std::span<std::byte> memory() const { return memory_; }

 private:
  [[nodiscard]] std::span<std::byte> mapped(std::size_t size) const;

  int fd_;
  std::uint32_t handle_ = 0;
  std::uint32_t stride_bytes_ = 0;
  std::span<std::byte> memory_;
};

// A picture that can be put on an output.
class Framebuffer {
 public:
  // Makes a black picture. Throws HardwareError. The card must outlive the framebuffer.
  Framebuffer(const Card& card, Pixels width, Pixels height, PixelFormat format);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  [[nodiscard]] std::uint32_t id() const { return id_; }
  [[nodiscard]] FrameWriter& writer() { return writer_; }

 private:
  int fd_;
  DumbBuffer buffer_;
  FrameWriter writer_;
  std::uint32_t id_ = 0;
};

}  // namespace contourd
