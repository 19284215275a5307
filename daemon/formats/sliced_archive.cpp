#include "daemon/formats/sliced_archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/nanodlp_archive.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

constexpr std::string_view kConfig = "config.ini", kSlicerConfig = "prusaslicer.ini", kPicture = ".png",
                           kOutlines = ".svg";
static_assert(kPicture.size() == kOutlines.size());
constexpr std::size_t kDigits = 5;
constexpr std::uint64_t kMostConfigBytes = std::uint64_t{1} << 20U;
// Bytes that a PNG picture may have besides its pixels: rows' filters are a byte each.
constexpr std::uint64_t kMostBeside = std::uint64_t{1} << 17U;
// Pixels may be this much larger or smaller than the display's: 0.1 mm on a part of 20 mm.
constexpr double kPitchTolerance = 0.005;
// A layer of 8 million pixels takes a Raspberry Pi a tenth of a second.
constexpr std::chrono::minutes kLongestReading{20};

constexpr std::string_view kSliceForDisplay =
    "slice the model for this printer's display, or print the model itself";

// The name of a layer's file: "part00012.png".
struct LayerName {
  std::string_view stem;  // beginning, before the number
  std::size_t number;
  bool is_outlines;
};

// Returns the parts of the name; nullopt if the file is no layer's.
std::optional<LayerName> layer_name(std::string_view name) {
  const bool is_outlines = name.ends_with(kOutlines);
  if (name.find_first_of("/\\") != std::string_view::npos || (!is_outlines && !name.ends_with(kPicture)))
    return std::nullopt;
  name.remove_suffix(kPicture.size());
  if (name.size() < kDigits) return std::nullopt;
  std::size_t number = 0;
  for (const char digit : name.substr(name.size() - kDigits)) {
    if (digit < '0' || digit > '9') return std::nullopt;
    number = 10 * number + static_cast<std::size_t>(digit - '0');
  }
  return LayerName{name.substr(0, name.size() - kDigits), number, is_outlines};
}

struct PictureSize {
  std::int64_t width = 0, height = 0;
  bool operator==(const PictureSize&) const = default;

  [[nodiscard]] PictureSize turned() const { return {height, width}; }
  [[nodiscard]] std::string text() const { return fmt::format("{}x{}", width, height); }
};

// Returns the size that the beginning of a PNG file names (ISO/IEC 15948, 11.2.2).
PictureSize size_of_png(std::span<const std::uint8_t> bytes, const std::string& name) {
  constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  constexpr std::size_t kWidth = 16, kHeight = 20, kEnd = 24;
  if (bytes.size() < kEnd || !std::ranges::equal(bytes.first(kSignature.size()), kSignature))
    throw ModelError(fmt::format("{} is no PNG picture: slice the model again", in_quotes(name)));
  const auto number = [&bytes](std::size_t at) {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = 256 * value + bytes[at + i];
    return value;
  };
  return {number(kWidth), number(kHeight)};
}

// Mirrors the picture.
void mirror(Mask& picture, bool columns, bool rows) {
  const std::int32_t height = picture.height().count();
  for (std::int32_t y = 0; columns && y < height; ++y)
    std::ranges::reverse(picture.row(y));
  for (std::int32_t y = 0; rows && y < height / 2; ++y)
    std::ranges::swap_ranges(picture.row(y), picture.row(height - 1 - y));
}

enum class Quarter { None, Clockwise, CounterClockwise };

Mask turned(const Mask& picture, Quarter quarter) {
  Mask made(picture.height(), picture.width());
  const std::int32_t width = picture.width().count(), height = picture.height().count();
  for (std::int32_t y = 0; y < height; ++y) {
    const auto row = picture.row(y);
    for (std::int32_t x = 0; x < width; ++x) {
      const bool clockwise = quarter == Quarter::Clockwise;
      const std::int32_t to_y = clockwise ? x : width - 1 - x, to_x = clockwise ? height - 1 - y : y;
      made.row(to_y)[static_cast<std::size_t>(to_x)] = row[static_cast<std::size_t>(x)];
    }
  }
  return made;
}

// The transformation of a picture for the display: mirrored, then turned, then mirrored again.
struct Turn {
  bool mirror_columns = false, mirror_rows = false;
  Quarter quarter = Quarter::None;
  bool then_mirror_columns = false, then_mirror_rows = false;

  [[nodiscard]] Mask apply(Mask picture) const {
    if (quarter == Quarter::None) {
      mirror(picture, mirror_columns != then_mirror_columns, mirror_rows != then_mirror_rows);
      return picture;
    }
    mirror(picture, mirror_columns, mirror_rows);
    Mask made = turned(picture, quarter);
    mirror(made, then_mirror_columns, then_mirror_rows);
    return made;
  }
};

