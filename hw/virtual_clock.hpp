// A clock whose time jumps to each pending call, so that nothing waits. Drives the simulated printer as fast
// as the processor goes, and the tests. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "hw/clock.hpp"

namespace contourd {

class VirtualClock final : public Clock {
 public:
  [[nodiscard]] TimePoint now() const override { return now_; }
  [[nodiscard]] bool skips_waiting() const override { return true; }
  [[nodiscard]] std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) override;

  [[nodiscard]] bool idle() const { return calls_.empty(); }

  // Advances to the earliest pending call and makes it. False if there is none.
  bool run_next();

  // Calls `wake` whenever a call is added to an idle clock: the event loop's cue to return to run_next().
  void on_work(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  using Key = std::pair<TimePoint, std::uint64_t>;
  class PendingCall;

  TimePoint now_{};
  std::uint64_t next_serial_ = 0;
  std::map<Key, std::function<void()>> calls_;
  std::function<void()> wake_;
};

}  // namespace contourd
