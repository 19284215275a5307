// Keeps the computer awake while a print runs: in suspend nothing turns a light off, and the monotonic clock
// stands still. Where the computer is suspended all the same, the print is interrupted first, and the
// computer waits until it is dark. Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hw/clock.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// Who puts the computer to sleep: logind (org.freedesktop.login1.Manager), or a test's idea of it.
class SleepAuthority {
 public:
  enum class Lock {
    Block,  // no suspend at all
    Delay,  // suspend waits until the lock is given up, some seconds at most
  };
  // The lock, which is given up when it is closed; or why there is none.
  using Taken = std::function<void(FileDescriptor lock, const std::string& refusal)>;

  SleepAuthority() = default;
  SleepAuthority(const SleepAuthority&) = delete;
  SleepAuthority& operator=(const SleepAuthority&) = delete;
  virtual ~SleepAuthority() = default;

  // Calls `taken` once, from the event loop.
  virtual void take(Lock lock, Taken taken) = 0;
  // Calls `call` from the event loop with true before the computer sleeps, and with false when it has woken.
  virtual void on_sleep(std::function<void(bool asleep)> call) = 0;
};

class SleepInhibitor {
 public:
  struct Print {
    std::function<void()> interrupt;                    // the computer is about to sleep
    std::function<bool()> dark;                         // no light is on
    std::function<void(const std::string&)> unguarded;  // nobody keeps the computer awake, and why; once
  };
  // Both must outlive it.
  SleepInhibitor(SleepAuthority& authority, Clock& clock, Print print);

  // Whether a print runs.
  void hold(bool wanted);

  static constexpr Duration kLook{std::chrono::milliseconds{20}};

 private:
  void take();
  void taken(FileDescriptor& kept, FileDescriptor lock, const std::string& refusal);
  void sleep();
  void let_sleep_when_dark();

  SleepAuthority& authority_;
  Clock& clock_;
  Print print_;
  bool wanted_ = false;
  bool told_ = false;
  int asked_ = 0;  // and not answered
  FileDescriptor block_, delay_;
  std::unique_ptr<Timer> look_;
};

}  // namespace contourd
