#include "hw/png_file.hpp"

#include <png.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/catch.hpp"
#include "tests/hw/masks.hpp"
#include "tests/hw/refusal.hpp"
#include "tests/random_shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace {

// Decodes the bytes with libpng, as 8-bit grey.
Mask decoded(const std::vector<std::uint8_t>& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0)
    throw std::runtime_error(image.message);
  // Grey without alpha or colour in the file itself, 8 bits a value.
  if (image.format != PNG_FORMAT_GRAY) throw std::runtime_error("not 8-bit grey");
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0)
    throw std::runtime_error(image.message);
  Mask mask(Pixels{static_cast<std::int32_t>(image.width)}, Pixels{static_cast<std::int32_t>(image.height)});
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    std::memcpy(mask.row(y).data(), pixels.data() + static_cast<std::size_t>(y) * image.width, image.width);
  }
  return mask;
}

std::vector<std::uint8_t> content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Mask draw_mask(std::int64_t largest_side) {
  const auto width = testing::draw(1, largest_side), height = testing::draw(1, largest_side);
  return testing::noise(width, height, static_cast<std::uint64_t>(testing::draw(0, std::int64_t{1} << 60)));
}

std::error_code code_of_writing(const std::filesystem::path& path, const Mask& mask) {
  try {
    write_png(path, mask);
  } catch (const std::system_error& error) {
    CHECK(std::string(error.what()).find(path.string()) != std::string::npos);
    return error.code();
  }
  return {};
}

// A resource limit of this process for as long as the object exists. Meanwhile exceeding the file size is an
// error rather than a signal.
class LoweredLimit {
 public:
  LoweredLimit(int resource, rlim_t limit)
      : resource_(resource), old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    REQUIRE(getrlimit(resource_, &old_limit_) == 0);
    const rlimit lowered{limit, old_limit_.rlim_max};
    REQUIRE(setrlimit(resource_, &lowered) == 0);
  }
  LoweredLimit(const LoweredLimit&) = delete;
  LoweredLimit& operator=(const LoweredLimit&) = delete;
  ~LoweredLimit() {
    setrlimit(resource_, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  int resource_;
  rlimit old_limit_{};
  void (*old_handler_)(int);
};

}  // namespace

TEST_CASE("A PNG read back with libpng is the mask bit for bit") {
  CHECK(rc::check([] {
    const Mask mask = draw_mask(70);
    RC_ASSERT(decoded(encode_png(mask)) == mask);
  }));
}

TEST_CASE("A written file is the PNG in memory and replaces what was there") {
  CHECK(rc::check([] {
    const testing::TemporaryFolder folder;
    const auto path = folder.write("mask.png", std::string(20'000, 'x'));
    const Mask mask = draw_mask(30);
    write_png(path, mask);
    RC_ASSERT(content_of(path) == encode_png(mask));
  }));
}

TEST_CASE("The same mask gives the same bytes") {
  const Mask mask(Pixels{300}, Pixels{200});
  CHECK(encode_png(mask) == encode_png(mask));
}

TEST_CASE("A full-size mask of long runs is packed a hundredfold") {
  Mask mask(Pixels{1920}, Pixels{1080});
  for (std::int32_t y = 200; y < 600; ++y)
    std::memset(mask.row(y).data() + 300, 255, 400);
  const std::vector<std::uint8_t> bytes = encode_png(mask);
  CHECK(bytes.size() < 1920 * 1080 / 100);
  CHECK(decoded(bytes) == mask);
}

TEST_CASE("A mask without pixels is refused") {
  CHECK_THROWS_AS(encode_png(Mask()), std::invalid_argument);
}

TEST_CASE(
    "What cannot be written is a system error that names it, and a device or folder in its place stays") {
  const testing::TemporaryFolder folder;
  const Mask mask(Pixels{4}, Pixels{4});
  CHECK(code_of_writing(folder.path() / "missing" / "mask.png", mask) ==
        std::errc::no_such_file_or_directory);
  const auto link = folder.path() / "link.png", subfolder = folder.path() / "folder.png";
  std::filesystem::create_symlink("/dev/full", link);
  CHECK(code_of_writing(link, mask) == std::errc::no_space_on_device);
  CHECK(std::filesystem::is_symlink(link));
  CHECK(std::filesystem::exists("/dev/full"));
  std::filesystem::create_directory(subfolder);
  CHECK(code_of_writing(subfolder, mask) == std::errc::is_a_directory);
  CHECK(std::filesystem::is_directory(subfolder));
}

TEST_CASE("A file half written is removed and the error says why") {
  const testing::TemporaryFolder folder;
  Mask noise(Pixels{400}, Pixels{400});  // more than any buffer holds
  std::uint32_t random = 1;
  for (std::int32_t y = 0; y < 400; ++y) {
    for (std::uint8_t& grey : noise.row(y)) {
      random = random * 1664525 + 1013904223;
      grey = static_cast<std::uint8_t>(random >> 24);
    }
  }
  for (const Mask& mask : {Mask(Pixels{4}, Pixels{4}), noise}) {
    const auto path = folder.path() / "mask.png";
    std::error_code code;
    {
      // Files end after 10 bytes, as on a full disk.
      const LoweredLimit limit(RLIMIT_FSIZE, 10);
      code = code_of_writing(path, mask);
    }
    CHECK(code == std::errc::file_too_large);
    CHECK_FALSE(std::filesystem::exists(path));
  }
}

TEST_CASE("A file that could not be opened is left as it was") {
  const testing::TemporaryFolder folder;
  const auto path = folder.write("mask.png", "a picture");
  std::error_code code;
  {
    const LoweredLimit limit(RLIMIT_NOFILE, 0);
    code = code_of_writing(path, Mask(Pixels{4}, Pixels{4}));
  }
  CHECK(code == std::errc::too_many_files_open);
  CHECK(std::filesystem::exists(path));
}

namespace {

// Returns a picture in any format that libpng can write, in the format's own order of bytes.
std::string png_of(png_uint_32 format, png_uint_32 width, png_uint_32 height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  const std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image), 100);
  png_alloc_size_t size = 0;
  REQUIRE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr) != 0);
  std::string bytes(size, '\0');
  REQUIRE(png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) != 0);
  return bytes;
}

