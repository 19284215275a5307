#include "core/image/part_picture.hpp"

#include "core/image/picture_view.hpp"
#include "tests/catch.hpp"

namespace {

constexpr Pixels kPictureSide{200};

// Returns a mask that is lit where `is_there` is true for a pixel's column and row.
Mask mask_of(const PartPicture::Box& box, const std::function<bool(int, int)>& is_there) {
  Mask mask(box.columns, box.rows);
  for (int row = 0; row < box.rows.count(); ++row) {
    for (int column = 0; column < box.columns.count(); ++column)
      mask.row(row)[static_cast<std::size_t>(column)] = is_there(column, row) ? 255 : 0;
  }
  return mask;
}

// Returns a picture of the part given by `is_there`, a predicate on a column, a row and a share of the
// height.
PartPicture picture_of(const PartPicture::Box& box, const std::function<bool(int, int, double)>& is_there) {
  PartPicture picture(box, kPictureSide);
  for (int i = 0; i < picture.masks(); ++i) {
    const double height = picture.next_height();
    picture.add(mask_of(box, [&](int column, int row) { return is_there(column, row, height); }));
  }
  return picture;
}

Mask drawn(const PartPicture::Box& box, const std::function<bool(int, int, double)>& is_there) {
  return picture_of(box, is_there).draw().picture;
}

bool is_lit(const Mask& picture, double x, double y) {
  const auto side = static_cast<double>(picture.width().count());
  if (!(0 <= x && x < side && 0 <= y && y < side)) return false;
  return picture.row(static_cast<std::int32_t>(y))[static_cast<std::size_t>(x)] > 0;
}

bool everywhere(int, int, double) {
  return true;
}

std::vector<int> column_of(const Mask& picture, int column) {
  std::vector<int> greys;
  for (int row = 0; row < picture.height().count(); ++row)
    greys.push_back(picture.row(row)[static_cast<std::size_t>(column)]);
  return greys;
}

int brightest(const Mask& picture) {
  return *std::ranges::max_element(picture.pixels());
}

constexpr PartPicture::Box kBlock{Pixels{60}, Pixels{60}, 60};

}  // namespace

TEST_CASE("A picture of a part is a square around it, no larger than the given side") {
  for (const PartPicture::Box& box :
       {kBlock, PartPicture::Box{Pixels{300}, Pixels{20}, 3}, PartPicture::Box{Pixels{5}, Pixels{5}, 900}}) {
    const Mask picture = drawn(box, everywhere);
    CHECK(picture.width() == picture.height());
    CHECK(picture.width() <= kPictureSide);
    CHECK(picture.width().count() >= kPictureSide.count() * 9 / 10);
  }
  const Mask corner =
      drawn(kBlock, [](int column, int row, double at) { return column < 20 && row < 20 && at < 0.3; });
  CHECK(corner.width().count() < kPictureSide.count() / 2);
}

TEST_CASE("A block covers the projected area of its three visible faces") {
  const PartPicture::Box box{Pixels{70}, Pixels{50}, 40};
  const double scale = PartPicture::scale_of(box, kPictureSide);
  // Areas times the cosine of each face's angle to the eye, which is turned by 35 degrees and raised by 30.
  const double top = 70 * 50 * 0.5, front = 70 * 40 * 0.819 * 0.866, right = 50 * 40 * 0.574 * 0.866;
  const double expected = (top + front + right) * scale * scale;
  // The tolerance is half a pixel along an outline of some 600 pixels.
  CHECK(std::abs(static_cast<double>(drawn(box, everywhere).lit_pixels()) - expected) < 300);
}

TEST_CASE("The top of a block is brighter than its front, and that than its right side") {
  const Mask picture = drawn(kBlock, everywhere);
  const int side = picture.width().count();
  // The nearest edge is to the right of the middle, so the front is the wider face.
  const auto left = column_of(picture, side * 3 / 10), right = column_of(picture, side * 8 / 10);
  const int top = left[static_cast<std::size_t>(side * 3 / 10)];
  const int front = left[static_cast<std::size_t>(side * 6 / 10)];
  const int side_face = right[static_cast<std::size_t>(side * 6 / 10)];
  CHECK(top > front + 20);
  CHECK(front > side_face + 20);
  CHECK(side_face > 0);
  // A flat face has one grey value.
  CHECK(std::abs(front - left[static_cast<std::size_t>(side * 6 / 10 + 10)]) <= 3);
}

TEST_CASE("A higher part hides lower parts behind it") {
  const auto roof = [](int, int, double at) { return at > 0.9; };
  const auto roof_and_more = [](int column, int row, double at) {
    return at > 0.9 || (at > 0.8 && column < 30 && row < 10);
  };
  CHECK(drawn(kBlock, roof) == drawn(kBlock, roof_and_more));
}

