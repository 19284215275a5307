#include "core/mask/exposure_correction.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

Mask draw_mask(int width, int height) {
  Mask mask(Pixels{width}, Pixels{height});
  for (std::int32_t y = 0; y < height; ++y) {
    // Runs of dark, white and arbitrary pixels, as in masks.
    for (std::size_t x = 0; x < static_cast<std::size_t>(width);) {
      const auto kind = draw(0, 2);
      for (auto run = draw(1, 20); run > 0 && x < static_cast<std::size_t>(width); --run, ++x) {
        mask.row(y)[x] = static_cast<std::uint8_t>(kind == 0 ? 0 : kind == 1 ? 255 : draw(0, 255));
      }
    }
  }
  return mask;
}

}  // namespace

TEST_CASE("The grey values for a gamma are the rounded powers") {
  for (const double gamma : {0.1, 0.45, 1.0, 1.8, 2.2, 2.4, 10.0}) {
    CAPTURE(gamma);
    const auto table = grey_for_light(gamma);
    CHECK(table[0] == 0);
    CHECK(table[255] == 255);
    CHECK(std::ranges::is_sorted(table));
    for (std::size_t light = 0; light < 256; ++light) {
      CHECK(table[light] == std::lround(255 * std::pow(static_cast<double>(light) / 255, 1 / gamma)));
    }
  }
}

TEST_CASE("A gamma of 1 changes nothing") {
  const auto table = grey_for_light(1.0);
  for (std::size_t light = 0; light < 256; ++light)
    CHECK(table[light] == light);
}

TEST_CASE("The grey values for a gamma are these bytes on every machine") {
  const auto checksum = [](double gamma) {
    std::uint32_t hash = 2166136261U;  // FNV-1a
    for (const std::uint8_t grey : grey_for_light(gamma))
      hash = (hash ^ grey) * 16777619U;
    return hash;
  };
  const auto table = grey_for_light(2.2);
  CHECK(std::vector<int>(table.begin(), table.begin() + 8) ==
        std::vector<int>{0, 21, 28, 34, 39, 43, 46, 50});
  CHECK(table[128] == 186);
  CHECK(checksum(2.2) == 3371434441U);
  CHECK(checksum(1.0) == 2426689733U);
  CHECK(checksum(0.45) == 2071339275U);
}

TEST_CASE("A correction that changes nothing reports that") {
  CHECK(ExposureCorrection({}, std::nullopt).is_none());
  CHECK_FALSE(ExposureCorrection({2.2, 0}, std::nullopt).is_none());
  CHECK_FALSE(ExposureCorrection({1.0, 5}, std::nullopt).is_none());
  CHECK_FALSE(ExposureCorrection({}, Mask(Pixels{1}, Pixels{1})).is_none());
}

TEST_CASE("Every pixel is thresholded, dimmed by the uniformity mask, then sent through the tone curve") {
  CHECK(rc::check([] {
    const auto width = static_cast<int>(draw(1, 70)), height = static_cast<int>(draw(1, 5));
    const Mask mask = draw_mask(width, height);
    const ToneCurve tone{static_cast<double>(draw(1, 40)) / 10, static_cast<std::uint8_t>(draw(0, 255))};
    const bool has_uniformity = draw(0, 1) == 1;
    const Mask uniformity = draw_mask(width, height);
    Mask corrected = draw_mask(width, height);
    ExposureCorrection(tone, has_uniformity ? std::optional(uniformity) : std::nullopt)
        .apply(mask, corrected);
    const auto curve = grey_for_light(tone.gamma);
    for (std::size_t i = 0; i < mask.pixels().size(); ++i) {
      const int grey = mask.pixels()[i], share = has_uniformity ? uniformity.pixels()[i] : 255;
      const auto dimmed = static_cast<std::size_t>(std::lround(grey * share / 255.0));
      RC_ASSERT(corrected.pixels()[i] == (grey < tone.threshold ? 0 : curve[dimmed]));
    }
  }));
}
