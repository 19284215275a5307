#include "daemon/system/system_users.hpp"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>

#include <array>
#include <cstdio>
#include <memory>
#include <vector>

namespace contourd {

std::string user_name(uid_t user) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> users(std::fopen("/etc/passwd", "re"), std::fclose);
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> buffer{};
  while (users && ::fgetpwent_r(users.get(), &entry, buffer.data(), buffer.size(), &found) == 0) {
    if (entry.pw_uid == user) return fmt::format("{} ({})", entry.pw_name, user);
  }
  return std::to_string(user);
}

std::optional<gid_t> find_group(std::string_view name) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> groups(std::fopen("/etc/group", "re"), std::fclose);
  group entry{};
  group* found = nullptr;
  std::vector<char> buffer(1 << 16);  // for a group of some thousand members
  while (groups && ::fgetgrent_r(groups.get(), &entry, buffer.data(), buffer.size(), &found) == 0) {
    if (entry.gr_name == name) return entry.gr_gid;
  }
  return std::nullopt;
}

}  // namespace contourd
