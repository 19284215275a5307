#include "daemon/system/event_loop.hpp"

#include <signal.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace contourd {
namespace {

// Throws std::system_error if `result`, of an sd-event function, is a negative errno.
int check(int result, const char* what) {
  if (result < 0) throw std::system_error(-result, std::generic_category(), what);
  return result;
}

// The permitted delay of a timer. sd-event's default of 250 ms would show in every exposure.
constexpr std::uint64_t kTimerAccuracyUs = 1;

void set_urgency(sd_event_source* source, EventLoop::Urgency urgency) {
  if (urgency == EventLoop::Urgency::Normal) return;
  check(sd_event_source_set_priority(source, SD_EVENT_PRIORITY_IMPORTANT), "sd_event_source_set_priority");
}

// Returns the CPU time of this thread.
Duration computing_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

std::uint64_t microseconds(TimePoint when) {
  const auto us = std::chrono::ceil<std::chrono::microseconds>(when.time_since_epoch()).count();
  return us > 0 ? static_cast<std::uint64_t>(us) : 0;
}

}  // namespace

// Owns an sd-event source. The running call shares ownership of the callback, so that the callback may
// destroy its own source.
class EventLoop::SdSource {
 public:
  using Call = std::function<void(std::uint32_t)>;

  SdSource(EventLoop& loop, std::string_view name, Call call)
      : loop_(loop), name_(name), call_(std::make_shared<Call>(std::move(call))) {}
  SdSource(const SdSource&) = delete;
  SdSource& operator=(const SdSource&) = delete;
  ~SdSource() { sd_event_source_disable_unref(source); }

  static int io(sd_event_source*, int, std::uint32_t events, void* self) { return run(self, events); }
  static int time(sd_event_source*, std::uint64_t, void* self) { return run(self, 0); }
  static int signal(sd_event_source*, const struct signalfd_siginfo*, void* self) { return run(self, 0); }
  static int defer(sd_event_source*, void* self) { return run(self, 0); }

  void enable(int enabled) {
    check(sd_event_source_set_enabled(source, enabled), "sd_event_source_set_enabled");
  }

  sd_event_source* source = nullptr;

 private:
  static int run(void* self, std::uint32_t events) {
    const SdSource& source = *static_cast<SdSource*>(self);
    const std::shared_ptr<Call> call = source.call_;
    return source.loop_.guarded(source.name_, [&] { (*call)(events); });
  }

  EventLoop& loop_;
  std::string_view name_;
  std::shared_ptr<Call> call_;
};

namespace {

// Implements the interface `Face` with the sd-event source `Sd`.
template <typename Face, typename Sd>
class OwnedSource : public Face {
 public:
  template <typename... Arguments>
  explicit OwnedSource(Arguments&&... arguments) : sd(std::forward<Arguments>(arguments)...) {}
  Sd sd;
};

}  // namespace

class EventLoop::SdIoSource final : public OwnedSource<IoSource, SdSource> {
 public:
  using OwnedSource::OwnedSource;
  void set_events(std::uint32_t events) override {
    sd.enable(events == 0 ? SD_EVENT_OFF : SD_EVENT_ON);
    check(sd_event_source_set_io_events(sd.source, events), "sd_event_source_set_io_events");
  }
};

class EventLoop::SdIdleSource final : public OwnedSource<IdleSource, SdSource> {
 public:
  using OwnedSource::OwnedSource;
  void wake() override { sd.enable(SD_EVENT_ON); }
};

EventLoop::EventLoop() {
  check(sd_event_new(&event_), "sd_event_new");
}

EventLoop::~EventLoop() {
  sd_event_unref(event_);
}

void EventLoop::run() {
  check(sd_event_loop(event_), "sd_event_loop");
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void EventLoop::stop() {
  check(sd_event_exit(event_, 0), "sd_event_exit");
}

// Stores an exception for run() to rethrow, because it must not pass through sd-event's C frames.
int EventLoop::guarded(std::string_view name, const std::function<void()>& call) {
  turn_source_ = name;
  turn_began_ = std::chrono::steady_clock::now();
  computed_before_ = computing_time();
  try {
    call();
    if (turn_over_) turn_over_(turn());
  } catch (...) {
    failure_ = std::current_exception();
    sd_event_exit(event_, 1);
  }
  return 0;
}

EventLoop::Turn EventLoop::turn() const {
  return {turn_source_, std::chrono::steady_clock::now() - turn_began_, computing_time() - computed_before_};
}

std::unique_ptr<EventLoop::IoSource> EventLoop::on_ready(int fd, std::uint32_t events, std::string_view name,
                                                         std::function<void(std::uint32_t)> call,
                                                         Urgency urgency) {
  auto source = std::make_unique<SdIoSource>(*this, name, std::move(call));
  check(sd_event_add_io(event_, &source->sd.source, fd, events, SdSource::io, &source->sd),
        "sd_event_add_io");
  set_urgency(source->sd.source, urgency);
  return source;
}

void EventLoop::attach(sd_bus* bus) {
  check(sd_bus_attach_event(bus, event_, SD_EVENT_PRIORITY_NORMAL), "sd_bus_attach_event");
}

EventLoop::SourcePtr EventLoop::on_signal(int signal, std::function<void()> call) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  check(-pthread_sigmask(SIG_BLOCK, &set, nullptr), "pthread_sigmask");
  auto source = std::make_unique<OwnedSource<Source, SdSource>>(
      *this, "a signal", [call = std::move(call)](std::uint32_t) { call(); });
  check(sd_event_add_signal(event_, &source->sd.source, signal, SdSource::signal, &source->sd),
        "sd_event_add_signal");
  return source;
}

