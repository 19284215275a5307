// A 64-bit hash of a point's exact bits. Pure functions, thread-safe.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/contract/expects.hpp"
#include "core/geometry/facet.hpp"

namespace contourd {

// Mixes two numbers so that each of their bits affects the hash: 64 bits by 64 bits, both halves of the
// product combined (as in wyhash). Both constants are NaN bit patterns, so that the bits of a coordinate
// never make a factor 0.
[[nodiscard]] inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(a ^ 0xFFF4D049BB133111U) * (b ^ 0xFFF8476D1CE4E5B9U);
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

// Hashes the point's bits. REQUIRES: no coordinate is -0, whose bits differ from those of 0.
[[nodiscard]] inline std::uint64_t hash_of_bits(const Point& point) {
  expects_costly(
      [&] { return !(point.x == 0 && std::signbit(point.x)) && !(point.y == 0 && std::signbit(point.y)); },
      "no coordinate is -0");
  return mixed(std::bit_cast<std::uint64_t>(point.x), std::bit_cast<std::uint64_t>(point.y));
}

// Hashes the point; -0 and 0 hash alike.
[[nodiscard]] inline std::uint64_t hash_of(const Point& point) {
  return hash_of_bits({point.x + 0.0, point.y + 0.0});  // -0 + 0 is 0
}

}  // namespace contourd