void check_pitch(const SlicedDisplay& sliced, const DisplayGeometry& display) {
  const double pitch_um = display.pixel_pitch.count();
  const double tolerance_um = kPitchTolerance * pitch_um + sliced.pitch_error_um;
  for (const double sliced_um : sliced.pitch_um) {
    if (std::fabs(sliced_um - pitch_um) <= tolerance_um) continue;
    throw ModelError(fmt::format(
        "its pixels are {:.2f} x {:.2f} um large, and this display's {:.2f} um, so that the part would come "
        "out "
        "{:.1f} % too {}: {}",
        sliced.pitch_um[0], sliced.pitch_um[1], pitch_um, 100 * std::fabs(pitch_um / sliced_um - 1),
        sliced_um < pitch_um ? "large" : "small", kSliceForDisplay));
  }
}

// `file` names the display.
void check_size(const SlicedDisplay& sliced, const PictureSize& size, const char* file) {
  const PictureSize on_plate{sliced.pixels[0], sliced.pixels[1]};
  if ((sliced.on_end ? on_plate.turned() : on_plate) == size) return;
  throw ModelError(
      fmt::format("{} names a display of {} pixels, and the pictures have {}: slice the model again", file,
                  on_plate.text(), size.text()));
}

// Returns the turn from pictures of this size to the display. Throws ModelError if they do not agree with it.
Turn turn_for(const std::optional<SlicedDisplay>& sliced, const PictureSize& size,
              const DisplayGeometry& display) {
  const PictureSize wanted{display.width.count(), display.height.count()};
  const auto refuse = [&] {
    throw ModelError(fmt::format("its pictures have {} pixels, and this display {}: {}", size.text(),
                                 wanted.text(), kSliceForDisplay));
  };
  if (!sliced || !sliced->mirrors_known) {
    if (size != wanted) refuse();
    if (sliced) check_size(*sliced, size, "options.json");
    if (sliced) check_pitch(*sliced, display);
    return {};
  }
  check_size(*sliced, size, "prusaslicer.ini");
  if (size != wanted && size.turned() != wanted) refuse();
  check_pitch(*sliced, display);
  const bool is_square = size == size.turned();
  const bool is_turned = size != wanted || (is_square && sliced->on_end);
  return {sliced->mirror_columns, sliced->mirror_rows,
          !is_turned       ? Quarter::None
          : sliced->on_end ? Quarter::Clockwise
                           : Quarter::CounterClockwise,
          display.mirror_x, display.mirror_y};
}

Mask decode(std::span<const std::uint8_t> bytes, const PictureSize& size, const std::string& name) {
  if (const PictureSize own = size_of_png(bytes, name); own != size)
    throw ModelError(fmt::format("{} has {} pixels, and the first picture {}: slice the model again",
                                 in_quotes(name), own.text(), size.text()));
  try {
    return decode_png(bytes, Pixels{static_cast<std::int32_t>(size.width)},
                      Pixels{static_cast<std::int32_t>(size.height)});
  } catch (const std::runtime_error& error) {
    throw ModelError(fmt::format("{}: {}: slice the model again", in_quotes(name), printable(error.what())));
  }
}

}  // namespace

bool is_sliced(const ZipArchive& archive) {
  if (is_nanodlp(archive)) return true;
  return archive.find(kConfig) != nullptr &&
         std::ranges::any_of(archive.entries(),
                             [](const ZipEntry& entry) { return layer_name(entry.name).has_value(); });
}

SlicedArchive::SlicedArchive(std::shared_ptr<const ZipArchive> archive) : archive_(std::move(archive)) {
  const auto text = [this](std::string_view name) {
    const ZipEntry* const entry = archive_->find(name);
    if (entry == nullptr) return std::string();
    const std::vector<std::uint8_t> bytes = bytes_of(*entry, kMostConfigBytes);
    return std::string(bytes.begin(), bytes.end());
  };
  if (is_nanodlp(*archive_)) {
    format_ = "nanodlp";
    settings_ = read_nanodlp_settings(
        {.plate = text("plate.json"), .profile = text("profile.json"), .options = text("options.json")});
    files_ = nanodlp_layers(*archive_, settings_.layers);
    return;
  }
  settings_ = read_sliced_settings(parse_ini(text(kConfig)), parse_ini(text(kSlicerConfig)));
  list_layers();
  if (has_outlines_) format_ = "sl1_svg";
}

