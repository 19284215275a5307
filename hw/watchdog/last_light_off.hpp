// Light off as the last act of a process that can no longer be relied on. Needs nothing but the descriptors
// of the devices, and works from any thread, as the light watchdog does from outside. The watchdog takes over
// from there: it sends light off again when the process is gone.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// A device that can turn the light off, as LightWatchdog offers it to its process. The descriptor is
// borrowed; -1 if there is no such device, or no longer.
template <typename Message>
struct LightOffer {
  int descriptor = -1;
  Message message{};
};
struct LightOffers {
  LightOffer<LineMessage> line{.message = {WatchdogMessageType::Line}};
  LightOffer<SerialMessage> serial{
      .message = {.type = WatchdogMessageType::Serial, .size = 0, .gap = {}, .light_off = {}}};
  LightOffer<DisplayMessage> display;
};

class LastLightOff {
 public:
  // Event loop's thread only.
  void set(const LightOffers& offers) noexcept;

  // The following run on any thread; they neither allocate, lock nor throw.

  // Turns the light off by the line and the serial port. Does not block.
  void light_off() const noexcept;
  // Blanks the screen. Blocks for at most two refreshes (10 s, the kernel's limit, if the driver hangs).
  void display_black() const noexcept;

 private:
  [[nodiscard]] const LightOffers& now() const noexcept { return offers_[current_]; }

  // Double buffer: one entry is written while the other is read. No read lasts as long as the event loop
  // takes to write both.
  std::array<LightOffers, 2> offers_;
  std::atomic<std::size_t> current_{0};
};

// Returns the object of this process.
[[nodiscard]] LastLightOff& last_light_off() noexcept;

// The safe way out of a process that has found a bug in itself. Turns the light off, stops the motor's steps
// and blanks the screen, at once and for the rest of the process's life. Any thread; neither allocates, locks
// nor throws. Blocks for at most two refreshes, after the light is off (10 s, the kernel's limit, if the
// display's driver hangs).
void make_safe_at_once() noexcept;

}  // namespace contourd
