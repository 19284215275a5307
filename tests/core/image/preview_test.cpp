#include "core/image/preview.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Millimeters kAll{1e9};

struct Extent {
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;  // first and last lit columns and rows
};

Extent lit_extent(const Mask& picture) {
  Extent extent;
  for (int row = 0; row < picture.height().count(); ++row) {
    for (int column = 0; column < picture.width().count(); ++column) {
      if (picture.row(row)[static_cast<std::size_t>(column)] == 0) continue;
      extent = {std::min(extent.left, column), std::max(extent.right, column), std::min(extent.top, row),
                std::max(extent.bottom, row)};
    }
  }
  return extent;
}

std::set<int> greys(const Mask& picture) {
  return {picture.pixels().begin(), picture.pixels().end()};
}

int grey_at(const Mask& picture, int column, int row) {
  return picture.row(row)[static_cast<std::size_t>(column)];
}

}  // namespace

TEST_CASE("A preview has the requested size") {
  const Mask picture = render_preview(models::box({0, 0, 0}, {1, 1, 1}), kAll, Pixels{90}, Pixels{70});
  CHECK(picture.width() == Pixels{90});
  CHECK(picture.height() == Pixels{70});
}

TEST_CASE("A preview of nothing is black") {
  CHECK(render_preview(models::Facets{}, kAll, Pixels{20}, Pixels{20}).lit_pixels() == 0);
  const Vertex point{5, 5, 5};
  CHECK(render_preview(models::Facets{{{point, point, point}}}, kAll, Pixels{20}, Pixels{20}).lit_pixels() ==
        0);
}

TEST_CASE("A box shows its top, front and right side, each in one grey") {
  const Mask picture = render_preview(models::box({0, 0, 0}, {10, 10, 10}), kAll, Pixels{200}, Pixels{200});
  CHECK(greys(picture).size() == 4);  // the background is the fourth
  const Extent extent = lit_extent(picture);
  const int middle = (extent.left + extent.right) / 2;
  const int top = grey_at(picture, middle, extent.top + 10);
  const int front = grey_at(picture, extent.left + 20, (extent.top + extent.bottom) / 2);
  const int right = grey_at(picture, extent.right - 10, (extent.top + extent.bottom) / 2);
  // Lit from the upper left.
  CHECK(top > front);
  CHECK(front > right);
  CHECK(right > 0);
}

TEST_CASE("The whole model fills the picture except for a margin") {
  // A margin of 6 % of 200 pixels, and a pixel for the rounding to centres.
  constexpr int kMargin = 12;
  const auto touches = [](int edge) { return std::abs(edge - kMargin) <= 1; };
  for (const auto& facets : {models::box({0, 0, 0}, {1, 1, 1}), models::box({-500, -500, 0}, {500, 500, 100}),
                             models::box({1e5F, 1e5F, 1e5F}, {1e5F + 1, 1e5F + 1, 1e5F + 90})}) {
    const Extent extent = lit_extent(render_preview(facets, kAll, Pixels{200}, Pixels{200}));
    const bool in_width = touches(extent.left) && touches(199 - extent.right);
    const bool in_height = touches(extent.top) && touches(199 - extent.bottom);
    CHECK((in_width || in_height));
    CHECK(extent.left >= kMargin - 1);
    CHECK(extent.right <= 200 - kMargin);
    CHECK(extent.top >= kMargin - 1);
    CHECK(extent.bottom <= 200 - kMargin);
  }
}

TEST_CASE("The unprinted part is missing and the rest stays where it is") {
  const models::Facets box = models::box({0, 0, 0}, {10, 10, 10});
  const Mask whole = render_preview(box, kAll, Pixels{200}, Pixels{200});
  const Mask half = render_preview(box, Millimeters{5}, Pixels{200}, Pixels{200});
  CHECK(half.lit_pixels() < whole.lit_pixels());
  CHECK(lit_extent(half).bottom == lit_extent(whole).bottom);
  CHECK(lit_extent(half).left == lit_extent(whole).left);
  CHECK(lit_extent(half).top > lit_extent(whole).top);
  for (std::size_t i = 0; i < half.pixels().size(); ++i) {
    if (half.pixels()[i] != 0 && whole.pixels()[i] == 0)
      FAIL("pixel " << i << " is lit in the half print only");
  }
  CHECK(render_preview(box, Millimeters{-0.001}, Pixels{200}, Pixels{200}).lit_pixels() == 0);
}

TEST_CASE("A print that ends at a flat face shows all of that face") {
  for (const float top : {10.0F, 7.3F, 0.1F}) {
    CAPTURE(top);
    const models::Facets box = models::box({0, 0, 0}, {10, 10, top});
    const Mask printed = render_preview(box, Millimeters{static_cast<double>(top)}, Pixels{200}, Pixels{200});
    const Mask whole = render_preview(box, kAll, Pixels{200}, Pixels{200});
    std::size_t missing = 0;
    for (std::size_t i = 0; i < whole.pixels().size(); ++i)
      missing += whole.pixels()[i] != printed.pixels()[i];
    CHECK(missing == 0);
  }
}

