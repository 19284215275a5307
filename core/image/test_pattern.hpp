// Test patterns for setting up a projector: they show focus, mirroring, edges and scale. Thread-safe (no
// shared state).
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

enum class TestPattern {
  White,
  Black,
  Grid,        // a line every 5 mm from the centre out, the two through the centre wider
  Checker,     // squares of 5 mm, two of them meeting at the centre
  Focus,       // blocks of one-pixel lines, upright and lying, and of single pixels
  Border,      // the outermost pixels, a cross through the centre, a filled square at top left
  Dimensions,  // two rulers through the centre with a tick every millimetre, a longer one every fifth and
               // tenth
};
inline constexpr std::array kTestPatterns{TestPattern::White,     TestPattern::Black, TestPattern::Grid,
                                          TestPattern::Checker,   TestPattern::Focus, TestPattern::Border,
                                          TestPattern::Dimensions};

[[nodiscard]] std::string_view name_of(TestPattern pattern);
// Returns the pattern of this name; nullopt if there is none.
[[nodiscard]] std::optional<TestPattern> find_test_pattern(std::string_view name);

// Draws a pattern for a display of this size with this pitch on the film. REQUIRES: both sides 1 to 16384
// pixels, as in a mask; a pitch above 0.
[[nodiscard]] Mask draw_test_pattern(TestPattern pattern, Pixels width, Pixels height, Micrometers pitch);

// Returns the length, end to end, of the ruler of Dimensions along a side of that many pixels: the whole tens
// of millimetres (whole millimetres on a side below 10 mm) that fit into nine tenths of it.
[[nodiscard]] Millimeters ruler_length(Pixels side, Micrometers pitch);

}  // namespace contourd
