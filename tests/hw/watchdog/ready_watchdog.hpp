// A light watchdog for a machine in a test: it is ready, and answers nothing else. Not thread-safe.
#pragma once

#include <sys/socket.h>

#include <stdexcept>

#include "hw/watchdog/light_watchdog.hpp"

namespace contourd::testing {

// Both must outlive it, as must `process`, the other end.
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

// It says that it watches over the exposure that it was asked to.
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
  (void)watchdog.trip();  // hears it
}

}  // namespace contourd::testing
