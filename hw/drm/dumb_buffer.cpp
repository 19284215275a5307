#include "hw/drm/dumb_buffer.hpp"

#include <drm_fourcc.h>
#include <sys/mman.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cerrno>
#include <cstring>

#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

[[noreturn]] void fail(const Card& card, const std::string& what) {
  throw HardwareError(card.name() + " " + what + ": " + std::strerror(errno));
}

}  // namespace

std::uint32_t fourcc_of(PixelFormat format) {
  return format == PixelFormat::Xrgb8888 ? DRM_FORMAT_XRGB8888 : DRM_FORMAT_RGB565;
}

DumbBuffer::DumbBuffer(const Card& card, Pixels width, Pixels height, PixelFormat format) : fd_(card.fd()) {
  const auto bits = static_cast<std::uint32_t>(bytes_per_pixel(format) * 8);
  std::uint64_t size = 0;
  if (drmModeCreateDumbBuffer(fd_, static_cast<std::uint32_t>(width.count()),
                              static_cast<std::uint32_t>(height.count()), bits, 0, &handle_, &stride_bytes_,
                              &size) != 0)
    fail(card, "has no memory for a picture of " + std::to_string(width.count()) + "x" +
                   std::to_string(height.count()));
  memory_ = mapped(size);
  if (!memory_.empty()) return;
  const int error = errno;
  drmModeDestroyDumbBuffer(fd_, handle_);
  errno = error;
  fail(card, "cannot map its memory");
}

std::span<std::byte> DumbBuffer::mapped(std::size_t size) const {
  std::uint64_t offset = 0;
  if (drmModeMapDumbBuffer(fd_, handle_, &offset) != 0) return {};
  void* at = ::mmap(nullptr, size, PROT_WRITE, MAP_SHARED, fd_, static_cast<off_t>(offset));
  if (at == MAP_FAILED) return {};
  return {static_cast<std::byte*>(at), size};
}

DumbBuffer::~DumbBuffer() {
  ::munmap(memory_.data(), memory_.size());
  drmModeDestroyDumbBuffer(fd_, handle_);
}

Framebuffer::Framebuffer(const Card& card, Pixels width, Pixels height, PixelFormat format)
    : fd_(card.fd()),
      buffer_(card, width, height, format),
      writer_({width, height, buffer_.stride_bytes(), format}, buffer_.memory()) {
  const std::uint32_t handles[4] = {buffer_.handle()}, strides[4] = {buffer_.stride_bytes()}, offsets[4] = {};
  if (drmModeAddFB2(fd_, static_cast<std::uint32_t>(width.count()),
                    static_cast<std::uint32_t>(height.count()), fourcc_of(format), handles, strides, offsets,
                    &id_, 0) != 0)
    fail(card, "does not support the wanted pixel format");
}

Framebuffer::~Framebuffer() {
  drmModeRmFB(fd_, id_);
}

}  // namespace contourd