std::vector<std::uint8_t> SlicedArchive::bytes_of(const ZipEntry& entry, std::uint64_t most) const {
  if (entry.inflated > most)
    throw ModelError(fmt::format("{} has {} bytes, and the limit is {}: slice the model again",
                                 in_quotes(entry.name), entry.inflated, most));
  const std::unique_ptr<ByteStream> stream = archive_->open(entry);
  std::vector<std::uint8_t> bytes(entry.inflated);
  std::size_t got = 0;
  while (got < bytes.size()) {
    const std::size_t more = stream->read_some(std::as_writable_bytes(std::span(bytes)).subspan(got));
    if (more == 0)
      throw ModelError(fmt::format("{} in the archive ends after {} of {} bytes: copy the archive again",
                                   in_quotes(entry.name), got, bytes.size()));
    got += more;
  }
  std::byte beyond{};
  (void)stream->read_some({&beyond, 1});  // checks the sum of the bytes
  return bytes;
}

void SlicedArchive::list_layers() {
  std::vector<const ZipEntry*> found;
  for (const ZipEntry& entry : archive_->entries())
    if (layer_name(entry.name)) found.push_back(&entry);
  // Other pictures may lie beside the layers, if config.ini says how the layers are called.
  const auto is_named = [this](const ZipEntry* entry) {
    return layer_name(entry->name)->stem == settings_.name;
  };
  if (std::ranges::any_of(found, is_named)) std::erase_if(found, std::not_fn(is_named));
  std::ranges::sort(found, {}, [](const ZipEntry* entry) { return layer_name(entry->name)->number; });
  const LayerName first = *layer_name(found.front()->name);
  has_outlines_ = first.is_outlines;
  const std::string_view kind = has_outlines_ ? "outline" : "picture";
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string& name = found[i]->name;
    const auto [stem, layer, is_outlines] = *layer_name(name);
    if (stem != first.stem || is_outlines != has_outlines_ || layer < i)
      throw ModelError(fmt::format("two files, {} and {}, may be those of a layer: slice the model again",
                                   in_quotes(found[i == 0 ? 0 : i - 1]->name), in_quotes(name)));
    if (layer > i)
      throw ModelError(
          fmt::format("the {} of layer {}, {}{:05}{}, is missing: copy the archive again, or slice the model "
                      "again",
                      kind, i + 1, printable(stem), i, has_outlines_ ? kOutlines : kPicture));
  }
  if (static_cast<std::int64_t>(found.size()) < settings_.layers)
    throw ModelError(
        fmt::format("config.ini names {} layers (numFast and numSlow), and {}s of {} are there: copy the "
                    "archive again, or slice the model again",
                    settings_.layers, kind, found.size()));
  files_ = std::move(found);
}

std::shared_ptr<const PictureStack> SlicedArchive::read(const DisplayGeometry& display,
                                                        std::uint64_t most_bytes,
                                                        const std::stop_token& stop) const {
  expects(!has_outlines_, "the archive has pictures");
  const auto end = std::chrono::steady_clock::now() + kLongestReading;
  const auto pixels =
      static_cast<std::uint64_t>(display.width.count()) * static_cast<std::uint64_t>(display.height.count());
  const std::uint64_t most = pixels + kMostBeside;
  const PictureSize size = size_of_png(bytes_of(*files_.front(), most), files_.front()->name);
  const Turn turn = turn_for(settings_.display, size, display);
  auto stack = std::make_shared<PictureStack>(display.width, display.height, settings_.layer_height);
  std::vector<std::uint8_t> bytes, bytes_beneath;
  Mask picture;
  for (const ZipEntry* const entry : files_) {
    if (stop.stop_requested()) return stack;
    bytes = bytes_of(*entry, most);
    // Layers of upright walls are equal, and comparing their files takes a hundredth of decoding them.
    if (bytes != bytes_beneath) picture = turn.apply(decode(bytes, size, entry->name));
    stack->add(picture);
    bytes_beneath.swap(bytes);
    if (stack->bytes() > most_bytes)
      throw ModelError(fmt::format(
          "the pictures of its first {} layers take {} MB of memory, and {} MB are free for them: print "
          "the model itself",
          stack->layers(), stack->bytes() >> 20U, most_bytes >> 20U));
    if (std::chrono::steady_clock::now() > end)
      throw ModelError(
          fmt::format("reading its pictures takes longer than {} minutes: print the model itself",
                      kLongestReading.count()));
  }
  if (!stack->lit()) throw ModelError("all its pictures are dark: slice the model again");
  return stack;
}

}  // namespace contourd
