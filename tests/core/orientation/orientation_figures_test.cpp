#include "core/orientation/orientation_figures.hpp"

#include "tests/catch.hpp"

TEST_CASE("A preset is found by its name, and other words are rejected") {
  for (const std::string_view word : {"auto", "fast", "clean", "safe"}) {
    const auto preset = orientation_preset(word);
    REQUIRE(preset.has_value());
    CHECK(name_of(*preset) == word);
  }
  CHECK_FALSE(orientation_preset("").has_value());
  CHECK_FALSE(orientation_preset("Fast").has_value());
}

TEST_CASE("auto uses the resin's weights, the other presets their own") {
  const OrientationWeights own{1, 2, 3, 4, 5, 6};
  CHECK(weights_of(OrientationPreset::Auto, own) == own);
  CHECK(weights_of(OrientationPreset::Fast, own).height > weights_of(OrientationPreset::Clean, own).height);
  CHECK(weights_of(OrientationPreset::Clean, own).contacts >
        weights_of(OrientationPreset::Safe, own).contacts);
  CHECK(weights_of(OrientationPreset::Safe, own).peel > weights_of(OrientationPreset::Fast, own).peel);
  // The weight for clean surfaces is the user's choice, whatever the preset.
  for (const OrientationPreset each :
       {OrientationPreset::Fast, OrientationPreset::Clean, OrientationPreset::Safe})
    CHECK(weights_of(each, own).keep_clean == 6);
}
