#include "core/stl_reader.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "core/stl_formats.hpp"

namespace contourd {
namespace {

// How much of the start is looked at to tell ASCII from binary.
constexpr std::size_t kSniffBytes = 1024;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::system_error cannot_read(const std::filesystem::path& path, std::error_code code) {
  return std::system_error(code, "cannot read " + path.string());
}

// A code says why, but what() is the sentence alone: "Invalid argument" after it would tell nothing.
class NotARegularFile : public std::system_error {
 public:
  explicit NotARegularFile(const std::filesystem::path& path)
      : std::system_error(std::make_error_code(std::errc::invalid_argument)),
        sentence_("cannot read " + path.string() + ": it is not a regular file") {}
  [[nodiscard]] const char* what() const noexcept override { return sentence_.what(); }

 private:
  std::runtime_error sentence_;  // its copies cannot fail
};

void read_exactly(std::FILE* file, std::span<std::byte> into, const std::filesystem::path& path) {
  errno = 0;
  if (std::fread(into.data(), 1, into.size(), file) == into.size()) return;
  throw cannot_read(path, errno != 0 ? std::error_code(errno, std::generic_category())
                                     : std::make_error_code(std::errc::io_error));
}

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

bool starts_with_ignoring_case(std::string_view text, std::string_view lower_case_word) {
  return text.size() >= lower_case_word.size() &&
         std::equal(lower_case_word.begin(), lower_case_word.end(), text.begin(),
                    [](char w, char t) { return w == (t >= 'A' && t <= 'Z' ? t - 'A' + 'a' : t); });
}

// Text never holds a NUL; STL text begins with `solid`, or with a comment, or (no solid line) with a facet.
bool looks_like_ascii(std::string_view start) {
  if (start.find('\0') != std::string_view::npos) return false;
  if (start.starts_with("\xEF\xBB\xBF")) start.remove_prefix(3);  // UTF-8 byte order mark
  while (!start.empty() && is_space(start.front()))
    start.remove_prefix(1);
  return starts_with_ignoring_case(start, "solid") || starts_with_ignoring_case(start, "facet") ||
         start.starts_with('#');
}

// By the size and the first bytes. Throws StlError when it is neither.
StlFormat format_of(std::uint64_t bytes, std::span<const std::byte> start) {
  if (bytes == 0) throw StlError("the file is empty");
  const bool room_for_header = start.size() >= kBinaryHeaderBytes;
  const bool exact_size =
      room_for_header && kBinaryHeaderBytes + kBinaryFacetBytes * claimed_facets(start) == bytes;
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  if (!exact_size && looks_like_ascii(text)) return StlFormat::Ascii;
  if (!room_for_header) {
    throw StlError("not an STL file: " + std::to_string(bytes) +
                   " bytes are too few for a binary one (84 at least), and it does not begin with \"solid\"");
  }
  return StlFormat::Binary;
}

// `bytes` is the size, `start` the first bytes, `read` gives all from the first on.
StlModel read_any(std::uint64_t bytes, std::span<const std::byte> start, const ReadBytes& read) {
  if (format_of(bytes, start) == StlFormat::Ascii) {
    std::vector<std::byte> all(bytes);
    read(all);
    return read_ascii_stl({reinterpret_cast<const char*>(all.data()), all.size()});
  }
  std::array<std::byte, kBinaryHeaderBytes> header{};
  read(header);
  return read_binary_stl(header, bytes, read);
}

// The file is at its beginning again then.
std::vector<std::byte> read_start(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  std::vector<std::byte> start(std::min<std::uint64_t>(bytes, kSniffBytes));
  read_exactly(file, start, path);
  std::rewind(file);
  return start;
}

File open_regular(const std::filesystem::path& path) {
  std::error_code code;
  // Asked before opening: opening a FIFO would wait for a writer.
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (code && status.type() != std::filesystem::file_type::not_found) throw cannot_read(path, code);
  if (!std::filesystem::exists(status)) {
    throw cannot_read(path, std::make_error_code(std::errc::no_such_file_or_directory));
  }
  if (std::filesystem::is_directory(status)) {
    throw cannot_read(path, std::make_error_code(std::errc::is_a_directory));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw NotARegularFile(path);
  }
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) throw cannot_read(path, std::error_code(errno, std::generic_category()));
  return file;
}

}  // namespace

std::string_view name_of(StlFormat format) {
  return format == StlFormat::Binary ? "binary" : "ascii";
}

StlOutline outline_of_stl(const std::filesystem::path& path) {
  const File file = open_regular(path);
  return outline_of_stl(file.get(), std::filesystem::file_size(path), path);
}

StlOutline outline_of_stl(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  const std::vector<std::byte> start = read_start(file, bytes, path);
  // White space behind the last facet may be missing.
  if (format_of(bytes, start) == StlFormat::Ascii)
    return {StlFormat::Ascii, (bytes + 1) / kShortestAsciiFacet.size(), bytes};
  const BinaryExtent extent = binary_extent(std::span(start).first(kBinaryHeaderBytes), bytes);
  return {StlFormat::Binary, extent.facets, extent.fills_file ? 0 : bytes - kBinaryHeaderBytes};
}

StlModel read_stl_file(const std::filesystem::path& path) {
  const File file = open_regular(path);
  return read_stl_file(file.get(), std::filesystem::file_size(path), path);
}

StlModel read_stl_file(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  const std::vector<std::byte> start = read_start(file, bytes, path);
  return read_any(bytes, start, [&](std::span<std::byte> into) { read_exactly(file, into, path); });
}

StlModel read_stl(std::span<const std::byte> bytes) {
  std::span<const std::byte> rest = bytes;
  return read_any(bytes.size(), bytes.first(std::min(bytes.size(), kSniffBytes)),
                  [&rest](std::span<std::byte> into) {
                    std::memcpy(into.data(), rest.data(), into.size());
                    rest = rest.subspan(into.size());
                  });
}

}  // namespace contourd
