#include "core/formats/model_reader.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "core/formats/other_formats.hpp"
#include "core/formats/stl_ascii.hpp"
#include "core/formats/stl_binary.hpp"
#include "core/model/stray_facets.hpp"

namespace contourd {
namespace {

// The formats in order of precedence: if two are equally certain of a file, the first one reads it.
constexpr std::array kFormats{&kAsciiStl, &kBinaryStl};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::system_error cannot_read(const std::filesystem::path& path, std::error_code code) {
  return std::system_error(code, "cannot read " + path.string());
}

// A system_error whose what() is the sentence alone: "Invalid argument" after the sentence would explain
// nothing.
class NotARegularFile : public std::system_error {
 public:
  explicit NotARegularFile(const std::filesystem::path& path)
      : std::system_error(std::make_error_code(std::errc::invalid_argument)),
        sentence_("cannot read " + path.string() + ": it is not a regular file") {}
  [[nodiscard]] const char* what() const noexcept override { return sentence_.what(); }

 private:
  std::runtime_error sentence_;  // a runtime_error, because copying one cannot fail
};

void read_exactly(std::FILE* file, std::span<std::byte> into, const std::filesystem::path& path) {
  errno = 0;
  if (std::fread(into.data(), 1, into.size(), file) == into.size()) return;
  throw cannot_read(path, errno != 0 ? std::error_code(errno, std::generic_category())
                                     : std::make_error_code(std::errc::io_error));
}

const ModelFormat& format_of(const FileStart& start) {
  if (start.file_bytes == 0) throw ModelError("the file is empty");
  const auto likeness = [&](const ModelFormat* format) { return format->likeness(start); };
  const ModelFormat& format = **std::ranges::max_element(kFormats, {}, likeness);
  if (format.likeness(start) < Likeness::Likely) refuse_other_format(start.bytes);
  return format;
}

std::string_view without_leading_blanks(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(" \t"), text.size()));
}

// Returns the unit that the first line or the header names as "UNITS=mm", in either case and with blanks
// around the sign; nullopt if there is none.
std::optional<LengthUnit> unit_in(std::span<const std::byte> start) {
  constexpr std::size_t kHeaderBytes = 80;  // of binary STL; the first line of a text is rarely longer
  constexpr std::string_view kKey = "units", kEnds{" \t\r\n,;\0", 7};
  const std::string_view header(reinterpret_cast<const char*>(start.data()),
                                std::min(start.size(), kHeaderBytes));
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  auto key = std::search(header.begin(), header.end(), kKey.begin(), kKey.end(), same);
  for (; key != header.end(); key = std::search(key + 1, header.end(), kKey.begin(), kKey.end(), same)) {
    const auto place = static_cast<std::size_t>(key - header.begin());
    std::string_view value = without_leading_blanks(header.substr(place + kKey.size()));
    if (!value.starts_with('=')) continue;
    value = without_leading_blanks(value.substr(1));
    return length_unit(value.substr(0, value.find_first_of(kEnds)));
  }
  return std::nullopt;
}

Model read_model(const FileStart& start, const ReadBytes& read) {
  Model model = format_of(start).read(start, read);
  model.unit = unit_in(start.bytes);
  drop_stray_facets(model);
  return model;
}

// Returns the file's first bytes and leaves the file at its beginning.
std::vector<std::byte> read_start(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  std::vector<std::byte> start(std::min<std::uint64_t>(bytes, kSniffBytes));
  read_exactly(file, start, path);
  std::rewind(file);
  return start;
}

File open_regular(const std::filesystem::path& path) {
  std::error_code code;
  // Checked before opening: opening a FIFO would wait for a writer.
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

std::vector<std::string_view> model_extensions() {
  std::vector<std::string_view> extensions;
  for (const ModelFormat* format : kFormats) {
    if (std::ranges::find(extensions, format->extension) == extensions.end())
      extensions.push_back(format->extension);
  }
  return extensions;
}

std::string_view model_extension(std::string_view file_name) {
  std::string extension = std::filesystem::path(file_name).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const auto* const format = std::ranges::find(kFormats, extension, &ModelFormat::extension);
  return format == kFormats.end() ? "" : (*format)->extension;
}

ModelOutline outline_of_model(const std::filesystem::path& path) {
  const File file = open_regular(path);
  return outline_of_model(file.get(), std::filesystem::file_size(path), path);
}

ModelOutline outline_of_model(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  const std::vector<std::byte> first_bytes = read_start(file, bytes, path);
  const FileStart start{bytes, first_bytes};
  const ModelFormat& format = format_of(start);
  ModelOutline outline = format.outline(start);
  outline.format = format.name;
  return outline;
}

Model read_model_file(const std::filesystem::path& path) {
  const File file = open_regular(path);
  return read_model_file(file.get(), std::filesystem::file_size(path), path);
}

Model read_model_file(std::FILE* file, std::uint64_t bytes, const std::filesystem::path& path) {
  const std::vector<std::byte> first_bytes = read_start(file, bytes, path);
  const FileStart start{bytes, first_bytes};
  return read_model(start, [&](std::span<std::byte> into) { read_exactly(file, into, path); });
}

Model read_model(std::span<const std::byte> bytes) {
  const FileStart start{bytes.size(), bytes.first(std::min(bytes.size(), kSniffBytes))};
  std::span<const std::byte> rest = bytes;
  return read_model(start, [&rest](std::span<std::byte> into) {
    std::memcpy(into.data(), rest.data(), into.size());
    rest = rest.subspan(into.size());
  });
}

}  // namespace contourd
