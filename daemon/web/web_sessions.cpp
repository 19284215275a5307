#include "daemon/web/web_sessions.hpp"

#include "daemon/web/web_secrets.hpp"

namespace contourd::web {

std::string WebSessions::open(TimePoint now) {
  constexpr std::size_t kTokenBytes = 32;
  std::erase_if(sessions_, [now](const Session& each) { return each.ends <= now; });
  if (sessions_.size() >= kMost) sessions_.erase(sessions_.begin());
  sessions_.push_back({random_hex(kTokenBytes), now + lifetime_});
  return sessions_.back().token;
}

bool WebSessions::is_open(std::string_view token, TimePoint now) const {
  bool open = false;
  for (const Session& each : sessions_)
    open |= equal_in_constant_time(each.token, token) && now < each.ends;
  return open;
}

void WebSessions::close(std::string_view token) {
  std::erase_if(sessions_,
                [token](const Session& each) { return equal_in_constant_time(each.token, token); });
}

}  // namespace contourd::web
