// Turns a mask's grey values, which say how much of a pixel the part covers, into the values that the
// projector needs to give each pixel this share of the light: drops faint values, makes the light uniform,
// and undoes the projector's gamma, in this order. Immutable after construction; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/mask/mask.hpp"

namespace contourd {

inline constexpr double kLeastGamma = 0.1, kGreatestGamma = 10;

// The projector's response to grey values.
struct ToneCurve {
  // The light is (grey / 255) ^ gamma of white's; kLeastGamma to kGreatestGamma.
  double gamma = 1.0;
  // Coverage below this is left dark: it would only cure to haze.
  std::uint8_t threshold = 0;

  bool operator==(const ToneCurve&) const = default;
};

// Returns the grey value for each 255th of the light: 255 (light / 255) ^ (1 / gamma), rounded. 0 stays 0 and
// 255 stays 255. The same on every machine: uses + - * / alone, since the power functions of libraries differ
// in the last bit. REQUIRES: kLeastGamma <= gamma <= kGreatestGamma.
[[nodiscard]] std::array<std::uint8_t, 256> grey_for_light(double gamma);

// Returns share ^ exponent, the same on every machine. REQUIRES: 1/256 <= share <= 1; exponent > 0.
[[nodiscard]] double power_of_share(double share, double exponent);

class ExposureCorrection {
 public:
  // Makes a correction. `uniformity`: for each pixel of the display, as sent to it, the share of the light
  // that the pixel is to give: 255 where the lamp is darkest and all of it is needed, less where it is
  // brighter.
  ExposureCorrection(const ToneCurve& tone, std::optional<Mask> uniformity);

  // True if the correction changes nothing.
  [[nodiscard]] bool is_none() const { return !uniformity_ && tone_ == ToneCurve{}; }

  [[nodiscard]] std::uint8_t threshold() const { return tone_.threshold; }

  // Corrects pixel by pixel: grey < threshold ? 0 : tone(round(grey uniformity / 255)). REQUIRES: both masks
  // have one size, which is the uniformity mask's if there is one; `to` is another object.
  void apply(const Mask& from, Mask& to) const;

 private:
  [[nodiscard]] std::uint8_t corrected(std::uint8_t grey, std::uint8_t share) const;

  ToneCurve tone_;
  std::array<std::uint8_t, 256> grey_for_light_;
  std::optional<Mask> uniformity_;
  std::optional<Mask> white_;  // corrected value of 255 at each pixel; not set without a uniformity mask
};

}  // namespace contourd
