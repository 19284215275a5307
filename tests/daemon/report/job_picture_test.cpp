#include "daemon/report/job_picture.hpp"

#include "daemon/report/print_report.hpp"
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

Mask picture_of(const PrintReport& report, const ContourEngine& engine = testing::engine_of_a_box()) {
  return draw_job(engine, nullptr, printed_height(report)).picture;
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

TEST_CASE("A mirror in the light's path does not mirror the picture of the part") {
  const PrintReport report = printed(10, PrintOutcome::Done);
  CHECK(picture_of(report) == picture_of(report, testing::engine_of_a_box(true)));
}

TEST_CASE("A part above the plate is drawn at its height") {
  const PrintReport canceled = printed(10, PrintOutcome::Canceled);  // up to 1 mm above the plate
  const Mask whole = picture_of(canceled);
  const Mask half = picture_of(canceled, testing::engine_of_a_box(false, Nanometers{500'000}));
  // Rounding may change some pixels at the upper end of the printed part.
  const Mask standing = picture_of(printed(5, PrintOutcome::Canceled));
  int differing = 0;
  for (std::size_t i = 0; i < half.pixels().size(); ++i)
    differing += half.pixels()[i] != standing.pixels()[i] ? 1 : 0;
  CHECK(differing < 10);
  CHECK(half != whole);
  CHECK(brightest(picture_of(canceled, testing::engine_of_a_box(false, Nanometers{1'100'000}))) < 100);
}

TEST_CASE("Each copy of a model is drawn at its place on the plate") {
  const DisplayGeometry display{Pixels{64}, Pixels{48}, Micrometers{100.0}};
  const ContourEngine one = testing::engine_of_a_box();
  PlateModel model = one.models().front();
  model.copies = {PixelMap::true_scale(display, {4.5, 1}), PixelMap::true_scale(display, {-0.5, 1})};
  const ContourEngine two(std::vector{model}, EngineSettings{.display = display});
  const Preview drawn = draw_job(two, nullptr);
  const auto grey_at = [&](double x, double y, double z) {
    const PixelPoint at = drawn.at({x, y, z});
    return drawn.picture.row(static_cast<std::int32_t>(at.y))[static_cast<std::size_t>(at.x)];
  };
  // The tops of both copies, whose middles are at -3 and 2 mm, and the gap between them.
  CHECK(grey_at(-3, 0, 1) > 150);
  CHECK(grey_at(2, 0, 1) > 150);
  CHECK(grey_at(-1, 0.9, 1) == 0);
}

TEST_CASE("The contacts of supports are marked at their places in the picture, with their causes") {
  for (const bool mirrored : {false, true}) {
    Supports supports;
    // Contacts at the box's lower front corners, left and right, and at its upper right back corner.
    for (const PlatePoint& corner : {PlatePoint{-1.5, -1, 0}, {1.5, -1, 0}, {1.5, 1, 1}})
      supports.contacts.push_back({corner, {0, 0, -1}, ContactCause::Peel, 1});
    supports.contacts[1].cause = ContactCause::Overhang;
    const JobPicture preview =
        encode_picture(draw_job(testing::engine_of_a_box(mirrored), &supports), &supports);
    const Mask picture = decode_png(preview.png, preview.side, preview.side);
    REQUIRE(preview.contacts.size() == 3);
    CHECK(preview.contacts[0].cause == ContactCause::Peel);
    CHECK(preview.contacts[1].cause == ContactCause::Overhang);
    // These corners are the outline's leftmost, lowest and rightmost points.
    int left = 1000, right = 0, bottom = 0;
    for (int row = 0; row < preview.side.count(); ++row) {
      for (int column = 0; column < preview.side.count(); ++column) {
        if (picture.row(row)[static_cast<std::size_t>(column)] == 0) continue;
        left = std::min(left, column);
        right = std::max(right, column);
        bottom = std::max(bottom, row);
      }
    }
    CHECK(std::abs(preview.contacts[0].at.x - left) <= 1);
    CHECK(std::abs(preview.contacts[1].at.y - (bottom + 1)) <= 1);
    CHECK(std::abs(preview.contacts[2].at.x - (right + 1)) <= 1);
  }
}
