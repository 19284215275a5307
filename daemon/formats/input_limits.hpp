// Limits on what a compressed file may become when it is inflated. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string_view>

namespace contourd {

// A model in text has about 250 bytes a facet: this is a text of eight million facets. It also bounds the
// time, because inflating and parsing take a time in proportion.
inline constexpr std::uint64_t kMostInflatedBytes = std::uint64_t{1} << 31U;
// Models become 3 to 30 times as large when they are inflated; Deflate's limit is 1032.
inline constexpr std::uint64_t kMostRatio = 200;
// Up to this size, the ratio does not matter.
inline constexpr std::uint64_t kAnyRatioBytes = std::uint64_t{1} << 24U;
// Largest 3MF file in an archive, which is unpacked into memory.
inline constexpr std::uint64_t kMostNestedBytes = std::uint64_t{1} << 28U;

struct InflatedSize {
  std::uint64_t compressed, inflated;  // bytes
};

// Throws ModelError if something of this size exceeds the limits. `what` begins the sentence: "the archive".
void refuse_inflation(const InflatedSize& size, std::string_view what);

}  // namespace contourd
