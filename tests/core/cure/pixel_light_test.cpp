#include "core/cure/pixel_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "tests/catch.hpp"

namespace {

constexpr std::size_t kSide = 41, kMiddle = 20;

std::vector<float> spot(const PixelLight& light) {
  std::vector<float> picture(kSide * kSide);
  picture[kMiddle * kSide + kMiddle] = 1;
  LightSpread(light, kSide, kSide).apply(picture);
  return picture;
}

float at(const std::vector<float>& picture, std::size_t x, std::size_t y) {
  return picture[y * kSide + x];
}

}  // namespace

TEST_CASE("Light without a spread stays within its pixel") {
  std::vector<float> expected(kSide * kSide);
  expected[kMiddle * kSide + kMiddle] = 1;
  CHECK(spot({}) == expected);
}

namespace {

// Returns the light that a lit stretch of a line gives to a place beside its middle, by adding up Gaussians.
double light_of_stretch(double from, double to, double at, double sigma) {
  constexpr int kParts = 20'000;
  const double part = (to - from) / kParts;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double sigmas = (from + (i + 0.5) * part - at) / sigma;
    sum += std::exp(-sigmas * sigmas / 2) * part / (sigma * std::sqrt(2 * std::numbers::pi));
  }
  return sum;
}

constexpr std::array kWidths{0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.5, 2.0};  // pixels

}  // namespace

TEST_CASE("A pixel's light is its square, spread by a Gaussian, and none of it is lost") {
  for (const double sigma : kWidths) {
    CAPTURE(sigma);
    const std::vector<float> picture = spot({{{sigma, 1}}});
    CHECK(std::accumulate(picture.begin(), picture.end(), 0.0F) == Approx(1));
    const auto of = [sigma](double pixels) { return light_of_stretch(pixels - 0.5, pixels + 0.5, 0, sigma); };
    // Light beyond 3.75 sigma, 0.0002 of all, is given to the others.
    const auto expected = [&](double light) { return Approx(light).epsilon(0.001).margin(1e-4); };
    CHECK(at(picture, kMiddle, kMiddle) == expected(of(0) * of(0)));
    CHECK(at(picture, kMiddle + 1, kMiddle) == expected(of(1) * of(0)));
    CHECK(at(picture, kMiddle, kMiddle - 2) == expected(of(0) * of(2)));
    CHECK(at(picture, kMiddle + 1, kMiddle + 1) == expected(of(1) * of(1)));
  }
}

TEST_CASE("A wall is where the light of a lit area falls to the least dose, for a Gaussian of any width") {
  for (const double sigma : kWidths) {
    std::vector<float> picture(kSide * kSide);
    for (std::size_t i = 0; i < picture.size(); ++i)
      picture[i] = i % kSide <= kMiddle ? 1.0F : 0.0F;
    LightSpread({{{sigma, 1}}}, kSide, kSide).apply(picture);
    const auto bright = static_cast<double>(at(picture, kMiddle, kMiddle));
    const auto dark = static_cast<double>(at(picture, kMiddle + 1, kMiddle));
    CAPTURE(sigma, bright, dark);
    CHECK(at(picture, kMiddle - 10, kMiddle) == Approx(1));  // even within the area
    CHECK(wall_between(bright, dark, 0.5) == Approx(0.5).margin(1e-4));
    for (const double place : {0.1, 0.3, 0.45, 0.6, 0.9}) {
      const double least = light_of_stretch(-13, 0.5, place, sigma);
      if (!(least > 1.001 * dark && least <= 0.999 * bright)) continue;
      CAPTURE(place);
      CHECK(wall_between(bright, dark, least) == Approx(place).margin(0.004));  // pixels
    }
  }
}

TEST_CASE("Two Gaussians add up by their shares") {
  const std::vector<float> narrow = spot({{{0.5, 1}}}), wide = spot({{{3, 1}}}),
                           both = spot({{{0.5, 3}, {3, 1}}});
  for (std::size_t i = 0; i < both.size(); ++i)
    CHECK(both[i] == Approx(0.75F * narrow[i] + 0.25F * wide[i]).margin(1e-7));
}

TEST_CASE("A picture that is lit evenly keeps its light away from its rim") {
  std::vector<float> picture(kSide * kSide, 0.7F);
  LightSpread({{{1.2, 1}}}, kSide, kSide).apply(picture);
  CHECK(at(picture, kMiddle, kMiddle) == Approx(0.7F));
  CHECK(at(picture, 0, kMiddle) < 0.5F);
}
