// A channel for bytes to and from a device, without blocking: a serial port, or a test's substitute for one.
// Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "hw/clock.hpp"
#include "hw/interface.hpp"

namespace contourd {

class ByteChannel : public Interface {
 public:
  struct Listener {
    std::function<void(std::string_view)> bytes;   // gets the bytes that have come, in any portions
    std::function<void(const std::string&)> lost;  // gets, once, a sentence that says why the device is gone
  };

  // Returns the device as a user knows it: "/dev/ttyUSB0".
  [[nodiscard]] virtual const std::string& name() const = 0;

  // Directs bytes and losses to this listener from now on. No function here calls it from inside.
  virtual void listen(Listener listener) = 0;

  // Hands all bytes over for sending and returns at once. False if the device does not take them.
  [[nodiscard]] virtual bool write(std::string_view bytes) noexcept = 0;

  // Sends the bytes, and blocks until they have left (a second at most) and then for `pause`. For the
  // shutdown, when no event loop runs any more.
  virtual void write_and_wait(std::string_view bytes, Duration pause) noexcept = 0;

  // Returns the device's descriptor, for another process that is to send something; -1 if it has none.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
};

}  // namespace contourd
