#include "daemon/frames/frame_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "core/contract/expects.hpp"
#include "daemon/system/checksum.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {
namespace {

constexpr std::string_view kFrameMagic = "contourd-frames\n";
constexpr std::uint32_t kFrameVersion = 1;
constexpr std::uint32_t kBegins = 0x80000000, kMostLayer = 0x7fffff, kDarkness = kMostLayer + 1;

// Returns the nearest number that the type can hold.
template <typename To>
To saturated(std::int64_t number) {
  return static_cast<To>(
      std::clamp<std::int64_t>(number, std::numeric_limits<To>::min(), std::numeric_limits<To>::max()));
}

template <typename Number>
void put(std::string& bytes, Number number) {
  const auto bits = static_cast<std::make_unsigned_t<Number>>(number);
  for (std::size_t byte = 0; byte < sizeof(Number); ++byte)
    bytes.push_back(static_cast<char>(bits >> (8 * byte)));
}

// Takes a number from the front of the bytes, which has that many.
template <typename Number>
Number take(std::string_view& bytes) {
  std::make_unsigned_t<Number> bits = 0;
  for (std::size_t byte = 0; byte < sizeof(Number); ++byte)
    bits = static_cast<decltype(bits)>(
        bits | static_cast<decltype(bits)>(static_cast<unsigned char>(bytes[byte])) << (8 * byte));
  bytes.remove_prefix(sizeof(Number));
  return static_cast<Number>(bits);
}

void put_record(std::string& bytes, const FrameRecord& frame) {
  put(bytes, std::int64_t{frame.shown.time_since_epoch().count()});
  for (const Nanometers height : {frame.cut, frame.first, frame.last})
    put(bytes, saturated<std::int32_t>(height.count()));
  using std::chrono::microseconds;
  put(bytes, saturated<std::uint32_t>(std::chrono::duration_cast<microseconds>(frame.lit).count()));
  put(bytes, (static_cast<std::uint32_t>(frame.layer) & kMostLayer) | (255U - frame.light) * kDarkness |
                 (frame.begins ? kBegins : 0));
  put(bytes, saturated<std::uint16_t>(frame.refreshes));
  put(bytes, saturated<std::uint16_t>(frame.missed));
}

FrameRecord take_record(std::string_view& bytes) {
  FrameRecord frame;
  frame.shown = TimePoint(Duration{take<std::int64_t>(bytes)});
  for (Nanometers* height : {&frame.cut, &frame.first, &frame.last})
    *height = Nanometers{take<std::int32_t>(bytes)};
  frame.lit = std::chrono::microseconds{take<std::uint32_t>(bytes)};
  const auto layer = take<std::uint32_t>(bytes);
  frame.layer = static_cast<std::int32_t>(layer & kMostLayer);
  frame.light = static_cast<std::uint8_t>(255 - (layer & ~kBegins) / kDarkness);
  frame.begins = (layer & kBegins) != 0;
  frame.refreshes = take<std::uint16_t>(bytes);
  frame.missed = take<std::uint16_t>(bytes);
  return frame;
}

// Returns a block's or the end's bytes: two numbers, the checksum of them and of what follows, and that.
std::string block_of(std::uint32_t records, std::uint32_t bytes, std::string_view body) {
  std::string block;
  put(block, records);
  put(block, bytes);
  put(block, checksum_of(body, checksum_of(block)));
  return block += body;
}

std::string header_bytes() {
  std::string header(kFrameMagic);
  put(header, kFrameVersion);
  put(header, static_cast<std::uint32_t>(FrameFile::kRecordBytes));
  put(header, checksum_of(header));
  return header;
}

void write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw std::system_error(errno, std::generic_category(), "cannot write the frames");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void check_header(std::string_view bytes) {
  if (bytes.size() < FrameFile::kHeaderBytes || !bytes.starts_with(kFrameMagic))
    throw std::runtime_error("it is no record of frames");
  std::string_view rest = bytes.substr(kFrameMagic.size());
  const auto version = take<std::uint32_t>(rest);
  if (version != kFrameVersion)
    throw std::runtime_error(
        fmt::format("it is a record of frames of version {}, and only version {} can be "
                    "read",
                    version, kFrameVersion));
  if (!bytes.starts_with(header_bytes())) throw std::runtime_error("it is a damaged record of frames");
}

// Takes the body of the next block or end from the front; nullopt if it is torn or damaged.
struct FrameBlock {
  std::uint32_t records;  // 0: the end
  std::string_view body;
};
std::optional<FrameBlock> take_block(std::string_view& bytes) {
  if (bytes.size() < FrameFile::kBlockHeaderBytes) return std::nullopt;
  std::string_view rest = bytes;
  const auto records = take<std::uint32_t>(rest), others = take<std::uint32_t>(rest);
  const auto checksum = take<std::uint64_t>(rest);
  if (records > FrameFile::kBlockRecords || others != (records == 0 ? 16 : 0)) return std::nullopt;
  const std::size_t size = records * FrameFile::kRecordBytes + others;
  if (rest.size() < size) return std::nullopt;
  const FrameBlock block{records, rest.substr(0, size)};
  if (checksum != checksum_of(block.body, checksum_of(bytes.substr(0, 8)))) return std::nullopt;
  bytes = rest.substr(size);
  return block;
}

}  // namespace

