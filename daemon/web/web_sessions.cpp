#include "daemon/web/web_sessions.hpp"

#include "daemon/web/web_secrets.hpp"

namespace contourd::web {

std::string WebSessions::open(Role role, TimePoint now) {
  constexpr std::size_t kTokenBytes = 32;
  std::erase_if(sessions_, [now](const Session& each) { return each.ends <= now; });
  if (sessions_.size() >= kMost) sessions_.erase(sessions_.begin());
  sessions_.push_back({random_hex(kTokenBytes), role, now + lifetime_});
  return sessions_.back().token;
}

std::optional<Role> WebSessions::role_of(std::string_view token, TimePoint now) const {
  std::optional<Role> role;
  for (const Session& each : sessions_)
    if (equal_in_constant_time(each.token, token) && now < each.ends) role = each.role;
  return role;
}

void WebSessions::close(std::string_view token) {
  std::erase_if(sessions_,
                [token](const Session& each) { return equal_in_constant_time(each.token, token); });
}

}  // namespace contourd::web
