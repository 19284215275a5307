// A light watchdog for a machine in a test: it says that it is ready, and sends no other answer by itself.
// Not thread-safe.
#pragma once

#include <stdexcept>

#include "hw/watchdog/light_watchdog.hpp"
#include "tests/hw/no_descriptors.hpp"
#include "tests/hw/virtual_time_fixture.hpp"
#include "tests/hw/watchdog/socket_pair.hpp"

namespace contourd::testing {

inline void send_reply(const FileDescriptor& process, const WatchdogReply& reply) {
  if (!send_message(process.get(), reply)) throw std::runtime_error("the socket pair takes nothing");
}

// Returns a watchdog that is ready. The clock, the watcher and `process`, the other end, must outlive it.
inline LightWatchdog ready_watchdog(Clock& clock, DescriptorWatcher& watcher, FileDescriptor& process) {
  return LightWatchdog(clock, watcher, [&process] {
    auto [daemon, far] = socket_pair(SOCK_SEQPACKET);
    process = std::move(far);
    WatchdogReply ready{};
    ready.type = WatchdogMessageType::Ready;
    send_reply(process, ready);
    return LightWatchdog::Process{std::move(daemon), -1};
  });
}

// Answers, for the process, that it watches the exposures that it was asked to watch.
inline void watch_over_exposure(LightWatchdog& watchdog, const FileDescriptor& process) {
  WatchdogPacket packet;
  while (receive_packet(process.get(), packet) == Received::Packet) {
    const auto asked = packet.as<ExposureMessage>();
    if (!asked || asked->type == WatchdogMessageType::Disarm) continue;
    WatchdogReply heard{};
    heard.type = WatchdogMessageType::Heard;
    heard.exposure = asked->exposure.number;
    send_reply(process, heard);
  }
  (void)watchdog.trip();  // reads the answers
}

// A ready watchdog on a virtual clock; the test is its process.
struct ReadyWatchdogFixture : VirtualTimeFixture {
  NoDescriptors watcher;
  FileDescriptor process;
  LightWatchdog watchdog = ready_watchdog(clock, watcher, process);
};

}  // namespace contourd::testing
