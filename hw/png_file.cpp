#include "hw/png_file.hpp"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "hw/owned.hpp"

namespace contourd {
namespace {

// Upper limit for a file's size; a display's picture has a few megabytes at most.
constexpr std::size_t kLargestFile = std::size_t{128} << 20U;

constexpr std::int64_t kMostPhotoPixels = 100'000'000;  // decoded in a few seconds

struct DisplaySize {
  Pixels width, height;
};

using File = Owned<std::FILE, std::fclose>;

std::string text_of(const DisplaySize& size) {
  return std::to_string(size.width.count()) + "x" + std::to_string(size.height.count());
}

// Returns a picture's size. Throws std::runtime_error if a mask cannot have that size.
DisplaySize size_of(png_uint_32 width, png_uint_32 height) {
  constexpr png_uint_32 kLargestSide = 16384;
  if (width > kLargestSide || height > kLargestSide) {
    throw std::runtime_error("the picture is " + std::to_string(width) + "x" + std::to_string(height) +
                             " pixels; the limit is 16384 a side");
  }
  return {Pixels{static_cast<std::int32_t>(width)}, Pixels{static_cast<std::int32_t>(height)}};
}

void require_signature(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kSignature = 8;
  if (bytes.size() < kSignature || png_sig_cmp(bytes.data(), 0, kSignature) != 0)
    throw std::runtime_error("the file is not a PNG file");
}

std::vector<std::uint8_t> read_file(const std::filesystem::path& path) {
  const auto cannot_read = [&path](int error) {
    return std::system_error(error, std::generic_category(), "cannot read " + path.string());
  };
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw std::runtime_error("it is not a regular file");  // reading from a pipe would block
  }
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) throw cannot_read(errno);
  std::vector<std::uint8_t> bytes;
  std::uint8_t block[65536];
  while (const std::size_t count = std::fread(block, 1, sizeof block, file.get())) {
    bytes.insert(bytes.end(), block, block + count);
    if (bytes.size() > kLargestFile) {
      throw std::runtime_error("the file has more than " + std::to_string(kLargestFile >> 20U) +
                               " MiB, the limit for a picture");
    }
  }
  if (std::ferror(file.get()) != 0) throw cannot_read(errno);
  return bytes;
}

// libpng's read structs, released together.
class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> bytes)
      : left_(bytes), png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, refuse, ignore)) {
    if (png_ == nullptr) throw std::bad_alloc();
    info_ = png_create_info_struct(png_);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  // Decodes the picture, which must have the size `wanted` if one is given.
  Mask decode(std::optional<DisplaySize> wanted = std::nullopt) {
    begin();
    if (png_get_color_type(png_, info_) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png_, info_) != 8 ||
        png_get_valid(png_, info_, PNG_INFO_tRNS) != 0) {
      throw std::runtime_error("the picture is not 8-bit grey without transparency");
    }
    const DisplaySize size = size_of(png_get_image_width(png_, info_), png_get_image_height(png_, info_));
    if (wanted && (size.width != wanted->width || size.height != wanted->height)) {
      throw std::runtime_error("the picture is " + text_of(size) + " pixels, the display " +
                               text_of(*wanted));
    }
    Mask mask(size.width, size.height);
    for (int passes = png_set_interlace_handling(png_); passes > 0; --passes) {
      for (std::int32_t y = 0; y < mask.height().count(); ++y)
        png_read_row(png_, mask.row(y).data(), nullptr);
    }
    png_read_end(png_, nullptr);
    return mask;
  }

  void decode_rows(const std::function<void(const PngRow&)>& take_row) {
    begin();
    const DisplaySize size = size_of(png_get_image_width(png_, info_), png_get_image_height(png_, info_));
    if (std::int64_t{size.width.count()} * size.height.count() > kMostPhotoPixels)
      throw std::runtime_error("the picture is " + text_of(size) +
                               " pixels; the limit for a photo is 100 million pixels");
    if (png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE)
      throw std::runtime_error("the picture is interlaced: save it without interlacing");
    png_set_expand_16(png_);  // also palettes, transparency and less than 8 bits
    png_set_strip_alpha(png_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    png_read_update_info(png_, info_);
    const std::size_t channels = png_get_channels(png_, info_);
    std::vector<std::uint16_t> row(static_cast<std::size_t>(size.width.count()) * channels);
    if (png_get_rowbytes(png_, info_) != row.size() * sizeof row[0])
      throw std::runtime_error("the picture has samples of an unusual size");
    for (std::int32_t y = 0; y < size.height.count(); ++y) {
      png_read_row(png_, reinterpret_cast<png_bytep>(row.data()), nullptr);
      take_row({y, row, channels});
    }
    png_read_end(png_, nullptr);
  }

 private:
  // Reads what is before the pixels.
  void begin() {
    require_signature(left_);
    // Texts, profiles and the like do not affect the pixels, and a few kilobytes of them may unpack to 8 MB.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_set_read_fn(png_, this, take);
    png_read_info(png_, info_);
  }
  [[noreturn]] static void refuse(png_structp, png_const_charp why) {
    throw std::runtime_error(std::string("the picture cannot be read: ") + why);
  }
  static void ignore(png_structp, png_const_charp) {}  // a warning: the pixels can be read
  static void take(png_structp png, png_bytep data, std::size_t size) {
    std::span<const std::uint8_t>& left = static_cast<PngReader*>(png_get_io_ptr(png))->left_;
    if (size > left.size()) png_error(png, "the file ends too early");
    std::copy_n(left.begin(), size, data);
    left = left.subspan(size);
  }

  std::span<const std::uint8_t> left_;
  png_structp png_;
  png_infop info_ = nullptr;
};

}  // namespace

