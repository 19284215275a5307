#include "core/image/mask_png.hpp"

#include <zlib.h>

#include "tests/catch.hpp"
#include "tests/hw/masks.hpp"
#include "tests/random_shapes.hpp"

// Tested here and not beside core's tests, which link no library that could read the pictures.

namespace {

using Bytes = std::span<const std::uint8_t>;

std::size_t number_at(Bytes bytes, std::size_t at) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8 | bytes[at + i];
  return number;
}

void expect(bool is_so, const char* what) {
  if (!is_so) throw std::runtime_error(what);
}

// Returns the chunk's content after checking its name and, with zlib, its checksum; moves `at` past the
// chunk.
Bytes chunk_at(Bytes png, std::size_t& at, const std::string& name) {
  const std::size_t length = number_at(png, at);
  expect(std::string(png.begin() + static_cast<std::ptrdiff_t>(at) + 4,
                     png.begin() + static_cast<std::ptrdiff_t>(at) + 8) == name,
         "another chunk");
  expect(crc32(0, png.data() + at + 4, static_cast<uInt>(length + 4)) == number_at(png, at + 8 + length),
         "a wrong CRC");
  at += length + 12;
  return png.subspan(at - length - 4, length);
}

// Decodes the picture strictly: three chunks and nothing else, with all checksums right.
Mask strictly_decoded(Bytes png) {
  expect(std::memcmp(png.data(), "\x89PNG\r\n\x1a\n", 8) == 0, "no PNG signature");
  std::size_t at = 8;
  const Bytes header = chunk_at(png, at, "IHDR"), data = chunk_at(png, at, "IDAT");
  expect(chunk_at(png, at, "IEND").empty() && at == png.size(), "something after the picture");
  expect(std::memcmp(header.data() + 8, "\x08\0\0\0\0", 5) == 0, "not plain 8-bit grey");
  const std::size_t width = number_at(header, 0), height = number_at(header, 4);
  std::vector<std::uint8_t> raw((width + 1) * height + 1);
  uLongf size = raw.size();
  uLong used = data.size();
  expect(uncompress2(raw.data(), &size, data.data(), &used) == Z_OK && size == raw.size() - 1 &&
             used == data.size(),
         "a wrong zlib stream");
  Mask mask(Pixels{static_cast<std::int32_t>(width)}, Pixels{static_cast<std::int32_t>(height)});
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* coded = raw.data() + y * (width + 1);
    expect(coded[0] == 0 || (coded[0] == 2 && y > 0), "an unexpected filter");
    for (std::size_t x = 0; x < width; ++x) {
      const int above = coded[0] == 2 ? mask.row(static_cast<std::int32_t>(y) - 1)[x] : 0;
      mask.row(static_cast<std::int32_t>(y))[x] = static_cast<std::uint8_t>(coded[1 + x] + above);
    }
  }
  return mask;
}

// Draws a mask of runs of all lengths, with the greys that masks have; many rows repeat the row above.
Mask draw_mask_of_runs() {
  Mask mask = testing::mask_of(testing::draw(1, 1200), testing::draw(1, 8), 0);
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    const auto row = mask.row(y);
    const auto kind = testing::draw(0, 3);
    if (kind == 0 && y > 0) std::copy_n(row.data() - row.size(), row.size(), row.data());
    if (kind < 2) continue;
    for (std::size_t x = 0; x < row.size();) {
      const auto grey = *rc::gen::element<std::uint8_t>(0, 255, 255, 1, 2, 128, 254);
      const auto longest = *rc::gen::element<std::int64_t>(1, 4, 70, 600);
      const auto count = std::min(row.size() - x, static_cast<std::size_t>(testing::draw(1, longest)));
      std::memset(row.data() + x, grey, count);
      x += count;
    }
  }
  return mask;
}

bool comes_back(const Mask& mask) {
  MaskPngEncoder encoder;
  return strictly_decoded(encoder.encode(mask)) == mask;
}

}  // namespace

