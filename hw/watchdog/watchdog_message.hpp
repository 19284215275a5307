// Messages between the daemon and its light watchdog: of fixed size, one per packet of a SOCK_SEQPACKET pair,
// with a descriptor where one is handed over. Both ends are the same program, so messages are sent as they
// lie in memory. No function here blocks, allocates or throws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>

#include "hw/clock.hpp"
#include "hw/file_descriptor.hpp"
#include "hw/watchdog/light_deadline.hpp"

namespace contourd {

enum class WatchdogMessageType : std::uint32_t {
  Arm = 0x4c574401,  // from the daemon
  Heartbeat,
  Disarm,
  Line,
  Serial,
  Display,
  Ready,  // from the watchdog
  Heard,
  Tripped,
};

// Content of Arm, Heartbeat and Disarm.
struct ExposureMessage {
  WatchdogMessageType type;
  WatchedExposure exposure;
  TimePoint sent;
};

// A device that turns the light off, with its descriptor; a message without a descriptor withdraws it.
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
// A display mode in the kernel's layout (struct drm_mode_modeinfo), to do without that header.
using DisplayModeBytes = std::array<std::byte, 68>;
struct DisplayMessage {
  WatchdogMessageType type;
  std::uint32_t crtc, connector, black;  // the kernel's object ids; `black` is a framebuffer
  DisplayModeBytes mode;
};

// Content of Ready, Heard (after Arm or Heartbeat) and Tripped.
struct WatchdogReply {
  WatchdogMessageType type;
  LightTrip trip;
  std::uint64_t exposure;
  TimePoint at;                     // Tripped: when light off was sent
  bool line_off;                    // Tripped: there is a line, and the kernel has set it
  int no_priority, no_memory_lock;  // Ready: errno of what the system refused, else 0
};

struct WatchdogPacket {
  alignas(8) std::array<std::byte, 512> bytes{};
  std::size_t size = 0;
  FileDescriptor descriptor;

  // Returns the packet's content as a Message; nullopt if the packet has another size.
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

// Sends a packet. False if the other side takes no more, or is gone.
[[nodiscard]] bool send_packet(int socket, const void* bytes, std::size_t size, int descriptor) noexcept;
template <typename Message>
[[nodiscard]] bool send_message(int socket, const Message& message, int descriptor = -1) noexcept {
  static_assert(std::is_trivially_copyable_v<Message>);
  return send_packet(socket, &message, sizeof message, descriptor);
}

// Handles with which another process can turn the light off. The descriptors are borrowed; -1 if there is no
// such device, or no longer.
struct LightSerialPath {
  int descriptor = -1;
  std::string light_off;
  Duration gap{};  // from one light off to the next: the projector's gap plus the command's time on the wire
};
struct LightDisplayPath {
  int descriptor = -1;
  std::uint32_t crtc = 0, connector = 0, black = 0;  // `black` is a framebuffer
  DisplayModeBytes mode{};
};

}  // namespace contourd
