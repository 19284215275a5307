#include "hw/watchdog/light_paths.hpp"

#include <unistd.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "hw/gpio/gpio_lines.hpp"

namespace contourd {
namespace {

// Shortest time from one light off to the next; without a serial port, the line is retried after this.
constexpr Duration kMinGap{std::chrono::milliseconds{20}};

}  // namespace

bool turn_line_off(int line) noexcept {
  return line >= 0 && set_line_inactive(line);
}

void send_light_off(int port, const SerialMessage& serial) noexcept {
  const std::size_t size = std::min<std::size_t>(serial.size, serial.light_off.size());
  if (port >= 0) (void)!::write(port, serial.light_off.data(), size);
}

void show_black(int card, const DisplayMessage& display) noexcept {
  if (card < 0) return;
  auto mode = std::bit_cast<drmModeModeInfo>(display.mode);
  std::uint32_t connector = display.connector;
  // The legacy call needs no preparation, and works for a card in atomic mode as well.
  (void)drmModeSetCrtc(card, display.crtc, display.black, 0, 0, &connector, 1, &mode);
}

template <typename Message>
bool LightPaths::keep(WatchdogPacket& packet, Path<Message>& path) {
  const auto message = packet.as<Message>();
  if (!message) return false;
  path = {std::exchange(packet.descriptor, FileDescriptor()), *message};
  return true;
}

bool LightPaths::take(WatchdogPacket& packet) {
  const auto type = packet.type();
  if (type == WatchdogMessageType::Line) return keep(packet, line_);
  if (type == WatchdogMessageType::Serial) return keep(packet, serial_);
  return type == WatchdogMessageType::Display && keep(packet, display_);
}

bool LightPaths::light_off() noexcept {
  const bool line_off = turn_line_off(line_.descriptor.get());
  send_light_off(serial_.descriptor.get(), serial_.message);
  return line_off;
}

Duration LightPaths::gap() const {
  return serial_.descriptor.valid() ? std::max(serial_.message.gap, kMinGap) : kMinGap;
}

}  // namespace contourd
