// Slows down the guessing of passwords: after some wrong ones, an address has to wait ever longer for its
// next try. Not thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>

namespace contourd::web {

class LoginGuard {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // The limits: tries without a wait, the longest wait between two tries, the time after which tries are
  // forgotten, and the number of addresses that are counted separately.
  static constexpr int kFreeTries = 5;
  static constexpr std::chrono::seconds kLongestWait{60};
  static constexpr std::chrono::minutes kForgottenAfter{15};
  static constexpr std::size_t kMostAddresses = 256;

  // Returns how long the address has to wait before its next try; 0 if it may try now.
  [[nodiscard]] std::chrono::seconds wait_of(const std::string& address, TimePoint now) const;
  // Counts a try, which is wrong until succeeded() is called, so that tries at the same time count, too.
  void tried(const std::string& address, TimePoint now);
  // Forgets the tries of the address.
  void succeeded(const std::string& address);

 private:
  struct Tries {
    int count = 0;
    TimePoint last{}, next{};
  };

  // Returns the key under which the address is counted: all those that are too many share one.
  [[nodiscard]] std::string key_of(const std::string& address) const;

  std::map<std::string, Tries> tries_;
};

}  // namespace contourd::web
