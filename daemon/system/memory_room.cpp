#include "daemon/system/memory_room.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <string_view>

namespace contourd {
namespace {

namespace fs = std::filesystem;

// Memory that stays free, because a running print, its report and the rest of the system grow meanwhile.
constexpr std::uint64_t kReserveBytes = 64'000'000;
constexpr std::uint64_t kBytesPerKb = 1024;  // /proc/meminfo's "kB"
constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

std::uint64_t less(std::uint64_t whole, std::uint64_t part) {
  return whole > part ? whole - part : 0;
}

// Returns the number at the text's start, or nullopt if there is none, as in "max".
std::optional<std::uint64_t> number_in(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  std::uint64_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  return code == std::errc() ? std::optional(number) : std::nullopt;
}

// Returns the number after `key` in the first line of the file that begins with `key`.
std::optional<std::uint64_t> number_in(const fs::path& file, std::string_view key = "") {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(key)) return number_in(std::string_view(line).substr(key.size()));
  return std::nullopt;
}

// The names of the same figures in the two versions of control groups.
struct GroupFiles {
  const char *limit, *soft_limit, *used, *inactive, *active;
};
constexpr GroupFiles kVersion1{"memory.limit_in_bytes", "", "memory.usage_in_bytes", "total_inactive_file ",
                               "total_active_file "};
constexpr GroupFiles kVersion2{"memory.max", "memory.high", "memory.current", "inactive_file ",
                               "active_file "};

std::uint64_t left_in(const fs::path& group, const GroupFiles& files) {
  std::uint64_t limit = number_in(group / files.limit).value_or(kUnlimited);
  // Above the soft limit, the kernel slows the process down until it hardly runs.
  if (*files.soft_limit != '\0') limit = std::min(limit, number_in(group / files.soft_limit).value_or(limit));
  const auto used = number_in(group / files.used);
  if (limit == kUnlimited || !used) return kUnlimited;
  std::uint64_t pages_of_files = 0;
  for (const char* const key : {files.inactive, files.active})
    pages_of_files += number_in(group / "memory.stat", key).value_or(0);
  return less(limit, less(*used, pages_of_files));
}

// Returns the least memory left in the group and its ancestors, as far as they are visible to this process.
std::uint64_t left_in_all(const fs::path& root, fs::path group, const GroupFiles& files) {
  std::uint64_t left = kUnlimited;
  while (true) {
    left = std::min(left, left_in(root / group.relative_path(), files));
    if (!group.has_relative_path()) return left;
    group = group.parent_path();
  }
}

// Returns the memory left in the groups of /proc/self/cgroup. Its lines are "NUMBER:CONTROLLERS:GROUP";
// version 2 has the number 0 and no controllers.
std::uint64_t left_in_groups(const MemorySources& sources) {
  std::uint64_t left = kUnlimited;
  std::ifstream lines(sources.proc / "self" / "cgroup");
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    if (line.starts_with("0::"))
      left = std::min(left, left_in_all(sources.control_groups, group, kVersion2));
    else if (controllers.find(",memory,") != std::string::npos)
      left = std::min(left, left_in_all(sources.control_groups / "memory", group, kVersion1));
  }
  return left;
}

// Returns the anonymous memory of the process, including its swapped pages.
std::uint64_t held_by_process(const MemorySources& sources) {
  std::uint64_t kilobytes = 0;
  for (const char* const key : {"RssAnon:", "VmSwap:"})
    kilobytes += number_in(sources.proc / "self" / "status", key).value_or(0);
  return kilobytes * kBytesPerKb;
}

}  // namespace

MemoryRoom memory_room(std::optional<std::uint64_t> limit, const MemorySources& sources) {
  const std::uint64_t held = held_by_process(sources);
  if (limit) {
    return {less(*limit, held),
            fmt::format("memory_limit_mb is {}, and contourd holds {}", *limit / 1'000'000, megabytes(held)),
            std::min(held, *limit)};
  }
  const auto kilobytes = number_in(sources.proc / "meminfo", "MemAvailable:");
  const std::uint64_t machine = kilobytes ? *kilobytes * kBytesPerKb : kUnlimited;
  const std::uint64_t groups = left_in_groups(sources), available = std::min(machine, groups);
  return {
      less(available, kReserveBytes),
      fmt::format("{} are available {}, of which {} stay free", megabytes(available),
                  groups < machine ? "in the control group" : "on this computer", megabytes(kReserveBytes)),
      held};
}

std::optional<std::uint64_t> machine_memory(const MemorySources& sources) {
  const auto kilobytes = number_in(sources.proc / "meminfo", "MemTotal:");
  return kilobytes ? std::optional(*kilobytes * kBytesPerKb) : std::nullopt;
}

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{} MB", bytes / 1'000'000);
}

}  // namespace contourd