std::string frame_file_text(const std::filesystem::path& path) {
  const FileDescriptor file = open_regular_file(path, Links::Follow);
  std::string bytes;
  constexpr std::size_t kPiece = 1 << 20;
  while (bytes.size() <= FrameFile::kMostBytes) {
    const std::size_t before = bytes.size();
    bytes.resize(std::min(before + kPiece, FrameFile::kMostBytes + 1));
    ssize_t got = ::read(file.get(), bytes.data() + before, bytes.size() - before);
    while (got < 0 && errno == EINTR)
      got = ::read(file.get(), bytes.data() + before, bytes.size() - before);
    if (got < 0) throw UnreadableFile(std::error_code(errno, std::generic_category()), "it cannot be read");
    bytes.resize(before + static_cast<std::size_t>(got));
    if (got == 0) break;
  }
  return bytes;
}

FrameFile read_frame_file(const std::filesystem::path& path) {
  const std::string text = frame_file_text(path);
  if (text.size() > FrameFile::kMostBytes)
    throw std::runtime_error(
        fmt::format("it has more than {} bytes, and no record of frames has", FrameFile::kMostBytes));
  check_header(text);
  std::string_view bytes = std::string_view(text).substr(FrameFile::kHeaderBytes);
  FrameFile file;
  while (std::optional<FrameBlock> block = take_block(bytes)) {
    if (block->records == 0) {
      const auto records = take<std::uint64_t>(block->body);
      file.lost = take<std::uint64_t>(block->body);
      file.after_end = bytes.size();
      file.complete = bytes.empty() && records == file.records.size();
      break;
    }
    for (std::uint32_t record = 0; record < block->records; ++record)
      file.records.push_back(take_record(block->body));
  }
  return file;
}

FrameFileWriter::FrameFileWriter(const std::filesystem::path& path) {
  constexpr mode_t kOwnerOnly = 0600;
  file_ =
      FileDescriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, kOwnerOnly));
  if (!file_.valid()) throw std::system_error(errno, std::generic_category(), "cannot make " + path.string());
  write_all(file_.get(), header_bytes());
}

void FrameFileWriter::add(std::span<const FrameRecord> records) {
  expects(!records.empty() && records.size() <= FrameFile::kBlockRecords &&
              records_ % FrameFile::kBlockRecords == 0 &&
              records_ + records.size() <= FrameFile::kMostRecords,
          "the block has its number of records, and the file has room for it");
  std::string body;
  body.reserve(records.size() * FrameFile::kRecordBytes);
  for (const FrameRecord& record : records)
    put_record(body, record);
  write_all(file_.get(), block_of(static_cast<std::uint32_t>(records.size()), 0, body));
  records_ += records.size();
}

void FrameFileWriter::finish(std::uint64_t lost) {
  std::string body;
  put(body, static_cast<std::uint64_t>(records_));
  put(body, lost);
  write_all(file_.get(), block_of(0, static_cast<std::uint32_t>(body.size()), body));
  file_ = FileDescriptor();
}

}  // namespace contourd
