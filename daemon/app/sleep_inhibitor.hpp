// Keeps the computer awake while a print runs: in suspend nothing turns a light off, and the monotonic clock
// stands still. If the computer is suspended all the same, the print is interrupted first, and the computer
// waits until the light is off. Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hw/clock.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// The service that puts the computer to sleep: logind (org.freedesktop.login1.Manager), or a test's fake.
class SleepAuthority {
 public:
  enum class Lock {
    Block,  // no suspend at all
    Delay,  // suspend waits until the lock is released, at most some seconds
  };
  // Receives the lock, which is released when it is closed, or the reason why it was refused.
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

// The print that sleep would disturb.
class SleepingPrint {
 public:
  virtual ~SleepingPrint() = default;

  // Reports that the computer is about to sleep.
  virtual void interrupt() = 0;
  // True if no light is on.
  [[nodiscard]] virtual bool dark() const = 0;
  // Reports, once, that no lock is granted.
  virtual void unguarded(const std::string& why) = 0;
};

class SleepInhibitor {
 public:
  // All arguments must outlive the inhibitor.
  SleepInhibitor(SleepAuthority& authority, Clock& clock, SleepingPrint& print);

  // Takes the locks if a print runs (`wanted`), else releases them.
  void hold(bool wanted);

  // Interval of the checks for darkness while the computer waits to sleep.
  static constexpr Duration kLook{std::chrono::milliseconds{20}};

 private:
  void take();
  void taken(FileDescriptor& kept, FileDescriptor lock, const std::string& refusal);
  void sleep();
  void let_sleep_when_dark();

  SleepAuthority& authority_;
  Clock& clock_;
  SleepingPrint& print_;
  bool wanted_ = false;
  bool reported_ = false;  // unguarded() was called
  int pending_ = 0;        // requests without an answer yet
  FileDescriptor block_, delay_;
  std::unique_ptr<Timer> look_;
};

}  // namespace contourd
