#include "daemon/check/config_check.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/config/printer_places.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kServiceUser = "contourd";

// Gives this process another user's rights; the destructor restores root's.
class ActingUser {
 public:
  explicit ActingUser(const SystemUser& user) : group_(::getegid()) {
    const int groups = ::getgroups(0, nullptr);
    groups_.resize(groups > 0 ? static_cast<std::size_t>(groups) : 0);
    if (groups < 0 || ::getgroups(groups, groups_.data()) != groups) return;
    active_ = ::initgroups(user.name.c_str(), user.group) == 0 && ::setegid(user.group) == 0 &&
              ::seteuid(user.user) == 0;
  }
  ActingUser(const ActingUser&) = delete;
  ActingUser& operator=(const ActingUser&) = delete;
  ~ActingUser() {
    (void)!::seteuid(0);
    (void)!::setegid(group_);
    (void)!::setgroups(groups_.size(), groups_.data());
  }

  // True if the process got the user's rights.
  [[nodiscard]] bool active() const { return active_; }

 private:
  gid_t group_;
  std::vector<gid_t> groups_;
  bool active_ = false;
};

// Returns why the path cannot be accessed in this mode (R_OK, ...); empty if it can.
std::string access_problem(const fs::path& path, int mode) {
  if (::faccessat(AT_FDCWD, path.c_str(), mode, AT_EACCESS) == 0) return "";
  return std::generic_category().message(errno);
}

// True if the systemd unit hides the path from the service or replaces it with a private copy, whatever its
// permissions (ProtectHome, PrivateTmp).
bool is_hidden_by_unit(const fs::path& path) {
  constexpr std::array<std::string_view, 5> kHidden{"/home/", "/root/", "/run/user/", "/tmp/", "/var/tmp/"};
  const std::string text = path.string() + "/";
  return std::ranges::any_of(kHidden, [&](std::string_view folder) { return text.starts_with(folder); });
}

// Checks paths and collects the violations.
class AccessCheck {
 public:
  explicit AccessCheck(const SystemUser& user) : user_(user) {}

  // `action` completes the sentence "the service's user contourd cannot ...".
  void check(const fs::path& path, int mode, const char* action) {
    if (is_hidden_by_unit(path)) {
      violations_.push_back(
          {path.string(), "", "the unit hides home folders and temporary files from the service"});
    } else if (const std::string why = access_problem(path, mode); !why.empty()) {
      violations_.push_back(
          {path.string(), "", fmt::format("the service's user {} cannot {}: {}", user_.name, action, why)});
    }
  }
  [[nodiscard]] std::vector<Violation> take() { return std::move(violations_); }

 private:
  const SystemUser& user_;
  std::vector<Violation> violations_;
};

void check_spool(const fs::path& spool, AccessCheck& access) {
  const fs::path base = nearest_existing(spool);
  if (base != spool) return access.check(base, W_OK | X_OK, "create the spool in it");
  access.check(spool, R_OK | W_OK | X_OK, "write to it");
  for (const char* name : {"incoming", "printing", "done", "failed"}) {
    if (fs::exists(spool / name)) access.check(spool / name, R_OK | W_OK | X_OK, "write to it");
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
  expects(::geteuid() == 0, "this process runs as root");
  const ActingUser acting(user);
  if (!acting.active()) return {};
  AccessCheck access(user);
  for (const fs::path& file : printer.files)
    access.check(file, R_OK, "read it");
  access.check(printer.resins_folder, R_OK | X_OK, "list its files");
  check_spool(printer.spool_folder, access);
  const fs::path sockets = printer.control_socket.parent_path();
  // systemd creates a folder in /run itself when it starts the service.
  if (sockets.parent_path() != "/run") access.check(sockets, W_OK | X_OK, "create the socket in it");
  return access.take();
}

void check_config(const std::filesystem::path& file) {
  const PrinterConfig config = load_printer_config(file);
  std::vector<Violation> warnings = config.warnings;
  const auto add = [&warnings](const std::vector<Violation>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  add(implausible_in_other_resins(config));
  if (const auto user = service_user()) add(out_of_reach(*user, config));
  for (const Violation& warning : warnings)
    fmt::print("{}\n", warning_line(warning));
  fmt::print("{}: good\n", printable(file.string()));
}

}  // namespace contourd
