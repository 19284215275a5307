// The daemon's one event loop (sd-event): timers, signals, file descriptors. Everything is a
// callback on the thread that calls run(); only Mailbox::post() may be called from another.
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
  // Keeps one thing watched; destroying it ends that. Safe to destroy from inside its own callback.
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
    // 0: it is told of nothing, not even of errors and a hang-up.
    virtual void set_events(std::uint32_t events) = 0;
  };

  // What is due at the same time is called in this order; after each call it is seen anew what is due.
  enum class Urgency {
    Machine,  // an exposure's end, an opened lid
    Normal,   // clients, the spool, what a worker has done
  };

  // One call of a source: what that is, for people, and how long the call took.
  struct Turn {
    std::string_view source;
    Duration busy{};
    Duration computing{};  // of that; in the rest it waited, for a disk or for its processor
  };

  // Throws std::system_error when the kernel has no room for one.
  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  // Runs until stop(). Exceptions from callbacks end it and come out of here.
  void run();
  void stop();

  // `over` is told every turn that has ended. Nothing ends it.
  void on_turn_over(std::function<void(const Turn&)> over) { turn_over_ = std::move(over); }
  // The one under way, up to now; outside of a source's call the last one.
  [[nodiscard]] Turn turn() const;

  // A source's `name` says what it is, as in "a client of the control socket"; it must live as long as the
  // source.

  // `events` as for epoll (EPOLLIN, EPOLLOUT); the callback gets those that are due. The descriptor stays the
  // caller's.
  [[nodiscard]] std::unique_ptr<IoSource> on_ready(int fd, std::uint32_t events, std::string_view name,
                                                   std::function<void(std::uint32_t)> call,
                                                   Urgency urgency = Urgency::Normal);
  // Blocks the signal for the whole process, so it must come before any thread is made.
  [[nodiscard]] SourcePtr on_signal(int signal, std::function<void()> call);
  // Once, when CLOCK_MONOTONIC reaches `when`.
  [[nodiscard]] SourcePtr at(TimePoint when, std::string_view name, std::function<void()> call,
                             Urgency urgency = Urgency::Normal);
  // Again and again whenever nothing else is due, for as long as the call returns true; then after each
  // wake(). Unlike other sources it must not be destroyed from inside its call.
  class IdleSource : public Source {
   public:
    virtual void wake() = 0;
  };
  [[nodiscard]] std::unique_ptr<IdleSource> when_idle(std::string_view name, std::function<bool()> call);
  // The bus is served from now on, for as long as it is open. Its callbacks must not throw.
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

// Real time: CLOCK_MONOTONIC, through the event loop, which must outlive it. Its calls come before those of
// Urgency::Normal.
class EventLoopClock final : public Clock {
 public:
  explicit EventLoopClock(EventLoop& loop) : loop_(loop) {}
  [[nodiscard]] TimePoint now() const override;
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override;

 private:
  EventLoop& loop_;
};

// The machine's descriptors, through the event loop, which must outlive it. Its calls come before those of
// Urgency::Normal.
class EventLoopWatcher final : public DescriptorWatcher {
 public:
  explicit EventLoopWatcher(EventLoop& loop) : loop_(loop) {}
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override;

 private:
  EventLoop& loop_;
};

// Calls handed to the event loop's thread by another: one a turn, in their order.
class Mailbox {
 public:
  // Throws std::system_error when the kernel has no descriptor left.
  explicit Mailbox(EventLoop& loop);

  // From any thread; the call runs on the loop's.
  void post(std::function<void()> call);

 private:
  void deliver_one();

  FileDescriptor event_;
  std::mutex mutex_;
  std::deque<std::function<void()>> calls_;
  EventLoop::SourcePtr source_;
};

}  // namespace contourd
