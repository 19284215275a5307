// What the daemon and its light watchdog say to each other: fixed messages, one a packet of a SOCK_SEQPACKET
// pair, with a descriptor where one is handed over. Both are the same program, so that they are sent as they
// lie in memory. Nothing here blocks, allocates or throws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

#include "hw/clock.hpp"
#include "hw/file_descriptor.hpp"
#include "hw/watchdog/light_deadline.hpp"

namespace contourd {

enum class WatchdogMessageType : std::uint32_t {
  Arm = 0x4c574401,  // the daemon's
  Heartbeat,
  Disarm,
  Line,
  Serial,
  Display,
  Ready,  // the watchdog's
  Heard,
  Tripped,
};

// Arm, Beat, Disarm.
struct ExposureMessage {
  WatchdogMessageType type;
  WatchedExposure exposure;
  TimePoint sent;
};

// What turns the light off, with its descriptor; without one, it is no longer there.
struct LineMessage {
  WatchdogMessageType type;
};
struct SerialMessage {
  static constexpr std::size_t kMaxBytes = 256;
  WatchdogMessageType type;
  std::uint32_t size;
  Duration gap;  // from one light off to the next
  std::array<char, kMaxBytes> light_off;
};
// A display mode as the kernel has it (struct drm_mode_modeinfo), without that header.
using DisplayModeBytes = std::array<std::byte, 68>;
struct DisplayMessage {
  WatchdogMessageType type;
  std::uint32_t crtc, connector, black;  // the kernel's numbers; `black` is a framebuffer's
  DisplayModeBytes mode;
};

// Ready, Heard (Arm or Beat), Tripped.
struct WatchdogReply {
  WatchdogMessageType type;
  LightTrip trip;
  std::uint64_t exposure;
  TimePoint at;                     // Tripped: light off was told
  bool line_off;                    // and there is a line, which the kernel has set
  int no_priority, no_memory_lock;  // Ready: errno of what the system refused, else 0
};

struct WatchdogPacket {
  alignas(8) std::array<std::byte, 512> bytes{};
  std::size_t size = 0;
  FileDescriptor descriptor;

  // Nothing when the packet is none of this kind.
  template <typename Message>
  [[nodiscard]] std::optional<Message> as() const {
    static_assert(std::is_trivially_copyable_v<Message> && sizeof(Message) <= sizeof bytes);
    if (size != sizeof(Message)) return std::nullopt;
    Message message;
    std::memcpy(&message, bytes.data(), sizeof message);
    return message;
  }
  [[nodiscard]] std::optional<WatchdogMessageType> type() const;
};

enum class Received { Packet, Nothing, End };
[[nodiscard]] Received receive_packet(int socket, WatchdogPacket& packet) noexcept;

// False when the other side takes no more, or is gone.
[[nodiscard]] bool send_packet(int socket, const void* bytes, std::size_t size, int descriptor) noexcept;
template <typename Message>
[[nodiscard]] bool send_message(int socket, const Message& message, int descriptor = -1) noexcept {
  static_assert(std::is_trivially_copyable_v<Message>);
  return send_packet(socket, &message, sizeof message, descriptor);
}

}  // namespace contourd