TEST_CASE("A mask of any runs comes back from its PNG, every checksum right") {
  MaskPngEncoder encoder;
  CHECK(rc::check([&encoder] {
    const Mask mask = draw_mask_of_runs();
    RC_ASSERT(strictly_decoded(encoder.encode(mask)) == mask);
  }));
}

TEST_CASE("A run of every length comes back from its PNG") {
  for (std::int64_t width = 1; width <= 1100; ++width)
    REQUIRE(comes_back(testing::mask_of(width, 1, 77)));
}

TEST_CASE("Masks all dark, all lit and of noise come back from their PNG at every small width") {
  for (std::int32_t width = 1; width <= 70; ++width) {
    for (const int grey : {0, 255})
      REQUIRE(comes_back(testing::mask_of(width, 3, grey)));
    REQUIRE(comes_back(testing::noise(width, 3)));
  }
}

TEST_CASE("The widest and the highest masks come back from their PNG") {
  for (const int grey : {0, 1, 255}) {
    CHECK(comes_back(testing::mask_of(16384, 5, grey)));
    CHECK(comes_back(testing::mask_of(5, 16384, grey)));
  }
  CHECK(comes_back(testing::noise(16384, 5)));
}

TEST_CASE("A mask as large as masks can be, all lit or all dark, comes back from its PNG", "[long]") {
  for (const int grey : {0, 255})
    CHECK(comes_back(testing::mask_of(16384, 16384, grey)));
}

TEST_CASE("Noise grows by at most an eighth as PNG") {
  MaskPngEncoder encoder;
  const auto size = [&encoder](const Mask& mask) { return encoder.encode(mask).size(); };
  for (const std::int32_t side : {1, 7, 100, 500})
    CHECK(size(testing::noise(side, side)) <= static_cast<std::size_t>(side * (side + 1) * 9 / 8 + 200));
  // Pairs of the costliest grey take two literals each.
  Mask pairs = testing::mask_of(400, 400, 1);
  for (std::int32_t y = 0; y < 400; ++y) {
    for (std::size_t x = 0; x < 400; ++x)
      pairs.row(y)[x] = static_cast<std::uint8_t>(1 + (x / 2 + static_cast<std::size_t>(y)) % 2);
  }
  CHECK(size(pairs) <= 400 * 401 * 9 / 8 + 200);
}

TEST_CASE("A dark mask of full size is packed six hundredfold, and so are equal rows") {
  MaskPngEncoder encoder;
  CHECK(encoder.encode(testing::mask_of(1920, 1080, 0)).size() < 1920 * 1080 / 600);
  Mask stripes = testing::mask_of(1920, 1080, 0);
  for (std::int32_t y = 0; y < 1080; ++y) {
    for (std::size_t x = 0; x < 1920; x += 8)
      stripes.row(y)[x] = 255;
  }
  // The first row is 240 stripes of 3 codes; every other row is one match of it, with its filter's byte.
  CHECK(encoder.encode(stripes).size() < 1920 * 1080 / 200);
}

TEST_CASE("An encoder gives the same bytes whatever it encoded before") {
  MaskPngEncoder used, fresh;
  (void)used.encode(testing::noise(90, 80));
  const Mask mask = testing::mask_of(60, 50, 200);
  const Bytes again = used.encode(mask), first = fresh.encode(mask);
  CHECK(std::vector(again.begin(), again.end()) == std::vector(first.begin(), first.end()));
}

TEST_CASE("A warm encoder keeps its memory") {
  MaskPngEncoder encoder;
  const std::uint8_t* warm = encoder.encode(testing::noise(200, 200)).data();
  CHECK(encoder.encode(testing::mask_of(200, 200, 255)).data() == warm);
  CHECK(encoder.encode(testing::noise(200, 200)).data() == warm);
}

TEST_CASE("A picture without pixels is refused") {
  MaskPngEncoder encoder;
  CHECK_THROWS_AS(encoder.encode(Mask()), std::invalid_argument);
}
