#include "core/cure/pixel_light.hpp"

#include <algorithm>
#include <cmath>
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

TEST_CASE("A pixel's light spreads as a Gaussian and none of it is lost") {
  const std::vector<float> picture = spot({{{0.8, 1}}});
  CHECK(std::accumulate(picture.begin(), picture.end(), 0.0F) == Approx(1));
  const float middle = at(picture, kMiddle, kMiddle);
  CHECK(at(picture, kMiddle + 1, kMiddle) / middle == Approx(std::exp(-1 / (2 * 0.64))));
  CHECK(at(picture, kMiddle, kMiddle - 2) / middle == Approx(std::exp(-4 / (2 * 0.64))));
  CHECK(at(picture, kMiddle + 1, kMiddle + 1) / middle == Approx(std::exp(-2 / (2 * 0.64))));
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
