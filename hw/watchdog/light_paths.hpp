// What the light watchdog turns the light off by: descriptors of the daemon's own devices, whose state they
// share. They are given back when the daemon no longer has the device, or it could not be opened again. One
// thread; neither allocates nor throws.
#pragma once

#include "hw/file_descriptor.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// By one descriptor, -1 for none. Any thread.

// Does not block. True when there is a line, and it is off now.
bool turn_line_off(int line) noexcept;
// Does not block: what the port does not take now it may take the next time.
void send_light_off(int port, const SerialMessage& serial) noexcept;
// The screen black, whatever waits for its refresh. Blocks for two refreshes at most (10 s, the kernel's
// limit, if the driver hangs).
void show_black(int card, const DisplayMessage& display) noexcept;

class LightPaths {
 public:
  // True when the packet was about one of these.
  bool take(WatchdogPacket& packet);

  // By the line and the serial port. True when there is a line, and it is off now.
  bool light_off() noexcept;
  void display_black() noexcept;

  // From one light off to the next.
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