TEST_CASE("A wall as wide as a pixel of the picture has no holes") {
  const PartPicture::Box box{Pixels{140}, Pixels{140}, 90};
  REQUIRE(PartPicture::scale_of(box, kPictureSide) <= 1);
  for (const bool along_x : {true, false}) {
    const Mask picture =
        drawn(box, [&](int column, int row, double) { return (along_x ? row : column) == 70; });
    const int side = picture.width().count();
    // All pixels of a column between the first and the last lit one are lit.
    for (int column = 0; column < side; ++column) {
      const auto greys = column_of(picture, column);
      const auto lit = std::ranges::count_if(greys, [](int grey) { return grey > 0; });
      if (lit == 0) continue;
      const auto first = std::ranges::find_if(greys, [](int grey) { return grey > 0; });
      CHECK(std::all_of(first, first + lit, [](int grey) { return grey > 0; }));
    }
  }
}

TEST_CASE("The picture undoes the mirrors of the masks") {
  const auto stair = [](int column, int row, double at) { return column + row / 3 < 70 * (1 - at); };
  const Mask upright = drawn(kBlock, stair);
  for (const std::pair<bool, bool>& mirrors : {std::pair{true, false}, {false, true}, {true, true}}) {
    PartPicture::Box box = kBlock;
    box.mirror_x = mirrors.first;
    box.mirror_y = mirrors.second;
    CHECK(upright == drawn(box, [&](int column, int row, double at) {
            return stair(box.mirror_x ? 59 - column : column, box.mirror_y ? 59 - row : row, at);
          }));
  }
  CHECK_FALSE(upright ==
              drawn(kBlock, [&](int column, int row, double at) { return stair(59 - column, row, at); }));
}

TEST_CASE("A place is marked where the part at that place is drawn") {
  // Two cubes in opposite corners of the box. The outline of a single cube is as wide on both sides of its
  // middle.
  constexpr double kSize = 12;
  for (const bool mirror_x : {false, true}) {
    for (const bool mirror_y : {false, true}) {
      const PartPicture::Box box{Pixels{80}, Pixels{60}, 70, mirror_x, mirror_y};
      for (const bool left_first : {false, true}) {
        const auto is_in = [](double at, double from) { return from <= at && at < from + kSize; };
        const auto is_first = [&](double x, double y, double z) {
          return is_in(x, left_first ? 0 : 80 - kSize) && is_in(y, 0) && is_in(z, 0);
        };
        const auto is_second = [&](double x, double y, double z) {
          return is_in(x, left_first ? 80 - kSize : 0) && is_in(y, 60 - kSize) && is_in(z, 70 - kSize);
        };
        const PartPicture picture = picture_of(box, [&](int column, int row, double height) {
          return is_first(column, row, 70 * height) || is_second(column, row, 70 * height);
        });
        const double half = kSize / 2, near_x = half / 80, near_y = half / 60, near_z = half / 70;
        const PartPicture::Drawing drawing = picture.draw(
            std::vector<PartPicture::Place>{{left_first ? near_x : 1 - near_x, near_y, near_z},
                                            {left_first ? 1 - near_x : near_x, 1 - near_y, 1 - near_z}});
        REQUIRE(drawing.marks.size() == 2);
        for (const PixelPoint& mark : drawing.marks) {
          const double wide = kSize * (kSinTurn + kCosTurn) / 2 * PartPicture::scale_of(box, kPictureSide);
          for (const double within : {-0.8, 0.0, 0.8})
            CHECK(is_lit(drawing.picture, mark.x + within * wide, mark.y));
          for (const double beyond : {-1.2, 1.2})
            CHECK_FALSE(is_lit(drawing.picture, mark.x + beyond * wide, mark.y));
        }
      }
    }
  }
}

TEST_CASE("Parts that are not present are drawn faint") {
  const auto printed_to = [](double share) {
    PartPicture picture(kBlock, kPictureSide);
    while (true) {
      if (picture.next_height() > share) break;
      picture.add(mask_of(kBlock, [](int, int) { return true; }));
    }
    picture.add_faintly_from_here();
    while (picture.next_height() < 1)
      picture.add(mask_of(kBlock, [](int, int) { return true; }));
    return picture.draw().picture;
  };
  const Mask whole = drawn(kBlock, everywhere), half = printed_to(0.5), none = printed_to(0);
  CHECK(half.lit_pixels() == whole.lit_pixels());
  CHECK(none.lit_pixels() == whole.lit_pixels());
  CHECK(brightest(none) < 100);
  CHECK(brightest(half) > 150);
  const auto column = static_cast<int>(half.width().count() * 3 / 10);
  const auto bottom = static_cast<std::size_t>(half.width().count() * 7 / 10);
  CHECK(column_of(half, column)[bottom] == column_of(whole, column)[bottom]);  // the front, below
  const auto upper = static_cast<std::size_t>(half.width().count() * 45 / 100);
  CHECK(column_of(half, column)[upper] >
        column_of(none, column)[upper]);  // the present part behind the faint one
}

TEST_CASE("The picture is black without masks, and with dark masks") {
  CHECK(PartPicture(kBlock, kPictureSide).draw().picture == Mask(kPictureSide, kPictureSide));
  CHECK(drawn(kBlock, [](int, int, double) { return false; }) == Mask(kPictureSide, kPictureSide));
}
