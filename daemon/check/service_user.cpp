#include "daemon/check/service_user.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/config/printer_places.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kServiceUser = "contourd";

// This process with the rights of another user, and root's again at the end.
class Guise {
 public:
  explicit Guise(const SystemUser& user) : group_(::getegid()) {
    const int groups = ::getgroups(0, nullptr);
    groups_.resize(groups > 0 ? static_cast<std::size_t>(groups) : 0);
    if (groups < 0 || ::getgroups(groups, groups_.data()) != groups) return;
    worn_ = ::initgroups(user.name.c_str(), user.group) == 0 && ::setegid(user.group) == 0 &&
            ::seteuid(user.user) == 0;
  }
  Guise(const Guise&) = delete;
  Guise& operator=(const Guise&) = delete;
  ~Guise() {
    (void)!::seteuid(0);
    (void)!::setegid(group_);
    (void)!::setgroups(groups_.size(), groups_.data());
  }

  [[nodiscard]] bool worn() const { return worn_; }

 private:
  gid_t group_;
  std::vector<gid_t> groups_;
  bool worn_ = false;
};

// Why it cannot be accessed so; empty when it can.
std::string why_out_of_reach(const fs::path& path, int mode) {
  if (::faccessat(AT_FDCWD, path.c_str(), mode, AT_EACCESS) == 0) return "";
  return std::generic_category().message(errno);
}

// What the unit hides or gives an own copy of, whatever the permissions (ProtectHome, PrivateTmp).
bool is_hidden_by_unit(const fs::path& path) {
  constexpr std::array<std::string_view, 5> kHidden{"/home/", "/root/", "/run/user/", "/tmp/", "/var/tmp/"};
  const std::string text = path.string() + "/";
  return std::ranges::any_of(kHidden, [&](std::string_view folder) { return text.starts_with(folder); });
}

class Reach {
 public:
  explicit Reach(const SystemUser& user) : user_(user) {}

  void check(const fs::path& path, int mode, const char* what) {
    if (is_hidden_by_unit(path)) {
      missed_.push_back(
          {path.string(), "", "the unit hides home folders and temporary files from the service"});
    } else if (const std::string why = why_out_of_reach(path, mode); !why.empty()) {
      missed_.push_back(
          {path.string(), "", fmt::format("the service's user {} cannot {}: {}", user_.name, what, why)});
    }
  }
  [[nodiscard]] std::vector<Violation> take() { return std::move(missed_); }

 private:
  const SystemUser& user_;
  std::vector<Violation> missed_;
};

void check_spool(const fs::path& spool, Reach& reach) {
  const fs::path base = nearest_existing(spool);
  if (base != spool) return reach.check(base, W_OK | X_OK, "make the spool in it");
  reach.check(spool, R_OK | W_OK | X_OK, "write in it");
  for (const char* name : {"incoming", "printing", "done", "failed"}) {
    if (fs::exists(spool / name)) reach.check(spool / name, R_OK | W_OK | X_OK, "write in it");
  }
}

}  // namespace

std::optional<SystemUser> service_user() {
  if (::geteuid() != 0) return std::nullopt;
  const passwd* const user = ::getpwnam(kServiceUser);
  if (user == nullptr) return std::nullopt;
  return SystemUser{kServiceUser, user->pw_uid, user->pw_gid};
}

std::vector<Violation> out_of_reach(const SystemUser& user, const PrinterConfig& printer) {
  expects(::geteuid() == 0, "this process is root's");
  const Guise guise(user);
  if (!guise.worn()) return {};
  Reach reach(user);
  for (const fs::path& file : printer.files)
    reach.check(file, R_OK, "read it");
  reach.check(printer.resins_folder, R_OK | X_OK, "look into it");
  check_spool(printer.spool_folder, reach);
  const fs::path sockets = printer.control_socket.parent_path();
  // What lies in /run itself is made for the service when it starts.
  if (sockets.parent_path() != "/run") reach.check(sockets, W_OK | X_OK, "make the socket in it");
  return reach.take();
}

}  // namespace contourd
