// The descriptors with which the light watchdog turns the light off: duplicates of those of the daemon's own
// devices, whose state they share. They are closed when the daemon loses a device, which could not be opened
// again otherwise. One thread; neither allocates nor throws.
#pragma once

#include "hw/file_descriptor.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// The following work on one descriptor, -1 for none. Any thread.

// Turns the light off by its line. Does not block. True if there is a line, and it is off now.
bool turn_line_off(int line) noexcept;
// Sends light off to the projector. Does not block: if the port takes no bytes now, it may the next time.
void send_light_off(int port, const SerialMessage& serial) noexcept;
// Blanks the screen, whatever waits for a refresh. Blocks for at most two refreshes (10 s, the kernel's
// limit, if the driver hangs).
void show_black(int card, const DisplayMessage& display) noexcept;

class LightPaths {
 public:
  // Takes the descriptor out of a packet that adds or withdraws one. True if the packet was of this kind.
  bool take(WatchdogPacket& packet);

  // Turns the light off by the line and the serial port. True if there is a line, and it is off now.
  bool light_off() noexcept;
  void display_black() noexcept { show_black(display_.descriptor.get(), display_.message); }

  // Returns the time from one light off to the next.
  [[nodiscard]] Duration gap() const;

 private:
  template <typename Message>
  struct Path {
    FileDescriptor descriptor;
    Message message{};
  };
  template <typename Message>
  static bool keep(WatchdogPacket& packet, Path<Message>& path);

  Path<LineMessage> line_;
  Path<SerialMessage> serial_;
  Path<DisplayMessage> display_;
};

}  // namespace contourd
