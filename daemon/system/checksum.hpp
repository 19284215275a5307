// A checksum that finds torn and damaged records, not forged ones. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <string_view>

namespace contourd {

// Returns a checksum of the bytes (FNV-1a, 64 bits); continues from `before`.
[[nodiscard]] constexpr std::uint64_t checksum_of(std::string_view bytes,
                                                  std::uint64_t before = 0xcbf29ce484222325) {
  for (const char byte : bytes)
    before = (before ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return before;
}

}  // namespace contourd
