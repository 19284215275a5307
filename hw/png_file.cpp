#include "hw/png_file.hpp"

#include <png.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace contourd {
namespace {

// Masks are long runs of few values: the fastest level already packs them 200:1.
constexpr int kCompressionLevel = 1;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// libpng's write structs, released together.
class PngWriter {
 public:
  PngWriter() : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, refuse, nullptr)) {
    if (png_ == nullptr) throw std::bad_alloc();
    info_ = png_create_info_struct(png_);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }

  std::vector<std::uint8_t> encode(const Mask& mask) {
    std::vector<std::uint8_t> bytes;
    png_set_write_fn(png_, &bytes, append, nullptr);
    png_set_compression_level(png_, kCompressionLevel);
    png_set_filter(png_, 0, PNG_FILTER_NONE);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(mask.width().count()),
                 static_cast<png_uint_32>(mask.height().count()), 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    for (std::int32_t y = 0; y < mask.height().count(); ++y)
      png_write_row(png_, mask.row(y).data());
    png_write_end(png_, info_);
    return bytes;
  }

 private:
  [[noreturn]] static void refuse(png_structp, png_const_charp why) {
    throw std::runtime_error(std::string("libpng: ") + why);
  }
  static void append(png_structp png, png_bytep data, std::size_t size) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
    bytes.insert(bytes.end(), data, data + size);
  }

  png_structp png_;
  png_infop info_ = nullptr;
};

}  // namespace

std::vector<std::uint8_t> encode_png(const Mask& mask) {
  return PngWriter().encode(mask);
}

void write_png(const std::filesystem::path& path, const Mask& mask) {
  const std::vector<std::uint8_t> bytes = encode_png(mask);
  const auto cannot_write = [&path] {
    return std::system_error(errno, std::generic_category(), "cannot write " + path.string());
  };
  std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "wb"));
  if (!file) throw cannot_write();
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (std::fclose(file.release()) == 0 && written) return;
  const std::system_error error = cannot_write();
  std::error_code ignored;
  // What was half written goes; a device or a pipe is not ours to remove.
  if (std::filesystem::is_regular_file(std::filesystem::symlink_status(path, ignored))) {
    std::filesystem::remove(path, ignored);
  }
  throw error;
}

}  // namespace contourd
