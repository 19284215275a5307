// The kernel's announcements that a graphics card's displays changed (a cable was plugged in or out), or that
// a card came or went: uevents by netlink, as udev gets them. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hw/file_descriptor.hpp"

namespace contourd {

// What an announcement says; what it does not say may be any.
struct DisplayChange {
  std::optional<dev_t> card;               // the card's device number
  std::optional<std::uint32_t> connector;  // the kernel's id of one that changed
  // A display's state changed, or its device went; not so for what else there is to announce (a card that
  // somebody has udev look at again, a lease).
  bool of_state = false;
};

// Nothing where it is not about a graphics card. `text` is as the kernel sends it: "change@/devices/...",
// then KEY=value, each ended by a zero byte.
[[nodiscard]] std::optional<DisplayChange> display_change(std::span<const char> text);

// Whether the state of this connector, of this card, may have changed.
[[nodiscard]] bool concerns(const DisplayChange& change, dev_t card, std::uint32_t connector);

class UeventSocket {
 public:
  // Throws std::system_error.
  UeventSocket();

  [[nodiscard]] int fd() const { return fd_.get(); }

  // Reads all that wait. Where some were lost, there is one that says nothing: anything may have changed.
  [[nodiscard]] std::vector<DisplayChange> read_all();

 private:
  FileDescriptor fd_;
};

}  // namespace contourd
