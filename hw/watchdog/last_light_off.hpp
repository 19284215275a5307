// The light off as the last act of a process that cannot be relied on any more: by nothing but the
// descriptors of its devices, from any thread, as the light watchdog does it from outside. The watchdog goes
// on from there: it tells light off again when the process is gone.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// What turns the light off, as LightWatchdog offers it to its process. Descriptors stay their owner's; -1
// where there is no such device, or no longer.
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

  // Any thread; neither allocate, lock nor throw.

  // By the line and the serial port. Does not block.
  void light_off() const noexcept;
  // Blocks for two refreshes at most (10 s, the kernel's limit, if the driver hangs).
  void display_black() const noexcept;

 private:
  [[nodiscard]] const LightOffers& now() const noexcept { return offers_[current_]; }

  // One is written while the other is read: nobody reads for as long as the loop takes to write two.
  std::array<LightOffers, 2> offers_;
  std::atomic<std::size_t> current_{0};
};

// This process's.
[[nodiscard]] LastLightOff& last_light_off() noexcept;

}  // namespace contourd
