#include "hw/virtual_clock.hpp"

#include <algorithm>

namespace contourd {

class VirtualClock::PendingCall final : public Timer {
 public:
  PendingCall(VirtualClock& clock, Key key) : clock_(clock), key_(key) {}
  ~PendingCall() override { clock_.calls_.erase(key_); }

 private:
  VirtualClock& clock_;
  Key key_;
};

std::unique_ptr<Timer> VirtualClock::call_at(TimePoint when, std::function<void()> call) {
  const Key key{std::max(when, now_), next_serial_++};
  const bool was_idle = calls_.empty();
  calls_.emplace(key, std::move(call));
  if (was_idle && wake_) wake_();
  return std::make_unique<PendingCall>(*this, key);
}

bool VirtualClock::run_next() {
  if (calls_.empty()) return false;
  auto earliest = calls_.extract(calls_.begin());
  now_ = earliest.key().first;
  earliest.mapped()();
  return true;
}

}  // namespace contourd
