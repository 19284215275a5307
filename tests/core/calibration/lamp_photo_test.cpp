// Tests the readings from a photo with photos that are drawn of a hidden lamp.
#include "core/calibration/lamp_photo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/catch.hpp"

namespace {

constexpr int kPhotoWidth = 900, kPhotoHeight = 600;
constexpr LampGrid kCells{5, 3};

double light_at(double u, double v) {
  return 0.9 - 0.3 * u - 0.2 * v;
}

// A plain picture in the photo: a rectangle, whose corners may be given in another order.
struct Picture {
  double left = 100, top = 50, width = 700, height = 500;
};

std::uint16_t srgb(double light) {
  const double sample = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
  return static_cast<std::uint16_t>(std::lround(65535 * sample));
}

// Photographs a rectangular picture of the light, black around it, with `channels` samples a pixel.
void photograph(LampPhoto& photo, PhotoEncoding encoding, std::size_t channels, double times = 1) {
  const Picture picture;
  for (int y = 0; y < kPhotoHeight; ++y) {
    std::vector<std::uint16_t> row;
    for (int x = 0; x < kPhotoWidth; ++x) {
      const double u = (x + 0.5 - picture.left) / picture.width, v = (y + 0.5 - picture.top) / picture.height;
      const bool is_lit = u >= 0 && u < 1 && v >= 0 && v < 1;
      const double light = is_lit ? std::min(1.0, light_at(u, v) * times) : 0;
      const std::uint16_t sample = encoding == PhotoEncoding::Srgb
                                       ? srgb(light)
                                       : static_cast<std::uint16_t>(std::lround(65535 * light));
      row.insert(row.end(), channels, sample);
    }
    photo.add_row(y, row, channels);
  }
}

std::array<PhotoPoint, 4> corners_of(const Picture& picture) {
  const double right = picture.left + picture.width, below = picture.top + picture.height;
  return {PhotoPoint{picture.left, picture.top}, PhotoPoint{right, picture.top}, PhotoPoint{right, below},
          PhotoPoint{picture.left, below}};
}

std::string photo_refusal(const std::array<PhotoPoint, 4>& corners, double times) {
  try {
    LampPhoto photo(corners, kCells, PhotoEncoding::Linear);
    photograph(photo, PhotoEncoding::Linear, 1, times);
    (void)photo.readings();
  } catch (const CalibrationRefused& refused) {
    return refused.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A photo's cells have the light at their middles, by either encoding, grey or coloured") {
  for (const PhotoEncoding encoding : {PhotoEncoding::Linear, PhotoEncoding::Srgb})
    for (const std::size_t channels : {1U, 3U}) {
      LampPhoto photo(corners_of({}), kCells, encoding);
      photograph(photo, encoding, channels);
      const std::vector<LampReading> readings = photo.readings();
      REQUIRE(readings.size() == 15);
      for (int cell = 0; cell < 15; ++cell) {
        const auto& [place, light] = readings[static_cast<std::size_t>(cell)];
        CHECK(place.x == kCells.middle(cell).x);
        CHECK(light == Approx(light_at((place.x + 1) / 2, (place.y + 1) / 2)).margin(1e-3));
      }
    }
}

TEST_CASE("The corner with one dot is the display's upper left, however the camera was held") {
  const std::array<PhotoPoint, 4> straight = corners_of({});
  for (const bool is_mirrored : {false, true})
    for (std::size_t turn = 0; turn < 4; ++turn) {
      std::array<PhotoPoint, 4> corners{};
      for (std::size_t i = 0; i < 4; ++i)
        corners[i] = straight[(turn + (is_mirrored ? 4 - i : i)) % 4];
      LampPhoto photo(corners, {3, 3}, PhotoEncoding::Linear);
      photograph(photo, PhotoEncoding::Linear, 1);
      // The middle of the first cell is a sixth of the picture from its corner, along both sides.
      const Picture picture;
      const double u = std::abs((corners[0].x - picture.left) / picture.width - 1.0 / 6);
      const double v = std::abs((corners[0].y - picture.top) / picture.height - 1.0 / 6);
      CAPTURE(is_mirrored, turn);
      CHECK(photo.readings().front().light == Approx(light_at(u, v)).margin(2e-3));
    }
}

TEST_CASE("A photo from the side is straightened") {
  // Corners of a picture that lies askew: the places follow from the projective map, here by its inverse on a
  // light that is even along the picture's lines.
  const std::array<PhotoPoint, 4> corners{PhotoPoint{200, 100}, PhotoPoint{760, 60}, PhotoPoint{860, 560},
                                          PhotoPoint{60, 500}};
  LampPhoto photo(corners, {3, 3}, PhotoEncoding::Linear);
  // The diagonals of a picture cross in its middle, also in a photo: a bright spot there is in the middle
  // cell.
  const double along = ((corners[1].x - corners[0].x) * (corners[3].y - corners[1].y) -
                        (corners[1].y - corners[0].y) * (corners[3].x - corners[1].x)) /
                       ((corners[2].x - corners[0].x) * (corners[3].y - corners[1].y) -
                        (corners[2].y - corners[0].y) * (corners[3].x - corners[1].x));
  const double x = corners[0].x + along * (corners[2].x - corners[0].x);
  const double y = corners[0].y + along * (corners[2].y - corners[0].y);
  constexpr double kSpot = 20;  // pixels
  for (int row = 0; row < kPhotoHeight; ++row) {
    std::vector<std::uint16_t> pixels(kPhotoWidth, 10'000);
    for (int column = 0; column < kPhotoWidth; ++column)
      if (std::hypot(column + 0.5 - x, row + 0.5 - y) < kSpot)
        pixels[static_cast<std::size_t>(column)] = 60'000;
    photo.add_row(row, pixels, 1);
  }
  const std::vector<LampReading> readings = photo.readings();
  for (std::size_t cell = 0; cell < readings.size(); ++cell)
    CHECK((readings[cell].light > 10'001.0 / 65535) == (cell == 4));
}

TEST_CASE("Photos and corners that cannot be used are refused with their figures") {
  const std::array<PhotoPoint, 4> good = corners_of({});
  REQUIRE(photo_refusal(good, 1).empty());
  CHECK(lacking(photo_refusal(good, 1.3), {"overexposed", "of cell 1 of 15 are white"}).empty());
  CHECK(lacking(photo_refusal(good, 0.04), {"too dark", "5 % are needed"}).empty());
  CHECK(lacking(photo_refusal({good[0], good[2], good[1], good[3]}, 1),
                {"100,50 800,550 800,50", "do not go around"})
            .empty());
  CHECK(lacking(photo_refusal({good[0], good[0], good[2], good[3]}, 1), {"do not go around"}).empty());
  CHECK(lacking(photo_refusal({PhotoPoint{1, 1}, {21, 1}, {21, 21}, {1, 21}}, 1),
                {"cell 1 of 15 has", "fewer than 100"})
            .empty());
  CHECK(
      lacking(photo_refusal({PhotoPoint{1e6, 1e6}, {2e6, 1e6}, {2e6, 2e6}, {1e6, 2e6}}, 1), {"has 0 pixels"})
          .empty());
  CHECK(lacking(photo_refusal({PhotoPoint{0, 0}, {1e300, 0}, {1e300, 1e300}, {0, 1e300}}, 1),
                {"pixels in the photo"})
            .empty());
}
