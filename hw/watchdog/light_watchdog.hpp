// The daemon's side of the light watchdog: keeps the process running, hands it the descriptors that turn the
// light off, has it watch each exposure, and sends it the daemon's heartbeats. A watchdog that has died, or
// does not answer, is replaced; until then no exposure can be watched, and none may begin.
//
// Event loop's thread only.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/watchdog/last_light_off.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// An exposure that the watchdog has ended.
struct WatchdogTrip {
  LightTrip reason = LightTrip::None;
  TimePoint at{};         // when light off was sent for the first time
  bool line_off = false;  // there is a light line, and it was off from `at` on
};

class LightWatchdog {
 public:
  struct Process {
    FileDescriptor socket;
    pid_t id = -1;
  };
  // Starts the watchdog's process. Throws std::system_error.
  using Start = std::function<Process()>;

  // Starts the process and waits until it is ready, usually some milliseconds. A process that cannot be
  // started is not an error: see problem(). The clock and the watcher must outlive this object.
  LightWatchdog(Clock& clock, DescriptorWatcher& watcher, Start start);
  // Leaves the process to end by itself; if it watches an exposure, it turns the light off first.
  ~LightWatchdog();

  // Hand the watchdog a device's descriptor; -1 withdraws the last one.
  void set_line(int descriptor);
  // Ignores a light off command that is too long for a message.
  void set_serial(const LightSerialPath& path);
  void set_display(const LightDisplayPath& path);

  // Has an exposure watched that is yet to begin, and then lasts `exposure`. Calls `armed` when the watchdog
  // has confirmed: the light may go on. If it does not confirm, or something goes wrong later, on_trouble()
  // reports that.
  void arm(Duration exposure, std::function<void()> armed);
  // Notes that light on was sent, and that the light is to be off by `end`.
  void begins(TimePoint end);
  // Notes that light off was requested.
  void off_asked();
  // Ends the watch: the light is confirmed off.
  void disarm();

  // Returns how the watchdog ended the last exposure that was armed; nullopt if it did not. Reads messages
  // that are still in the socket first.
  [[nodiscard]] const std::optional<WatchdogTrip>& trip();

  // Calls `call` from the event loop, with a sentence, when an exposure under watch cannot go on: the
  // watchdog has turned its light off, or has died. `call` must have the light turned off by all means.
  void on_trouble(std::function<void(const std::string&)> call) { trouble_ = std::move(call); }
  // Calls `call` from the event loop, with the former problem, when a watchdog is running again.
  void on_recovery(std::function<void(const std::string&)> call) { recovered_ = std::move(call); }

  // Returns, in a sentence, why no light may be turned on; empty if it may.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  // Returns what the system denied the watchdog although it works, one sentence each.
  [[nodiscard]] std::vector<std::string> refusals() const;

  static constexpr Duration kHeartbeat{std::chrono::milliseconds{50}};
  // Number of unanswered heartbeats after which the watchdog counts as dead.
  static constexpr int kMaxUnanswered = 10;
  static constexpr Duration kStartAgain{std::chrono::milliseconds{100}};
  static constexpr Duration kStartLater{std::chrono::seconds{5}};

 private:
  struct Watched {
    WatchedExposure exposure;
    Duration asked{};
    bool begun = false;
    int unanswered = 0;  // messages
  };

  void start();
  void start_again();
  void wait_until_ready();
  template <typename Message>
  void offer(const LightOffer<Message>& offered);
  void hear_all();
  void hear(const WatchdogReply& reply);
  void ready(const WatchdogReply& reply);
  void heartbeat();
  void tell(WatchdogMessageType type);
  template <typename Message>
  void send(const Message& message, int descriptor = -1);
  void lose(const std::string& why);
  void give_up();
  void tell_trouble(const std::string& what);

  Clock& clock_;
  DescriptorWatcher& watcher_;
  Start start_;
  Process process_;
  std::unique_ptr<DescriptorWatcher::Watch> watch_;
  std::unique_ptr<Timer> heartbeat_, restart_, tell_;
  WatchdogReply readiness_{};
  std::string problem_;
  LightOffers offers_;
  std::uint64_t exposures_ = 0;
  std::optional<Watched> watched_;
  std::optional<WatchdogTrip> trip_;
  std::function<void()> armed_;
  std::function<void(const std::string&)> trouble_, recovered_;
};

}  // namespace contourd