Mask read_png(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  return PngReader(bytes).decode();
}

// Uses libpng's simplified interface, which reads all kinds of pictures.
Mask read_png_as_grey(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  require_signature(bytes);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const Owned<png_image, png_image_free> freed_at_the_end(&image);
  const auto require = [&image](int done) {
    if (done == 0 || PNG_IMAGE_FAILED(image))
      throw std::runtime_error(std::string("the picture cannot be read: ") + image.message);
  };
  require(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()));
  const DisplaySize size = size_of(image.width, image.height);
  Mask mask(size.width, size.height);
  image.format = PNG_FORMAT_GRAY;
  constexpr png_color kBlack{0, 0, 0};
  require(png_image_finish_read(&image, &kBlack, mask.row(0).data(), 0, nullptr));
  return mask;
}

void read_png_rows(const std::filesystem::path& path, const std::function<void(const PngRow&)>& take) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  PngReader(bytes).decode_rows(take);
}

Mask decode_png(std::span<const std::uint8_t> bytes, Pixels width, Pixels height) {
  return PngReader(bytes).decode(DisplaySize{width, height});
}

std::vector<std::uint8_t> encode_png(const Mask& mask, const Palette* palette) {
  MaskPngEncoder encoder;
  const std::span<const std::uint8_t> bytes = encoder.encode(mask, palette);
  return {bytes.begin(), bytes.end()};
}

void write_png(const std::filesystem::path& path, const Mask& mask) {
  MaskPngEncoder encoder;
  write_png(path, mask, encoder);
}

void write_png(const std::filesystem::path& path, const Mask& mask, MaskPngEncoder& encoder) {
  const std::span<const std::uint8_t> bytes = encoder.encode(mask);
  const auto cannot_write = [&path] {
    return std::system_error(errno, std::generic_category(), "cannot write " + path.string());
  };
  File file(std::fopen(path.c_str(), "wb"));
  if (!file) throw cannot_write();
  std::setvbuf(file.get(), nullptr, _IONBF, 0);  // unbuffered, because all bytes go out in one system call
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (std::fclose(file.release()) == 0 && written) return;
  const std::system_error error = cannot_write();
  std::error_code ignored;
  // A half-written file is removed; a device or a pipe is not ours to remove.
  if (std::filesystem::is_regular_file(std::filesystem::symlink_status(path, ignored))) {
    std::filesystem::remove(path, ignored);
  }
  throw error;
}

}  // namespace contourd
