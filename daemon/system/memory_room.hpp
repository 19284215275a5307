// How much memory this process may still take without anything being killed for it. Thread-safe (no shared
// state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace contourd {

// Where the kernel says so.
struct MemorySources {
  std::filesystem::path proc = "/proc";
  std::filesystem::path control_groups = "/sys/fs/cgroup";
};

struct MemoryRoom {
  std::uint64_t bytes = 0;  // that may be taken from now on
  std::string reason;       // why no more, as a clause
  std::uint64_t held = 0;   // by this process; of its limit, where it has one
};

// Of the process' `limit`, or without one: what the machine has available and the process' control groups
// leave it, whichever is less, but for a reserve. (Pages of files count as available, where the kernel can
// drop them.) Both versions of control groups.
[[nodiscard]] MemoryRoom memory_room(std::optional<std::uint64_t> limit, const MemorySources& sources = {});

// All that the machine has; nothing where nobody knows.
[[nodiscard]] std::optional<std::uint64_t> machine_memory(const MemorySources& sources = {});

// "640 MB"; a MB has 1,000,000 bytes.
[[nodiscard]] std::string megabytes(std::uint64_t bytes);

}  // namespace contourd
