#include "daemon/web/login_guard.hpp"

#include <algorithm>

namespace contourd::web {

std::string LoginGuard::key_of(const std::string& address) const {
  return tries_.contains(address) || tries_.size() < kMostAddresses ? address : "";
}

std::chrono::seconds LoginGuard::wait_of(const std::string& address, TimePoint now) const {
  const auto found = tries_.find(key_of(address));
  if (found == tries_.end() || now >= found->second.next) return std::chrono::seconds(0);
  return std::chrono::ceil<std::chrono::seconds>(found->second.next - now);
}

void LoginGuard::tried(const std::string& address, TimePoint now) {
  std::erase_if(tries_, [now](const auto& each) { return now - each.second.last > kForgottenAfter; });
  Tries& tries = tries_[key_of(address)];
  ++tries.count;
  tries.last = now;
  if (tries.count < kFreeTries) return;
  constexpr int kMostDoublings = 6;  // 64 s, which the longest wait limits
  const int doublings = std::min(tries.count - kFreeTries, kMostDoublings);
  tries.next = now + std::min<std::chrono::seconds>(kLongestWait, std::chrono::seconds(1 << doublings));
}

void LoginGuard::succeeded(const std::string& address) {
  tries_.erase(key_of(address));
}

}  // namespace contourd::web
