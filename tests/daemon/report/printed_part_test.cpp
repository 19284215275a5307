#include "daemon/report/printed_part.hpp"

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/report/report_fixture.hpp"

namespace {

// Returns the report on this number of layers of 0.1 mm.
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

Mask picture_of(const PrintReport& report, ContourEngine engine = testing::engine_of_a_box()) {
  const auto preview = draw_printed_part(report, engine, MaskBudget::Clock::now() + 1h).value();
  return decode_png(preview.png, preview.side, preview.side);
}

int brightest(const Mask& picture) {
  return *std::ranges::max_element(picture.pixels());
}

}  // namespace

TEST_CASE(
    "The picture of a completed print shows the whole part, and of an unfinished print the rest faintly") {
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

TEST_CASE("A layer that lacks light is not drawn as printed") {
  PrintReport report = printed(6, PrintOutcome::Canceled);
  report.layers.back().complete = false;
  CHECK(picture_of(report) == picture_of(printed(5, PrintOutcome::Canceled)));
}

TEST_CASE("The part is drawn from the masks that were shown, at whatever height they were cut") {
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

TEST_CASE("A mirror in the light's path does not mirror the picture of the part") {
  const PrintReport report = printed(10, PrintOutcome::Done);
  CHECK(picture_of(report) == picture_of(report, testing::engine_of_a_box(true)));
}

TEST_CASE("A part above the plate is drawn at its height") {
  // The lower half of the layers is dark, and the model's upper half was not printed.
  const Mask lifted =
      picture_of(printed(10, PrintOutcome::Done), testing::engine_of_a_box(false, Nanometers{500'000}));
  CHECK(lifted.lit_pixels() > 0);
  CHECK(picture_of(printed(5, PrintOutcome::Done), testing::engine_of_a_box(false, Nanometers{500'001}))
            .lit_pixels() == 0);
}

TEST_CASE("After the deadline, no picture of the part is drawn") {
  ContourEngine engine = testing::engine_of_a_box();
  const auto past = MaskBudget::Clock::now() - 1s;
  CHECK_FALSE(draw_printed_part(printed(10, PrintOutcome::Done), engine, past));
  // A picture without layers needs no time.
  PrintReport nothing = printed(0, PrintOutcome::Failed);
  nothing.summary.height_mm = 0;
  REQUIRE(draw_printed_part(nothing, engine, past));
  const PartPreview dark = *draw_printed_part(nothing, engine, past);
  CHECK(decode_png(dark.png, dark.side, dark.side).lit_pixels() == 0);
}

TEST_CASE("The contacts of supports are marked at their places in the picture, with their causes") {
  for (const bool mirrored : {false, true}) {
    PrintReport report = printed(10, PrintOutcome::Done);
    Supports& supports = report.summary.supports.emplace();
    // Contacts at the box's lower front corners, left and right, and at its upper right back corner.
    for (const PlatePoint& corner : {PlatePoint{-1.5, -1, 0}, {1.5, -1, 0}, {1.5, 1, 1}})
      supports.contacts.push_back({corner, {0, 0, -1}, ContactCause::Peel, 1});
    supports.contacts[1].cause = ContactCause::Overhang;
    ContourEngine engine = testing::engine_of_a_box(mirrored);
    const PartPreview preview = draw_printed_part(report, engine, MaskBudget::Clock::now() + 1h).value();
    const Mask picture = decode_png(preview.png, preview.side, preview.side);
    REQUIRE(preview.contacts.size() == 3);
    CHECK(preview.contacts[0].cause == ContactCause::Peel);
    CHECK(preview.contacts[1].cause == ContactCause::Overhang);
    // These corners are the outline's leftmost, lowest and rightmost points; anti-aliasing rounds its corners
    // by up to two pixels of the display.
    int left = 1000, right = 0, bottom = 0;
    for (int row = 0; row < preview.side.count(); ++row) {
      for (int column = 0; column < preview.side.count(); ++column) {
        if (picture.row(row)[static_cast<std::size_t>(column)] == 0) continue;
        left = std::min(left, column);
        right = std::max(right, column);
        bottom = std::max(bottom, row);
      }
    }
    const double pixel = (right - left) / (30 * 0.819 + 20 * 0.574);
    CHECK(std::abs(preview.contacts[0].at.x - left) < 2 * pixel);
    CHECK(std::abs(preview.contacts[1].at.y - bottom) < 2 * pixel);
    CHECK(std::abs(preview.contacts[2].at.x - right) < 2 * pixel);
  }
}
