#include "hw/drm/master_holder.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace contourd {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string process_text(const std::string& name, const std::string& pid) {
  return name + " (process " + pid + ")";
}

bool has_open(const fs::path& process, const fs::path& card) {
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator(process / "fd", refused)) {
    if (fs::read_symlink(entry.path(), refused) == card) return true;
  }
  return false;
}

// True if the process is a child of this one: the light watchdog, which has the card from this process.
bool is_child(const fs::path& process) {
  return content_of(process / "status").find("\nPPid:\t" + std::to_string(::getpid()) + "\n") !=
         std::string::npos;
}

// Lists the visible processes that have the card open, except this one and its children.
std::string users_of(const fs::path& card) {
  std::string users;
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator("/proc", refused)) {
    const std::string pid = entry.path().filename();
    if (!is_number(pid) || pid == std::to_string(::getpid()) || !has_open(entry.path(), card)) continue;
    if (is_child(entry.path())) continue;
    std::string name = content_of(entry.path() / "comm");
    if (!name.empty() && name.back() == '\n') name.pop_back();
    users += (users.empty() ? "" : ", ") + process_text(name, pid);
  }
  return users;
}

}  // namespace

// The list's columns are command, thread group, device, master (y or n), authenticated, user, magic, and
// since Linux 6.12 name and id. A command may contain spaces.
std::optional<std::string> master_among(std::string_view clients) {
  std::istringstream lines{std::string(clients)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    const std::vector<std::string> columns{std::istream_iterator<std::string>(words), {}};
    std::string command;
    for (std::size_t i = 0; i + 2 < columns.size(); ++i) {
      const std::string& master = columns[i + 2];
      if (i > 0 && is_number(columns[i]) && is_number(columns[i + 1]) && (master == "y" || master == "n")) {
        if (master == "y") return process_text(command, columns[i]);
        break;
      }
      command += (i == 0 ? "" : " ") + columns[i];
    }
  }
  return std::nullopt;
}

std::string describe_master_holder(const fs::path& card) {
  struct stat status {};
  if (::stat(card.c_str(), &status) == 0) {
    const std::string minor_number = std::to_string(minor(status.st_rdev));
    if (const auto master = master_among(content_of("/sys/kernel/debug/dri/" + minor_number + "/clients")))
      return *master + " is its DRM master";
  }
  if (const std::string users = users_of(card); !users.empty()) return users + " has it open";
  return "another program is its DRM master; run `fuser -v " + card.string() + "` as root to find it";
}

}  // namespace contourd