std::string refusal_of_png(const std::string& bytes) {
  const testing::TemporaryFolder folder;
  return testing::refusal_of<std::runtime_error>([&] { return read_png(folder.write("lamp.png", bytes)); });
}

Mask ramp() {
  Mask mask(Pixels{37}, Pixels{29});
  for (std::int32_t y = 0; y < 29; ++y) {
    for (std::size_t x = 0; x < 37; ++x)
      mask.row(y)[x] = static_cast<std::uint8_t>(7 * x + 31 * static_cast<std::size_t>(y));
  }
  return mask;
}

void write_interlaced(const std::filesystem::path& path, Mask mask) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  REQUIRE(file != nullptr);
  png_init_io(png, file);
  png_set_IHDR(png, info, 37, 29, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_ADAM7, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  std::vector<png_bytep> rows;
  for (std::int32_t y = 0; y < 29; ++y)
    rows.push_back(mask.row(y).data());
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("A mask written and read is the same") {
  CHECK(rc::check([] {
    const testing::TemporaryFolder folder;
    const Mask mask = draw_mask(70);
    write_png(folder.path() / "mask.png", mask);
    RC_ASSERT(read_png(folder.path() / "mask.png") == mask);
  }));
}

TEST_CASE("An interlaced picture is read like any other") {
  const testing::TemporaryFolder folder;
  write_interlaced(folder.path() / "lamp.png", ramp());
  CHECK(read_png(folder.path() / "lamp.png") == ramp());
}

TEST_CASE("A picture that is not 8-bit grey is refused") {
  for (const png_uint_32 format : {PNG_FORMAT_RGB, PNG_FORMAT_RGBA, PNG_FORMAT_GA, PNG_FORMAT_LINEAR_Y}) {
    CHECK(refusal_of_png(png_of(format, 3, 2)) == "the picture is not 8-bit grey without transparency");
  }
  CHECK(refusal_of_png(png_of(PNG_FORMAT_GRAY, 3, 2)).empty());
}

TEST_CASE("A file that is not a PNG, is damaged or ends early is refused") {
  CHECK(refusal_of_png("") == "the file is not a PNG file");
  CHECK(refusal_of_png("GIF89a, truly") == "the file is not a PNG file");
  const std::string whole = text_of(encode_png(Mask(Pixels{40}, Pixels{30})));
  CHECK(refusal_of_png(whole).empty());
  for (std::size_t size = 8; size < whole.size(); ++size)
    CHECK(refusal_of_png(whole.substr(0, size)).starts_with("the picture cannot be read: "));
  std::string damaged = whole;
  damaged[damaged.size() - 20] = static_cast<char>(damaged[damaged.size() - 20] ^ 1);
  CHECK(refusal_of_png(damaged).starts_with("the picture cannot be read: "));
}

namespace {

// Returns all samples of a photo, by read_png_rows().
std::vector<std::uint16_t> samples_of(const std::filesystem::path& path, std::size_t channels) {
  std::vector<std::uint16_t> samples;
  std::int32_t y = 0;
  read_png_rows(path, [&](const PngRow& row) {
    CHECK(row.y == y++);
    CHECK(row.channels == channels);
    samples.insert(samples.end(), row.samples.begin(), row.samples.end());
  });
  return samples;
}

std::string refusal_of_photo(const std::string& bytes) {
  const testing::TemporaryFolder folder;
  return testing::refusal_of<std::runtime_error>([&] {
    read_png_rows(folder.write("photo.png", bytes), [](const PngRow&) {});
    return 0;
  });
}

}  // namespace

TEST_CASE("A photo of any kind is read as samples of 16 bits, without its gamma and transparency") {
  const testing::TemporaryFolder folder;
  const auto read = [&](png_uint_32 format, std::size_t channels) {
    return samples_of(folder.write("photo.png", png_of(format, 3, 2)), channels);
  };
  // png_of() fills all bytes with 100.
  CHECK(read(PNG_FORMAT_GRAY, 1) == std::vector<std::uint16_t>(6, 100 * 257));
  CHECK(read(PNG_FORMAT_RGB, 3) == std::vector<std::uint16_t>(18, 100 * 257));
  CHECK(read(PNG_FORMAT_GA, 1) == std::vector<std::uint16_t>(6, 100 * 257));
  CHECK(read(PNG_FORMAT_RGBA, 3) == std::vector<std::uint16_t>(18, 100 * 257));
  write_png(folder.path() / "ramp.png", ramp());
  const std::vector<std::uint16_t> samples = samples_of(folder.path() / "ramp.png", 1);
  REQUIRE(samples.size() == 37 * 29);
  for (std::size_t i = 0; i < samples.size(); ++i)
    CHECK(samples[i] == ramp().pixels()[i] * 257);
  // Samples of 16 bits are high byte first in the file: the simplified writer takes them in the machine's
  // order.
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 2;
  image.height = 1;
  image.format = PNG_FORMAT_LINEAR_Y;
  const std::vector<std::uint16_t> wide{1, 0x1234};
  REQUIRE(png_image_write_to_file(&image, (folder.path() / "wide.png").c_str(), 0, wide.data(), 0, nullptr) !=
          0);
  CHECK(samples_of(folder.path() / "wide.png", 1) == wide);
  Palette palette{};
  palette[7] = {10, 20, 30};
  Mask seven(Pixels{1}, Pixels{1});
  seven.row(0)[0] = 7;
  CHECK(samples_of(folder.write("palette.png", text_of(encode_png(seven, &palette))), 3) ==
        std::vector<std::uint16_t>{2570, 5140, 7710});
}

TEST_CASE("A photo that is damaged, interlaced or too large is refused") {
  CHECK(refusal_of_photo("") == "the file is not a PNG file");
  const std::string whole = text_of(encode_png(Mask(Pixels{40}, Pixels{30})));
  CHECK(refusal_of_photo(whole).empty());
  for (std::size_t size = 8; size < whole.size(); ++size)
    CHECK(refusal_of_photo(whole.substr(0, size)).starts_with("the picture cannot be read: "));
  const testing::TemporaryFolder folder;
  write_interlaced(folder.path() / "interlaced.png", ramp());
  CHECK(testing::refusal_of<std::runtime_error>([&] {
          read_png_rows(folder.path() / "interlaced.png", [](const PngRow&) {});
          return 0;
        }) == "the picture is interlaced: save it without interlacing");
  CHECK(refusal_of_photo(text_of(encode_png(Mask(Pixels{10'001}, Pixels{10'000})))) ==
        "the picture is 10001x10000 pixels; the limit for a photo is 100 million pixels");
  CHECK(testing::refusal_of<std::runtime_error>([] {
          read_png_rows("/dev/zero", [](const PngRow&) {});
          return 0;
        }) == "it is not a regular file");
}

TEST_CASE("A picture larger than any mask is refused before its pixels are read") {
  std::string bytes = text_of(encode_png(Mask(Pixels{1}, Pixels{1})));
  // The width of 16385 and the header's checksum for it.
  bytes.replace(16, 4, std::string("\0\0\x40\x01", 4));
  std::uint32_t crc = ~0U;
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<std::uint8_t>(bytes[i]);
    for (int bit = 0; bit < 8; ++bit)
      crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320U : 0);
  }
  crc = ~crc;
  for (int i = 0; i < 4; ++i)
    bytes[static_cast<std::size_t>(29 + i)] = static_cast<char>(crc >> (24 - 8 * i));
  CHECK(refusal_of_png(bytes) == "the picture is 16385x1 pixels; the limit is 16384 a side");
}

TEST_CASE("A picture that is missing, or is not a file, is an error that says so") {
  const testing::TemporaryFolder folder;
  CHECK_THROWS_AS(read_png(folder.path() / "none.png"), std::system_error);
  CHECK(testing::refusal_of<std::runtime_error>([&] { return read_png(folder.path()); }) ==
        "it is not a regular file");
}

TEST_CASE("A file that is far too large for a picture is not read to its end") {
  const testing::TemporaryFolder folder;
  const std::filesystem::path path = folder.write("huge.png", "");
  std::filesystem::resize_file(path, std::uintmax_t{200} << 20U);
  for (const auto read : {read_png, read_png_as_grey})
    CHECK(testing::refusal_of<std::runtime_error>([&] { return read(path); }) ==
          "the file has more than 128 MiB, the limit for a picture");
}
