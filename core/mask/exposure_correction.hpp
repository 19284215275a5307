// Turns a mask's grey values, which say how much of a pixel the part covers, into those that the projector
// needs to give each pixel that share of the light: faint values dropped, the light made uniform, the
// projector's gamma undone. In this order. Immutable after construction; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/mask/mask.hpp"

namespace contourd {

// The projector's answer to grey values.
struct ToneCurve {
  // Its light is (grey / 255) ^ gamma of white's; 0.1 to 10.
  double gamma = 1.0;
  // Coverage below this is left dark: it would cure to nothing but haze.
  std::uint8_t threshold = 0;

  bool operator==(const ToneCurve&) const = default;
};

// The grey value for each 255th of the light: 255 (light / 255) ^ (1 / gamma), rounded. 0 stays 0 and 255
// stays 255. The same on every machine: by + - * / alone, since libraries' powers differ in the last bit.
// REQUIRES: 0.1 <= gamma <= 10.
[[nodiscard]] std::array<std::uint8_t, 256> grey_for_light(double gamma);

class ExposureCorrection {
 public:
  // `uniformity`: for each pixel of the display, as it is sent, the share of the light that it is to give:
  // 255 where the lamp is darkest and all is needed, less where it is brighter.
  ExposureCorrection(const ToneCurve& tone, std::optional<Mask> uniformity);

  // Whether it changes nothing.
  [[nodiscard]] bool is_none() const { return !uniformity_ && tone_ == ToneCurve{}; }

  [[nodiscard]] std::uint8_t threshold() const { return tone_.threshold; }

  // Pixel by pixel: grey < threshold ? 0 : tone(round(grey uniformity / 255)). REQUIRES: both masks have one
  // size, which is the uniformity mask's if there is one; `to` is another object.
  void apply(const Mask& from, Mask& to) const;

 private:
  [[nodiscard]] std::uint8_t corrected(std::uint8_t grey, std::uint8_t share) const;

  ToneCurve tone_;
  std::array<std::uint8_t, 256> grey_for_light_;
  std::optional<Mask> uniformity_;
  std::optional<Mask> white_;  // what 255 becomes at each pixel; all 255 without a uniformity mask
};

}  // namespace contourd
