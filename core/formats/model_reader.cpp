#include "core/formats/model_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "core/formats/file_bytes.hpp"
#include "core/formats/obj.hpp"
#include "core/formats/other_formats.hpp"
#include "core/formats/stl_ascii.hpp"
#include "core/formats/stl_binary.hpp"
#include "core/model/stray_facets.hpp"

namespace contourd {
namespace {

// The formats in order of precedence: if two are equally certain of a file, the first one reads it.
constexpr std::array kFormats{&kAsciiStl, &kBinaryStl, &kObj};

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

}  // namespace

bool is_recognised(const FileStart& start) {
  return std::ranges::any_of(
      kFormats, [&](const ModelFormat* format) { return format->likeness(start) >= Likeness::Likely; });
}

ModelOutline outline_of_model(const FileStart& start) {
  const ModelFormat& format = format_of(start);
  ModelOutline outline = format.outline(start);
  outline.format = format.name;
  return outline;
}

Model read_model(const FileStart& start, const ReadBytes& read) {
  Model model = format_of(start).read(start, read);
  if (!model.unit) model.unit = unit_in(start.bytes);
  drop_stray_facets(model);
  return model;
}

Model read_model_file(const std::filesystem::path& path) {
  const OpenFile file = open_regular(path);
  const std::uint64_t bytes = std::filesystem::file_size(path);
  const std::vector<std::byte> first_bytes = read_start(file.get(), bytes, path);
  return read_model({bytes, first_bytes},
                    [&](std::span<std::byte> into) { read_exactly(file.get(), into, path); });
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
