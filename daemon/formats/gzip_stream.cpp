#include "daemon/formats/gzip_stream.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <system_error>
#include <utility>

#include "core/formats/file_bytes.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/input_limits.hpp"

namespace contourd {
namespace {

constexpr std::size_t kCompressedChunk = 65'536;
constexpr std::uint64_t kLeastBytes = 18;    // header and trailer
constexpr int kGzipWindow = MAX_WBITS + 16;  // the header and trailer of gzip, as zlib.h says
constexpr char kDamaged[] =
    "the gzip archive is cut short or damaged, or other data follows it: copy it again";
// Deflate makes data at most this much smaller, and hardly larger, apart from the names in the header.
constexpr std::uint64_t kDeflateRatio = 1032, kMostHeaderBytes = 4096;

// Returns the size of the inflated data, modulo 2^32, if the file ends with this field.
std::uint32_t claimed_size(std::FILE* file, const std::filesystem::path& path) {
  std::array<std::byte, 4> field{};
  if (std::fseek(file, -static_cast<long>(field.size()), SEEK_END) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  read_exactly(file, field, path);
  std::rewind(file);
  std::uint32_t size = 0;
  std::memcpy(&size, field.data(), sizeof size);  // little-endian, as this machine
  return size;
}

}  // namespace

bool is_gzip(std::span<const std::byte> start) {
  constexpr std::array kMagic{std::byte{0x1F}, std::byte{0x8B}};
  return start.size() >= kMagic.size() && std::ranges::equal(start.first(kMagic.size()), kMagic);
}

GzipStream::GzipStream(std::FILE* file, std::uint64_t bytes, std::filesystem::path path)
    : GzipStream(file, bytes, path, size_of(file, bytes, path)) {
  refuse_inflation({bytes, inflated_bytes_}, "the gzip archive");
}

GzipStream::GzipStream(std::FILE* file, std::uint64_t bytes, std::filesystem::path path,
                       std::uint64_t inflated)
    : file_(file),
      left_(bytes),
      path_(std::move(path)),
      inflated_bytes_(inflated),
      compressed_(kCompressedChunk) {
  if (inflateInit2(&inflater_, kGzipWindow) != Z_OK) throw std::bad_alloc();
}

std::uint64_t GzipStream::size_of(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  if (bytes < kLeastBytes) throw ModelError(kDamaged);
  const std::uint64_t claimed = claimed_size(file, path);
  // The last four bytes of a file that is cut short, or padded with zeros, are not its size.
  const bool is_possible =
      claimed / kDeflateRatio <= bytes && bytes <= claimed + claimed / 1000 + kMostHeaderBytes;
  const bool may_be_padded = claimed >> 24U == 0;
  if (!may_be_padded && !is_possible) throw ModelError(kDamaged);
  // The size of a small file says too little about the size of its content.
  if (is_possible && (!may_be_padded || bytes > kCompressedChunk)) return claimed;
  GzipStream whole(file, bytes, path, 0);
  std::vector<std::byte> chunk(kCompressedChunk);
  std::uint64_t inflated = 0;
  while (const std::size_t got = whole.read_some(chunk)) {
    inflated += got;
    refuse_inflation({bytes, inflated}, "the gzip archive");
  }
  std::rewind(file);
  return inflated;
}

GzipStream::~GzipStream() {
  inflateEnd(&inflater_);
}

std::size_t GzipStream::read_some(std::span<std::byte> into) {
  const auto room = static_cast<uInt>(std::min<std::size_t>(into.size(), std::numeric_limits<uInt>::max()));
  inflater_.next_out = reinterpret_cast<Bytef*>(into.data());
  inflater_.avail_out = room;
  while (inflater_.avail_out == room && !ended_) {
    if (inflater_.avail_in == 0) fill();
    const int result = inflate(&inflater_, Z_NO_FLUSH);
    ended_ = result == Z_STREAM_END;
    if (result == Z_MEM_ERROR) throw std::bad_alloc();
    if (result != Z_OK && !ended_) throw DamagedStream(kDamaged);
    if (ended_) skip_padding();
  }
  return room - inflater_.avail_out;
}

void GzipStream::skip_padding() {
  const auto is_zero = [](std::byte byte) { return byte == std::byte{}; };
  while (inflater_.avail_in > 0 || left_ > 0) {
    const auto* const rest = reinterpret_cast<const std::byte*>(inflater_.next_in);
    if (!std::all_of(rest, rest + inflater_.avail_in, is_zero))
      throw DamagedStream(
          "the gzip archive holds more than one file, or ends with other data: unpack it, and "
          "print the model that is in it");
    inflater_.avail_in = 0;
    if (left_ > 0) fill();
  }
}

void GzipStream::fill() {
  if (left_ == 0) throw DamagedStream("the gzip archive is cut short: copy it again");
  const std::size_t bytes = std::min<std::uint64_t>(left_, compressed_.size());
  read_exactly(file_, std::span(compressed_).first(bytes), path_);
  left_ -= bytes;
  inflater_.next_in = reinterpret_cast<Bytef*>(compressed_.data());
  inflater_.avail_in = static_cast<uInt>(bytes);
}

}  // namespace contourd