TEST_CASE("The nearer facet hides the farther whatever their order") {
  // Two upright squares face the eye's side; the one at smaller y stands in front.
  const auto square = [](float y) {
    return models::Facets{{{Vertex{0, y, 0}, Vertex{10, y, 0}, Vertex{10, y, 10}}},
                          {{Vertex{0, y, 0}, Vertex{10, y, 10}, Vertex{0, y, 10}}}};
  };
  const models::Facets near = square(0);
  const models::Facets floor{{{Vertex{-5, 20, 0}, Vertex{15, 20, 0}, Vertex{15, 40, 12}}}};
  models::Facets one = near, other = floor;
  one.insert(one.end(), floor.begin(), floor.end());
  other.insert(other.end(), near.begin(), near.end());
  const Mask picture = render_preview(one, kAll, Pixels{120}, Pixels{120});
  CHECK(picture == render_preview(other, kAll, Pixels{120}, Pixels{120}));
  CHECK(greys(picture).size() == 3);
}

TEST_CASE("A turned facet is as bright as a sound one") {
  models::Facets facets = models::sphere(10, 10);
  const Mask sound = render_preview(facets, kAll, Pixels{100}, Pixels{100});
  models::invert(facets);
  CHECK(render_preview(facets, kAll, Pixels{100}, Pixels{100}) == sound);
}

TEST_CASE("A preview of moved parts equals one of the model they form together") {
  const models::Facets cube = models::box({10, 10, 10}, {12, 12, 12}),
                       post = models::box({-7, 0, -3}, {-6, 1, 1});
  const PreviewPart parts[]{{cube, {-11, -11, -10}}, {post, {10.5, 1.5, 3}}, {cube, {-7, -11, -10}}};
  models::Facets together = models::box({-1, -1, 0}, {1, 1, 2});
  for (const auto& more : {models::box({3.5F, 1.5F, 0}, {4.5F, 2.5F, 4}), models::box({3, -1, 0}, {5, 1, 2})})
    together.insert(together.end(), more.begin(), more.end());
  for (const double top : {0.0, 1.5, 4.0}) {
    const Mask expected = render_preview(together, Millimeters{top}, Pixels{120}, Pixels{90});
    CHECK(render_preview(parts, Millimeters{top}, Pixels{120}, Pixels{90}).picture == expected);
    CHECK((expected.lit_pixels() > 0) == true);
  }
}

TEST_CASE("A place of a moved part is found where it is drawn, and pixels of supports have odd values") {
  const models::Facets box = models::box({0, 0, 0}, {3, 2, 1});
  const PreviewPart parts[]{{box, {10, 20, 5}}, {box, {10, 20, 2}, true}};
  for (const int height : {120, 40}) {
    const Preview preview = render_preview(parts, kAll, Pixels{150}, Pixels{height});
    // The outline's leftmost, lowest and rightmost corners: of both boxes, of the support, of both.
    const Extent extent = lit_extent(preview.picture);
    CHECK(std::abs(preview.at({10, 20, 2}).x - extent.left) <= 1);
    CHECK(std::abs(preview.at({13, 20, 2}).y - (extent.bottom + 1)) <= 1);
    CHECK(std::abs(preview.at({13, 22, 5}).x - (extent.right + 1)) <= 1);
    CHECK(std::abs(preview.at({10, 22, 6}).y - extent.top) <= 1);
    const double middle = preview.at({10, 20, 4}).y;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < 150; ++x)
        if (const int grey = grey_at(preview.picture, x, y); grey != 0 && std::abs(x - extent.left) < 2)
          CHECK((grey % 2 == 1) == (y > middle));
  }
}

TEST_CASE("A preview of facets that cover it thousands of times is drawn in larger pixels") {
  // Upright squares behind each other, each of which nearly fills the picture.
  models::Facets squares;
  for (int i = 0; i < 5'000; ++i) {
    const float y = static_cast<float>(i) / 5'000;
    squares.push_back({{Vertex{0, y, 0}, Vertex{100, y, 0}, Vertex{100, y, 100}}});
    squares.push_back({{Vertex{0, y, 0}, Vertex{100, y, 100}, Vertex{0, y, 100}}});
  }
  constexpr int kWidth = 719, kHeight = 701;
  const auto drawn = [](std::span<const Facet> facets) {
    return render_preview(facets, kAll, Pixels{kWidth}, Pixels{kHeight});
  };
  const auto is_in_blocks_of = [](const Mask& picture, int side) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (grey_at(picture, x, y) != grey_at(picture, x / side * side, y / side * side)) return false;
    return true;
  };
  const Mask fine = drawn(std::span(squares).first(2)), coarse = drawn(squares);
  CHECK_FALSE(is_in_blocks_of(fine, 2));
  CHECK(is_in_blocks_of(coarse, 2));
  CHECK(coarse.width() == Pixels{kWidth});
  CHECK(coarse.height() == Pixels{kHeight});
  // The picture is the same except that the squares behind move the edges by some pixels.
  CHECK(std::abs(coarse.lit_area() - fine.lit_area()) < 0.05 * fine.lit_area());
}
