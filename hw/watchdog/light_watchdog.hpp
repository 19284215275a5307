// The daemon's side of the light watchdog: keeps the process running, hands it what turns the light off, has
// it watch over an exposure, and tells it that the daemon lives. A watchdog that has died, or does not
// answer, is replaced; until then no exposure can be watched, and none may begin.
//
// Event loop's thread only.
//
// It has more members than most: the process and the ways to it, what was handed to it, and the exposure that
// it watches.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/watchdog/device_paths.hpp"
#include "hw/watchdog/last_light_off.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// What the watchdog has done to an exposure.
struct WatchdogTrip {
  LightTrip reason = LightTrip::None;
  TimePoint at{};         // light off was told for the first time
  bool line_off = false;  // and the light's line, where there is one, was off from then on
};

class LightWatchdog {
 public:
  struct Process {
    FileDescriptor socket;
    pid_t id = -1;
  };
  // Throws std::system_error.
  using Start = std::function<Process()>;

  // Starts the process, and waits until it is ready, some milliseconds as a rule. A process that cannot be
  // started is no error: see problem(). Clock and watcher must outlive it.
  LightWatchdog(Clock& clock, DescriptorWatcher& watcher, Start start);
  // The process ends by itself; if an exposure is watched over, with the light off.
  ~LightWatchdog();

  void set_line(int descriptor);
  // A light off that is too long for a message is ignored.
  void set_serial(const LightSerialPath& path);
  void set_display(const LightDisplayPath& path);

  // Has an exposure watched that is yet to begin and then lasts this long. `armed` runs when the watchdog has
  // confirmed: the light may go on. If it does not confirm, or something goes wrong later, on_trouble()
  // tells.
  void arm(Duration exposure, std::function<void()> armed);
  // Light on was sent: the light is to be off by `end`.
  void begins(TimePoint end);
  // Light off was asked for.
  void off_asked();
  // The light is confirmed off.
  void disarm();

  // Of the last exposure that was armed. Also what has not been told yet.
  [[nodiscard]] const std::optional<WatchdogTrip>& trip();

  // `call` gets, from the event loop, a sentence when an exposure under watch cannot go on: the watchdog has
  // turned its light off, or has died. The light is to be turned off by all means.
  void on_trouble(std::function<void(const std::string&)> call) { trouble_ = std::move(call); }
  // `call` gets, from the event loop, what the problem was when there is a watchdog again.
  void on_recovery(std::function<void(const std::string&)> call) { recovered_ = std::move(call); }

  // Why no light may be turned on, in a sentence; else empty.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  // What the system refused it, though it works; a sentence each.
  [[nodiscard]] std::vector<std::string> refusals() const;

  static constexpr Duration kHeartbeat{std::chrono::milliseconds{50}};
  // After so many heartbeats without an answer it counts as dead.
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
