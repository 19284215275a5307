#include "hw/watchdog/light_paths.hpp"

#include <unistd.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "hw/gpio/line_descriptor.hpp"

namespace contourd {
namespace {

// Where there is no serial port, the line is tried again after this.
constexpr Duration kLeastGap{std::chrono::milliseconds{20}};

}  // namespace

template <typename Message>
bool LightPaths::keep(WatchdogPacket& packet, Path<Message>& path) {
  const auto message = packet.as<Message>();
  if (!message) return false;
  path = {std::exchange(packet.descriptor, FileDescriptor()), *message};
  return true;
}

bool LightPaths::take(WatchdogPacket& packet) {
  const auto word = packet.word();
  if (word == WatchdogWord::Line) return keep(packet, line_);
  if (word == WatchdogWord::Serial) return keep(packet, serial_);
  return word == WatchdogWord::Display && keep(packet, display_);
}

bool LightPaths::light_off() noexcept {
  const bool line_off = line_.descriptor.valid() && set_line_inactive(line_.descriptor.get());
  const auto& [port, serial] = serial_;
  const std::size_t size = std::min<std::size_t>(serial.size, serial.light_off.size());
  // What the port does not take now it may take the next time.
  if (port.valid()) (void)!::write(port.get(), serial.light_off.data(), size);
  return line_off;
}

void LightPaths::display_black() noexcept {
  auto& [card, display] = display_;
  if (!card.valid()) return;
  auto mode = std::bit_cast<drmModeModeInfo>(display.mode);
  // The legacy call, also for a card in atomic mode: it needs nothing prepared.
  (void)drmModeSetCrtc(card.get(), display.crtc, display.black, 0, 0, &display.connector, 1, &mode);
}

Duration LightPaths::gap() const {
  return serial_.descriptor.valid() ? std::max(serial_.message.gap, kLeastGap) : kLeastGap;
}

}  // namespace contourd
