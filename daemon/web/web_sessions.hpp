// The sessions of people who have entered a password: random tokens that expire. Not thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/web/page/role.hpp"

namespace contourd::web {

class WebSessions {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  static constexpr std::size_t kMostOfRole = 32;

  explicit WebSessions(std::chrono::seconds lifetime) : lifetime_(lifetime) {}

  [[nodiscard]] std::chrono::seconds lifetime() const { return lifetime_; }
  // Opens a session and returns its token, 64 hexadecimal digits. With kMostOfRole sessions of
  // the role, the oldest of them ends.
  [[nodiscard]] std::string open(Role role, TimePoint now);
  // Returns the role of the open session with this token; nullopt if there is none. Takes the same time for
  // every token of that length.
  [[nodiscard]] std::optional<Role> role_of(std::string_view token, TimePoint now) const;
  void close(std::string_view token);

 private:
  struct Session {
    std::string token;
    Role role;
    TimePoint ends;
  };

  std::chrono::seconds lifetime_;
  std::vector<Session> sessions_;  // the oldest first
};

}  // namespace contourd::web
