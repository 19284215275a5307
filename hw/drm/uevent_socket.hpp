// The kernel's announcements that a graphics card's displays changed (a cable was plugged in or out), or that
// a card appeared or disappeared: uevents over netlink, as udev receives them. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hw/file_descriptor.hpp"

namespace contourd {

// The content of an announcement. A card or connector that is not named may be any.
struct DisplayChange {
  std::optional<dev_t> card;               // the card's device number
  std::optional<std::uint32_t> connector;  // the kernel's id of the connector that changed
  // True if a display's state changed or its device was removed. False for other announcements (a trigger by
  // udevadm, a lease).
  bool of_state = false;
};

// Parses an announcement. `text` is as the kernel sends it: "change@/devices/...", then KEY=value, each ended
// by a zero byte. Returns nullopt if it is not about a graphics card.
[[nodiscard]] std::optional<DisplayChange> display_change(std::span<const char> text);

// True if the state of this connector of this card may have changed.
[[nodiscard]] bool concerns(const DisplayChange& change, dev_t card, std::uint32_t connector);

class UeventSocket {
 public:
  // Throws std::system_error.
  UeventSocket();

  [[nodiscard]] int fd() const { return fd_.get(); }

  // Reads all pending announcements. If some were lost, the result has one that names no card: any display
  // may have changed.
  [[nodiscard]] std::vector<DisplayChange> read_all();

 private:
  FileDescriptor fd_;
};

}  // namespace contourd
