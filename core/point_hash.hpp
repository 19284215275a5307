// A 64-bit hash of a point's exact bits. Pure functions, thread-safe.
#pragma once

#include <bit>
#include <cstdint>

#include "core/facet.hpp"

namespace contourd {

// REQUIRES: no -0, whose bits are other than those of 0.
[[nodiscard]] inline std::uint64_t hash_of_bits(const Point& point) {
  // Neither constant is a number's bits, so that no factor becomes 0.
  const std::uint64_t x = std::bit_cast<std::uint64_t>(point.x) ^ 0xFFF4D049BB133111U;
  const std::uint64_t y = std::bit_cast<std::uint64_t>(point.y) ^ 0xFFF8476D1CE4E5B9U;
  // 64 bits by 64 bits, both halves of the product mixed (as in wyhash): cheap, and every bit of both tells.
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(x) * y;
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

// -0 and 0 are the same.
[[nodiscard]] inline std::uint64_t hash_of(const Point& point) {
  return hash_of_bits({point.x + 0.0, point.y + 0.0});  // -0 + 0 is 0
}

}  // namespace contourd
