#include "daemon/formats/sl1_config.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/model/model.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

struct Range {
  double least, most;
};

// The numbers of one of the archive's files.
class Figures {
 public:
  Figures(const IniFile& values, std::string_view file) : values_(values), file_(file) {}

  [[nodiscard]] std::optional<std::string> text(std::string_view key) const {
    const auto found = values_.find(key);
    if (found == values_.end() || found->second.empty()) return std::nullopt;
    return found->second;
  }

  // Returns the number, or nullopt if there is none.
  [[nodiscard]] std::optional<double> number(std::string_view key, const Range& range) const {
    const std::optional<std::string> value = text(key);
    if (!value) return std::nullopt;
    double number = 0;
    const char* const end = value->data() + value->size();
    const auto [read, error] = std::from_chars(value->data(), end, number);
    if (error != std::errc{} || read != end || !(number >= range.least && number <= range.most))
      throw ModelError(
          fmt::format("{} of {} is {}, and a number from {} to {} is possible: slice the model again", key,
                      file_, in_quotes(*value), decimal(range.least), decimal(range.most)));
    return number;
  }

 private:
  const IniFile& values_;
  std::string_view file_;
};

std::optional<SlicedExposures> exposures_of(const Figures& config) {
  constexpr Range kSeconds{0.001, 1000}, kLayers{0, 1000};
  const auto normal = config.number("expTime", kSeconds), first = config.number("expTimeFirst", kSeconds);
  if (!normal || !first) return std::nullopt;
  const auto time = [](double seconds) { return std::chrono::nanoseconds(std::llround(seconds * 1e9)); };
  return SlicedExposures{time(*normal), time(*first),
                         static_cast<int>(config.number("numFade", kLayers).value_or(0))};
}

std::optional<SlicedDisplay> display_of_slicer(const Figures& slicer) {
  constexpr Range kPixels{1, 100'000}, kMillimeters{0.1, 10'000}, kYes{0, 1};
  constexpr std::array<const char*, 2> kPixelKeys{"display_pixels_x", "display_pixels_y"};
  constexpr std::array<const char*, 2> kSizeKeys{"display_width", "display_height"};
  SlicedDisplay display;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto pixels = slicer.number(kPixelKeys[axis], kPixels),
               mm = slicer.number(kSizeKeys[axis], kMillimeters);
    if (!pixels || !mm) return std::nullopt;
    display.pixels[axis] = std::llround(*pixels);
    display.pitch_um[axis] = 1000 * *mm / *pixels;
  }
  display.mirror_columns = slicer.number("display_mirror_x", kYes).value_or(0) > 0;
  display.mirror_rows = slicer.number("display_mirror_y", kYes).value_or(0) > 0;
  display.on_end = slicer.text("display_orientation") == "portrait";
  return display;
}

}  // namespace

IniFile parse_ini(std::string_view text) {
  IniFile values;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t sign = line.find('=');
    if (sign == std::string_view::npos) continue;
    values.insert_or_assign(std::string(trimmed(line.substr(0, sign))), trimmed(line.substr(sign + 1)));
  }
  return values;
}

SlicedSettings read_sliced_settings(const IniFile& config, const IniFile& prusaslicer) {
  constexpr Range kLayerMm{0.001, 1}, kLayers{0, 1e6}, kGamma{0, 10};
  const Figures figures(config, "config.ini");
  const std::optional<double> layer_mm = figures.number("layerHeight", kLayerMm);
  if (!layer_mm)
    throw ModelError(
        "config.ini has no layerHeight, without which its pictures have no thickness: slice the model "
        "again, or print the model itself");
  SlicedSettings settings;
  settings.layer_height = Nanometers{std::llround(*layer_mm * 1e6)};
  settings.exposures = exposures_of(figures);
  const Figures slicer(prusaslicer, "prusaslicer.ini");
  const double first_mm = slicer.number("initial_layer_height", kLayerMm).value_or(*layer_mm);
  settings.first_layer = Nanometers{std::llround(first_mm * 1e6)};
  settings.display = display_of_slicer(slicer);
  settings.gamma = slicer.number("gamma_correction", kGamma).value_or(1);
  settings.name = figures.text("jobDir").value_or("");
  settings.layers = std::llround(figures.number("numFast", kLayers).value_or(0) +
                                 figures.number("numSlow", kLayers).value_or(0));
  return settings;
}

}  // namespace contourd
