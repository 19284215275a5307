// Bytes to a device and bytes back, without blocking: a serial port, or a test's idea of one. Event loop's
// thread only.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "hw/clock.hpp"

namespace contourd {

class ByteChannel {
 public:
  struct Listener {
    std::function<void(std::string_view)> bytes;   // have come, in any portions
    std::function<void(const std::string&)> lost;  // once: the device is gone; one sentence says why
  };

  ByteChannel() = default;
  ByteChannel(const ByteChannel&) = delete;
  ByteChannel& operator=(const ByteChannel&) = delete;
  virtual ~ByteChannel() = default;

  // As an owner knows it: "/dev/ttyUSB0".
  [[nodiscard]] virtual const std::string& name() const = 0;

  // Bytes and losses go to this listener from now on. It is not called from inside any function here.
  virtual void listen(Listener listener) = 0;

  // Hands all bytes over for sending and returns at once. False when the device does not take them.
  [[nodiscard]] virtual bool write(std::string_view bytes) noexcept = 0;

  // Sends and blocks: until the bytes have left (a second at most), then for `pause`. For the way out, when
  // no event loop runs any more.
  virtual void write_and_wait(std::string_view bytes, Duration pause) noexcept = 0;

  // The device's, for another process that is to send something; -1 when it has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
};

}  // namespace contourd
