#include "daemon/placement/plate_arrangement.hpp"

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"

namespace {

// A plate of 96 x 54 mm with pixels of 50 um.
const BuildVolume kVolume{{Pixels{1920}, Pixels{1080}, Micrometers{50}}, 100};
constexpr Nanometers kLayer{50'000};

ModelToPlace model(const std::string& name, float width, float depth, std::optional<PlateOffset> position,
                   int copies = 1, float height = 5) {
  const auto index =
      std::make_shared<const HeightIndex>(models::box({3, 3, 3}, {3 + width, 3 + depth, 3 + height}));
  return {name, index, position, copies};
}

std::optional<PlateOffset> at(double x, double y) {
  return PlateOffset{Millimeters{x}, Millimeters{y}};
}

std::string refusal_of(const std::vector<ModelToPlace>& models) {
  return testing::message_of<JobRefused>(
      [&] { check_arrangement(models, arrange(models, kVolume), kVolume, kLayer); });
}

bool on_grid(double line_mm) {
  const double pixels = line_mm / 0.05;
  return std::fabs(pixels - std::round(pixels)) < 1e-9;
}

}  // namespace

TEST_CASE("Models with a position stand there, their copies in rows around it") {
  const Arrangement places = arrange({model("a", 4, 4, at(-10, 5)), model("b", 4, 4, at(20, 0), 2)}, kVolume);
  REQUIRE(places.size() == 2);
  REQUIRE(places[0].size() == 1);
  CHECK(places[0][0] == Point{-10, 5});
  REQUIRE(places[1].size() == 2);
  CHECK(places[1][0] == Point{17, 0});
  CHECK(places[1][1] == Point{23, 0});
}

TEST_CASE("Models without a position are put side by side in the middle of the plate, on the pixel grid") {
  // 20.03 and 9.99 mm are not whole pixels, but the left front corners are on the grid all the same.
  const std::vector<ModelToPlace> models{model("a", 20.03F, 10, std::nullopt, 3),
                                         model("b", 9.99F, 20, std::nullopt, 2)};
  const Arrangement places = arrange(models, kVolume);
  CHECK(refusal_of(models).empty());
  double left = 0, right = 0, front = 0, back = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    REQUIRE(places[i].size() == static_cast<std::size_t>(models[i].copies));
    const Bounds& bounds = models[i].model->bounds();
    for (const Point& center : places[i]) {
      CHECK(on_grid(center.x - bounds.size_x() / 2));
      CHECK(on_grid(center.y - bounds.size_y() / 2));
      left = std::min(left, center.x - bounds.size_x() / 2);
      right = std::max(right, center.x + bounds.size_x() / 2);
      front = std::min(front, center.y - bounds.size_y() / 2);
      back = std::max(back, center.y + bounds.size_y() / 2);
    }
  }
  // Centred to within a pixel.
  CHECK(std::fabs(left + right) <= 0.1);
  CHECK(std::fabs(front + back) <= 0.1);
}

TEST_CASE("Models without a position keep 2 mm from those with one") {
  const std::vector<ModelToPlace> models{model("fixed", 60, 20, at(0, 0)),
                                         model("free", 10, 10, std::nullopt, 8)};
  const Arrangement places = arrange(models, kVolume);
  CHECK(refusal_of(models).empty());
  for (const Point& center : places[1]) {
    const bool beside = std::fabs(center.x) >= 30 + 2 + 5 - 1e-9 || std::fabs(center.y) >= 10 + 2 + 5 - 1e-9;
    CHECK(beside);
  }
}

TEST_CASE("A model without room on the plate is refused by name") {
  CHECK(refusal_of({model("a.stl", 90, 50, at(0, 0)), model("b.stl", 5, 5, std::nullopt)}) ==
        "there is no room on the plate (96.00 x 54.00 mm) for b.stl (5.00 x 5.00 mm) beside the others");
  CHECK(
      refusal_of({model("a.stl", 40, 50, std::nullopt, 3)}) ==
      "there is no room on the plate (96.00 x 54.00 mm) for a.stl, copy 3 of 3 (40.00 x 50.00 mm) beside the "
      "others");
}

TEST_CASE("A model over the plate's edge is refused with the distance and the edge") {
  CHECK(refusal_of({model("a.stl", 10, 10, at(45, 25))}) ==
        "a.stl (10.00 x 10.00 mm, its centre 45.00, 25.00 mm from the plate's) reaches 2.00 mm over the "
        "right edge and 3.00 mm over the back edge of the build area (96.00 x 54.00 mm)");
  CHECK(refusal_of({model("a.stl", 10, 10, at(-43.5, -22.25))})
            .find("reaches 0.50 mm over the left edge and 0.25 mm over the front edge") != std::string::npos);
  CHECK(refusal_of({model("a.stl", 10, 10, at(40, 0), 2)}).find("a.stl (copy 2) (10.00") == 0);
  CHECK(refusal_of({model("a.stl", 10, 10, at(43, 22))}).empty());
}

TEST_CASE("A model above another does not collide with it") {
  std::vector<ModelToPlace> models{model("a.stl", 10, 10, at(0, 0)), model("b.stl", 10, 10, at(0, 0))};
  CHECK_FALSE(refusal_of(models).empty());
  models[1].elevation = Elevation(Nanometers{5'000'000});
  CHECK(refusal_of(models).empty());
  models[1].elevation = Elevation(Nanometers{4'000'000});
  CHECK(refusal_of(models).find("at a height of 4.025 mm") != std::string::npos);
}

TEST_CASE("Models that collide are refused with both names, the height and the place") {
  CHECK(refusal_of({model("a.stl", 10, 10, at(0, 0)), model("b.stl", 10, 10, at(9, 9), 1, 20)}) ==
        "a.stl and b.stl collide: at a height of 0.025 mm both are at 4.03, 4.97 mm from the plate's centre");
  CHECK(refusal_of({model("a.stl", 10, 10, at(0, 0)), model("b.stl", 10, 10, at(10, 0))}).empty());
}
