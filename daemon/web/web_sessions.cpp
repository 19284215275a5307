#include "daemon/web/web_sessions.hpp"

#include <algorithm>

#include "daemon/web/web_secrets.hpp"

namespace contourd::web {

std::string WebSessions::open(Role role, TimePoint now) {
  constexpr std::size_t kTokenBytes = 32;
  std::erase_if(sessions_, [now](const Session& each) { return each.ends <= now; });
  const auto of_role = [role](const Session& each) { return each.role == role; };
  if (std::ranges::count_if(sessions_, of_role) >= static_cast<std::ptrdiff_t>(kMostOfRole))
    sessions_.erase(std::ranges::find_if(sessions_, of_role));
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
