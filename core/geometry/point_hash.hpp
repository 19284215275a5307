// A 64-bit hash of a point's exact bits. Pure functions, thread-safe.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/contract/expects.hpp"
#include "core/geometry/facet.hpp"

namespace contourd {

// Both numbers' every bit tells: 64 bits by 64 bits, both halves of the product mixed (as in wyhash). Neither
// constant is the bits of a number, so that no factor that is one becomes 0.
[[nodiscard]] inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(a ^ 0xFFF4D049BB133111U) * (b ^ 0xFFF8476D1CE4E5B9U);
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

// REQUIRES: no -0, whose bits are other than those of 0.
[[nodiscard]] inline std::uint64_t hash_of_bits(const Point& point) {
  expects_costly(
      [&] { return !(point.x == 0 && std::signbit(point.x)) && !(point.y == 0 && std::signbit(point.y)); },
      "no coordinate is -0");
  return mixed(std::bit_cast<std::uint64_t>(point.x), std::bit_cast<std::uint64_t>(point.y));
}

// -0 and 0 are the same.
[[nodiscard]] inline std::uint64_t hash_of(const Point& point) {
  return hash_of_bits({point.x + 0.0, point.y + 0.0});  // -0 + 0 is 0
}

}  // namespace contourd
