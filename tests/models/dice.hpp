// Pseudo-random numbers that are the same on every machine: a seed determines everything that is drawn.
// Not thread-safe.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/geometry/facet.hpp"

namespace contourd::models {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  // Makes one of a seed's streams, which are independent of each other.
  Dice(std::uint64_t seed, std::uint64_t stream)
      : state_(seed * 0x9E3779B97F4A7C15U + (stream + 1) * 0xD1342543DE82EF95U) {
    roll();
  }

  // Returns the next 64 random bits (SplitMix64).
  std::uint64_t roll() {
    std::uint64_t bits = state_ += 0x9E3779B97F4A7C15U;
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9U;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBU;
    return bits ^ (bits >> 31);
  }

  // Returns a number in [0, 1).
  double fraction() { return static_cast<double>(roll() >> 11) * 0x1p-53; }
  bool chance(double probability) { return fraction() < probability; }
  // Returns a number in [low, high).
  double between(double low, double high) { return low + (high - low) * fraction(); }
  // Returns a number in [0, count). REQUIRES: count > 0.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(roll() % count); }
  // Returns a number in [low, high].
  std::int64_t whole(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(roll() % static_cast<std::uint64_t>(high - low + 1));
  }
  // Returns a time in [low, high].
  std::chrono::nanoseconds between(std::chrono::nanoseconds low, std::chrono::nanoseconds high) {
    return std::chrono::nanoseconds{whole(low.count(), high.count())};
  }
  // Returns a time that is uniform in its logarithm, so that short ones are as frequent as long ones.
  // REQUIRES: low > 0.
  std::chrono::nanoseconds spread(std::chrono::nanoseconds low, std::chrono::nanoseconds high) {
    const double least = static_cast<double>(low.count());
    const double steps = std::floor(fraction() * std::log2(static_cast<double>(high.count()) / least) * 16);
    return std::min(high, std::chrono::nanoseconds{static_cast<std::int64_t>(least * std::exp2(steps / 16))});
  }
  // Returns a point in the ball of this radius around the origin.
  Vertex in_ball(double radius) {
    while (true) {
      const double x = between(-1.0, 1.0), y = between(-1.0, 1.0), z = between(-1.0, 1.0);
      if (x * x + y * y + z * z > 1) continue;
      return {static_cast<float>(x * radius), static_cast<float>(y * radius), static_cast<float>(z * radius)};
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace contourd::models