EventLoop::SourcePtr EventLoop::at(TimePoint when, std::string_view name, std::function<void()> call,
                                   Urgency urgency) {
  auto source = std::make_unique<OwnedSource<Source, SdSource>>(
      *this, name, [call = std::move(call)](std::uint32_t) { call(); });
  const int result = sd_event_add_time(event_, &source->sd.source, CLOCK_MONOTONIC, microseconds(when),
                                       kTimerAccuracyUs, SdSource::time, &source->sd);
  // The loop has ended, so no timer fires any more. A device that is destroyed after the loop's end may still
  // ask for a timer.
  if (result == -ESTALE) return source;
  check(result, "sd_event_add_time");
  set_urgency(source->sd.source, urgency);
  return source;
}

std::unique_ptr<EventLoop::IdleSource> EventLoop::when_idle(std::string_view name,
                                                            std::function<bool()> call) {
  const auto self = std::make_shared<SdSource*>(nullptr);
  auto source = std::make_unique<SdIdleSource>(*this, name, [self, call = std::move(call)](std::uint32_t) {
    if (!call()) (*self)->enable(SD_EVENT_OFF);
  });
  *self = &source->sd;
  check(sd_event_add_defer(event_, &source->sd.source, SdSource::defer, &source->sd), "sd_event_add_defer");
  check(sd_event_source_set_priority(source->sd.source, SD_EVENT_PRIORITY_IDLE),
        "sd_event_source_set_priority");
  source->wake();
  return source;
}

TimePoint EventLoopClock::now() const {
  return std::chrono::steady_clock::now();
}

namespace {

class SourceTimer final : public Timer {
 public:
  explicit SourceTimer(EventLoop::SourcePtr source) : source_(std::move(source)) {}

 private:
  EventLoop::SourcePtr source_;
};

}  // namespace

std::unique_ptr<Timer> EventLoopClock::call_at(TimePoint when, std::function<void()> call) {
  return std::make_unique<SourceTimer>(
      loop_.at(when, "a timer of the machine", std::move(call), EventLoop::Urgency::Machine));
}

namespace {

class SourceWatch final : public DescriptorWatcher::Watch {
 public:
  explicit SourceWatch(EventLoop::SourcePtr source) : source_(std::move(source)) {}

 private:
  EventLoop::SourcePtr source_;
};

}  // namespace

std::unique_ptr<DescriptorWatcher::Watch> EventLoopWatcher::when_readable(int fd,
                                                                          std::function<void()> call) {
  return std::make_unique<SourceWatch>(loop_.on_ready(
      fd, EPOLLIN, "a device of the machine", [call = std::move(call)](std::uint32_t) { call(); },
      EventLoop::Urgency::Machine));
}

Mailbox::Mailbox(EventLoop& loop) : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK | EFD_SEMAPHORE)) {
  if (!event_.valid()) throw std::system_error(errno, std::generic_category(), "eventfd");
  source_ =
      loop.on_ready(event_.get(), EPOLLIN, "a worker's result", [this](std::uint32_t) { deliver_one(); });
}

void Mailbox::post(std::function<void()> call) {
  {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
  }
  // Cannot fail: the counter of an eventfd goes up to 2^64 - 2.
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(event_.get(), &one, sizeof one);
}

// The eventfd (EFD_SEMAPHORE) stays readable while calls are queued, so the loop calls this again.
void Mailbox::deliver_one() {
  std::uint64_t one = 0;
  [[maybe_unused]] const ssize_t read = ::read(event_.get(), &one, sizeof one);
  std::function<void()> call;
  {
    const std::lock_guard lock(mutex_);
    call = std::move(calls_.front());
    calls_.pop_front();
  }
  call();
}

}  // namespace contourd
