// Estimates how much memory this process can allocate before the kernel kills a process for it. Thread-safe
// (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace contourd {

// The folders from which the kernel's figures are read.
struct MemorySources {
  std::filesystem::path proc = "/proc";
  std::filesystem::path control_groups = "/sys/fs/cgroup";
};

struct MemoryRoom {
  std::uint64_t bytes = 0;  // bytes that can still be allocated
  std::string reason;       // for this limit, as a clause
  std::uint64_t held = 0;   // by this process; at most the limit, if there is one
};

// Returns the rest of the process' `limit`. Without a limit: the memory available on the machine or left in
// the process' control groups (version 1 or 2), whichever is less, minus a reserve. File pages that the
// kernel can drop count as available.
[[nodiscard]] MemoryRoom memory_room(std::optional<std::uint64_t> limit, const MemorySources& sources = {});

// Returns the machine's total memory, or nullopt if it is unknown.
[[nodiscard]] std::optional<std::uint64_t> machine_memory(const MemorySources& sources = {});

// Returns "640 MB"; a MB has 1,000,000 bytes.
[[nodiscard]] std::string megabytes(std::uint64_t bytes);

}  // namespace contourd
