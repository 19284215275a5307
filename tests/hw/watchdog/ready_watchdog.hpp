// A light watchdog for a machine in a test: it says that it is ready, and sends no other answer by itself.
// Not thread-safe.
#pragma once

#include <sys/socket.h>

#include <stdexcept>

#include "hw/watchdog/light_watchdog.hpp"

namespace contourd::testing {

// Returns a watchdog that is ready. The clock, the watcher and `process`, the other end, must outlive it.
inline LightWatchdog ready_watchdog(Clock& clock, DescriptorWatcher& watcher, FileDescriptor& process) {
  return LightWatchdog(clock, watcher, [&process] {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error("no socket pair");
    process = FileDescriptor(ends[1]);
    WatchdogReply ready{};
    ready.type = WatchdogMessageType::Ready;
    if (!send_message(ends[1], ready)) throw std::runtime_error("the socket pair takes nothing");
    return LightWatchdog::Process{FileDescriptor(ends[0]), -1};
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
    if (!send_message(process.get(), heard)) throw std::runtime_error("the socket pair takes nothing");
  }
  (void)watchdog.trip();  // reads the answers
}

}  // namespace contourd::testing
