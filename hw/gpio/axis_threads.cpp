#include "hw/gpio/axis_threads.hpp"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace contourd {
namespace {

timespec time_until(TimePoint when) noexcept {
  const Duration left = std::max(when - monotonic_now(), Duration{0});
  return {static_cast<time_t>(left / std::chrono::seconds{1}),
          static_cast<long>((left % std::chrono::seconds{1}).count())};
}

constexpr std::size_t kStack = std::size_t{256} * 1024;
constexpr std::size_t kStackTouched = std::size_t{64} * 1024;  // many times more than a step needs

// Brings the stack into memory before the memory is locked.
[[gnu::noinline]] void touch_stack() noexcept {
  volatile char stack[kStackTouched];
  for (std::size_t i = 0; i < sizeof stack; i += 1024)
    stack[i] = 0;
}

void check(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

std::string words(int error) {
  return std::generic_category().message(error);
}

// Blocks all signals while it exists: a thread that is created meanwhile inherits that, so signals reach only
// the event loop.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

}  // namespace

void* RealtimeThread::start(void* self) {
  auto& thread = *static_cast<RealtimeThread*>(self);
  touch_stack();
  prctl(PR_SET_TIMERSLACK, 1UL);  // matters if SCHED_FIFO is refused; the default is 50 us
  thread.started_.store(true, std::memory_order_release);
  thread.started_.notify_one();
  return thread.body_(thread.argument_);
}

void RealtimeThread::make_thread() {
  const SignalsBlocked blocked;
  pthread_attr_t attributes;
  check(pthread_attr_init(&attributes), "pthread_attr_init");
  pthread_attr_setstacksize(&attributes, kStack);
  const int error = pthread_create(&thread_, &attributes, start, this);
  pthread_attr_destroy(&attributes);
  check(error, "cannot start a thread for the axis");
}

RealtimeThread::RealtimeThread(const char* name, int priority, void* (*body)(void*), void* argument)
    : body_(body), argument_(argument) {
  make_thread();
  started_.wait(false, std::memory_order_acquire);
  pthread_setname_np(thread_, name);
  sched_param parameter{};
  parameter.sched_priority = priority;
  if (const int error = pthread_setschedparam(thread_, SCHED_FIFO, &parameter)) {
    refusals_.push_back("the system refuses real-time priority " + std::to_string(priority) +
                        " to the thread " + name + " (" + words(error) +
                        "): it works, but is late when the computer is busy");
  }
  // Not MCL_FUTURE: a model of some hundred megabytes need not be locked, and may exceed the limit.
  if (mlockall(MCL_CURRENT) != 0) {
    refusals_.push_back("the system refuses to lock the memory of the thread " + std::string(name) + " (" +
                        words(errno) + "): it works, but is late when memory runs short");
  }
}

RealtimeThread::~RealtimeThread() {
  pthread_join(thread_, nullptr);
}

void DeadlineWait::sleep(TimePoint now, TimePoint due) noexcept {
  constexpr Duration kUnwatched{std::chrono::milliseconds{10}};
  constexpr Duration kMaxLead{std::chrono::microseconds{200}};
  const TimePoint wake = std::min(due - lead_, now + kUnwatched);
  if (wake <= now) return;
  const Duration ns = wake.time_since_epoch();
  const timespec time{static_cast<time_t>(ns / std::chrono::seconds{1}),
                      static_cast<long>((ns % std::chrono::seconds{1}).count())};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
  // The lead follows a smaller delay at once and a larger one slowly.
  const Duration took = std::min(monotonic_now() - wake, kMaxLead);
  lead_ = took < lead_ ? std::max(took, Duration{0}) : lead_ + (took - lead_) / 64;
}

StepThread::StepThread(StepEngine& engine, int priority)
    : engine_(engine),
      thread_(
          "contourd-steps", priority,
          [](void* self) -> void* {
            static_cast<StepThread*>(self)->run();
            return nullptr;
          },
          this) {}

StepThread::~StepThread() {
  quit_ = true;
  engine_.inhibit();
  engine_.work().signal();
}

void StepThread::run() noexcept {
  while (!quit_) {
    engine_.work().wait();
    if (!engine_.begin()) continue;
    while (engine_.running()) {
      wait_.until(engine_.due(), [this] { return engine_.interrupted(); });
      engine_.act();
    }
  }
}

InputThread::InputThread(AxisInputs& inputs, int priority)
    : inputs_(inputs),
      thread_(
          "contourd-inputs", priority,
          [](void* self) -> void* {
            static_cast<InputThread*>(self)->run();
            return nullptr;
          },
          this) {}

InputThread::~InputThread() {
  quit_ = true;
  inputs_.work().signal();
}

void InputThread::run() noexcept {
  auto descriptors = inputs_.descriptors();
  while (!quit_) {
    const auto next = inputs_.serve();
    const timespec left = next ? time_until(*next) : timespec{};
    if (ppoll(descriptors.data(), descriptors.size(), next ? &left : nullptr, nullptr) <= 0) continue;
    for (pollfd& waited : descriptors) {
      if ((waited.revents & (POLLERR | POLLHUP | POLLNVAL)) == 0) continue;
      waited.fd = -1;
      inputs_.lose();
    }
  }
}

std::vector<std::string> RealtimeAxisThreads::refusals() const {
  std::vector<std::string> all = steps_.refusals();
  all.insert(all.end(), inputs_.refusals().begin(), inputs_.refusals().end());
  return all;
}

}  // namespace contourd
