// Random numbers that are the same on every machine: a seed determines a print. Not thread-safe.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hw/clock.hpp"

namespace contourd::rig {

class Dice {
 public:
  // Different streams of one seed are independent.
  explicit Dice(std::uint64_t seed, std::uint64_t stream = 0)
      : state_(seed * 0x9e3779b97f4a7c15U + (stream + 1) * 0xd1342543de82ef95U) {
    next();
  }

  // Returns the next 64 random bits (SplitMix64).
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }

  // Returns a number in [0, 1).
  double fraction() { return static_cast<double>(next() >> 11U) * 0x1p-53; }
  bool chance(double probability) { return fraction() < probability; }
  // Returns a number in [low, high].
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(high - low + 1));
  }
  Duration between(Duration low, Duration high) { return Duration{between(low.count(), high.count())}; }
  // Returns a duration that is uniform in its logarithm, so that short ones are as frequent as long ones.
  // REQUIRES: low > 0.
  Duration spread(Duration low, Duration high) {
    const double ratio = static_cast<double>(high.count()) / static_cast<double>(low.count());
    const double steps = std::floor(fraction() * std::log2(ratio) * 16);
    return std::min(
        high, Duration{static_cast<std::int64_t>(static_cast<double>(low.count()) * std::exp2(steps / 16))});
  }

 private:
  std::uint64_t state_;
};

}  // namespace contourd::rig
