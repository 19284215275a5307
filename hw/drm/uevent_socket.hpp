// The kernel's announcements that a graphics card's displays changed (a cable was plugged in or out), or that
// a card came or went: uevents by netlink, as udev gets them. Not thread-safe.
#pragma once

#include <span>

#include "hw/file_descriptor.hpp"

namespace contourd {

// Whether an announcement is about a graphics card. `text` is as the kernel sends it: "change@/devices/...",
// then KEY=value, each ended by a zero byte.
[[nodiscard]] bool is_about_displays(std::span<const char> text);

class UeventSocket {
 public:
  // Throws std::system_error.
  UeventSocket();

  [[nodiscard]] int fd() const { return fd_.get(); }

  // Reads all that wait. Whether one of them is about displays, or some were lost.
  [[nodiscard]] bool read_all();

 private:
  FileDescriptor fd_;
};

}  // namespace contourd
