// The view that the pictures of models have in common: the turn of the eye, the light and the shades. Values;
// thread-safe as any value is.
#pragma once

#include <algorithm>
#include <cstdint>

namespace contourd {

// A vector above the plate: to the right, to the back and up.
struct PlateVector {
  double x, y, z;
};

// Sine and cosine of the eye's turn to the right, 35 degrees.
inline constexpr double kSinTurn = 0.573576436, kCosTurn = 0.819152044;

// The direction to the light, which is at the left, in front and above; about of length 1.
inline constexpr PlateVector kLight{-0.36, -0.56, 0.75};

// Returns the grey value of a surface by the cosine of the angle between its normal and the light.
[[nodiscard]] inline std::uint8_t shade_of(double cosine) {
  constexpr double kAmbient = 60, kDiffuse = 190;
  return static_cast<std::uint8_t>(kAmbient + kDiffuse * std::clamp(cosine, 0.0, 1.0));
}

}  // namespace contourd
