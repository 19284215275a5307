#include "daemon/printed_part.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

// A box of 3 x 2 x 1 mm in the middle of the display, on the plate or above it.
ContourEngine engine_of_a_box(bool mirrored = false, Nanometers lift = {}) {
  const DisplayGeometry display{Pixels{64}, Pixels{48}, Micrometers{100.0}, mirrored, mirrored};
  const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {3, 2, 1})),
                          Elevation(lift)};
  return {std::vector{PlateModel{box, {PixelMap::true_scale(display, {1.5, 1})}}},
          EngineSettings{.display = display}};
}

// That many layers of 0.1 mm.
PrintReport printed(int layers, PrintOutcome outcome) {
  PrintReport report;
  report.outcome = outcome;
  report.summary.height_mm = 1;
  for (int i = 0; i < layers; ++i) {
    LayerRecord& layer = report.layers.emplace_back();
    layer.layer = i;
    layer.bottom = Nanometers{100'000 * i};
    layer.thickness = Nanometers{100'000};
    layer.mask_height = Nanometers{100'000 * i + 50'000};
    layer.complete = true;
  }
  return report;
}

Mask picture_of(const PrintReport& report, ContourEngine engine = engine_of_a_box()) {
  return draw_printed_part(report, engine, MaskBudget::Clock::now() + 1h).value();
}

int brightest(const Mask& picture) {
  return *std::ranges::max_element(picture.pixels());
}

}  // namespace

TEST_CASE("A print that is done shows the whole part, and one that ended before shows the rest faint") {
  const Mask whole = picture_of(printed(10, PrintOutcome::Done));
  CHECK(brightest(whole) > 150);
  const Mask half = picture_of(printed(5, PrintOutcome::Canceled));
  CHECK(half.lit_pixels() == whole.lit_pixels());
  CHECK(half != whole);
  CHECK(brightest(half) > 150);
  const Mask none = picture_of(printed(0, PrintOutcome::Failed));
  CHECK(none.lit_pixels() == whole.lit_pixels());
  CHECK(brightest(none) < 100);
}

TEST_CASE("A layer that had not all its light is no part of the part") {
  PrintReport report = printed(6, PrintOutcome::Canceled);
  report.layers.back().complete = false;
  CHECK(picture_of(report) == picture_of(printed(5, PrintOutcome::Canceled)));
}

TEST_CASE("The part is made of the masks that were shown, wherever they were cut") {
  PrintReport report = printed(10, PrintOutcome::Done);
  for (std::size_t i = 5; i < report.layers.size(); ++i)
    report.layers[i].mask_height = Nanometers{2'000'000};  // above the model: dark
  const Mask lower_half = picture_of(report);
  CHECK(lower_half.lit_pixels() > 0);
  CHECK(lower_half != picture_of(printed(10, PrintOutcome::Done)));
  for (LayerRecord& layer : report.layers)
    layer.mask_height = Nanometers{2'000'000};
  CHECK(picture_of(report).lit_pixels() == 0);
}

TEST_CASE("A mirror in the light's path does not turn the picture of the part round") {
  const PrintReport report = printed(10, PrintOutcome::Done);
  CHECK(picture_of(report) == picture_of(report, engine_of_a_box(true)));
}

TEST_CASE("A part above the plate is drawn where it stands") {
  // The lower half of the layers is dark, and the model's upper half was not printed.
  const Mask lifted =
      picture_of(printed(10, PrintOutcome::Done), engine_of_a_box(false, Nanometers{500'000}));
  CHECK(lifted.lit_pixels() > 0);
  CHECK(
      picture_of(printed(5, PrintOutcome::Done), engine_of_a_box(false, Nanometers{500'001})).lit_pixels() ==
      0);
}

TEST_CASE("Where there is no time left, there is no picture of the part") {
  ContourEngine engine = engine_of_a_box();
  const auto past = MaskBudget::Clock::now() - 1s;
  CHECK_FALSE(draw_printed_part(printed(10, PrintOutcome::Done), engine, past));
  // It needs none of it.
  PrintReport nothing = printed(0, PrintOutcome::Failed);
  nothing.summary.height_mm = 0;
  REQUIRE(draw_printed_part(nothing, engine, past));
  CHECK(draw_printed_part(nothing, engine, past)->lit_pixels() == 0);
}
