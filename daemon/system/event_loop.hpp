// The daemon's only event loop (sd-event): timers, signals, file descriptors. All callbacks run on the thread
// that calls run(); only Mailbox::post() may be called from another thread.
#pragma once

#include <systemd/sd-bus.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "hw/clock.hpp"
#include "hw/descriptor_watcher.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

class EventLoop {
 public:
  // A registered event source; destroying it ends the registration. Safe to destroy inside its own callback.
  class Source {
   public:
    Source() = default;
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;
    virtual ~Source() = default;
  };
  using SourcePtr = std::unique_ptr<Source>;
  class IoSource : public Source {
   public:
    // Changes the events to wait for; 0 disables the source, also for errors and hang-ups.
    virtual void set_events(std::uint32_t events) = 0;
  };

  // The order in which callbacks that are due at the same time are called; after each call, the loop checks
  // again which ones are due.
  enum class Urgency {
    Machine,  // the end of an exposure, an opened lid
    Normal,   // clients, the spool, results of workers
  };

  // One call of a source, with the source's readable name and the duration of the call.
  struct Turn {
    std::string_view source;
    Duration busy{};
    Duration computing{};  // CPU time; in the rest of `busy` the thread waited for a disk or a processor
  };

  // Throws std::system_error if the kernel cannot create the event loop.
  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  // Runs until stop(). An exception from a callback ends the loop and is rethrown here.
  void run();
  void stop();

  // Calls `over` after every turn, for as long as the loop exists.
  void on_turn_over(std::function<void(const Turn&)> over) { turn_over_ = std::move(over); }
  // Returns the current turn up to now; outside a source's call, the last turn.
  [[nodiscard]] Turn turn() const;

  // The `name` of a source is shown to people, as in "a client of the control socket"; it must outlive the
  // source.

  // Calls `call` with the events that have occurred. `events` is epoll's bit mask (EPOLLIN, EPOLLOUT). The
  // caller keeps the ownership of the descriptor.
  [[nodiscard]] std::unique_ptr<IoSource> on_ready(int fd, std::uint32_t events, std::string_view name,
                                                   std::function<void(std::uint32_t)> call,
                                                   Urgency urgency = Urgency::Normal);
  // Calls `call` for each signal. Blocks the signal for the whole process, so call this before any thread is
  // started.
  [[nodiscard]] SourcePtr on_signal(int signal, std::function<void()> call);
  // Calls `call` once, when CLOCK_MONOTONIC reaches `when`.
  [[nodiscard]] SourcePtr at(TimePoint when, std::string_view name, std::function<void()> call,
                             Urgency urgency = Urgency::Normal);
  // A source whose callback runs whenever nothing else is due, until it returns false; wake() enables it
  // again. Unlike other sources, it must not be destroyed inside its callback.
  class IdleSource : public Source {
   public:
    virtual void wake() = 0;
  };
  [[nodiscard]] std::unique_ptr<IdleSource> when_idle(std::string_view name, std::function<bool()> call);
  // Serves the bus for as long as it is open. Its callbacks must not throw.
  void attach(sd_bus* bus);

 private:
  class SdSource;
  class SdIoSource;
  class SdIdleSource;

  int guarded(std::string_view name, const std::function<void()>& call);

  sd_event* event_ = nullptr;
  std::exception_ptr failure_;
  std::string_view turn_source_;
  TimePoint turn_began_{};
  Duration computed_before_{};
  std::function<void(const Turn&)> turn_over_;
};

// CLOCK_MONOTONIC with timers on the event loop, which must outlive the clock. Its timers have
// Urgency::Machine.
class EventLoopClock final : public Clock {
 public:
  explicit EventLoopClock(EventLoop& loop) : loop_(loop) {}
  [[nodiscard]] TimePoint now() const override;
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override;

 private:
  EventLoop& loop_;
};

// Watches the machine's file descriptors on the event loop, which must outlive the watcher. Its callbacks
// have Urgency::Machine.
class EventLoopWatcher final : public DescriptorWatcher {
 public:
  explicit EventLoopWatcher(EventLoop& loop) : loop_(loop) {}
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override;

 private:
  EventLoop& loop_;
};

// A queue of calls from other threads to the event loop's thread; the loop makes one call per turn, in order.
class Mailbox {
 public:
  // Throws std::system_error if no file descriptor is available.
  explicit Mailbox(EventLoop& loop);

  // Queues a call for the loop's thread. May be called from any thread.
  void post(std::function<void()> call);

 private:
  void deliver_one();

  FileDescriptor event_;
  std::mutex mutex_;
  std::deque<std::function<void()>> calls_;
  EventLoop::SourcePtr source_;
};

}  // namespace contourd
