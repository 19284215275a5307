#include "daemon/formats/nanodlp_archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/model/model.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

constexpr const char *kPlate = "plate.json", *kProfile = "profile.json", *kOptions = "options.json";
constexpr std::string_view kPlatePicture = ".png";
constexpr std::size_t kMostDigits = 5;

// Returns the layer of "12.png", from 1; 0 if the file is no layer's.
std::size_t plate_layer(std::string_view name) {
  if (!name.ends_with(kPlatePicture)) return 0;
  name.remove_suffix(kPlatePicture.size());
  std::size_t layer = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), layer);
  const bool is_number = error == std::errc{} && end == name.data() + name.size();
  return is_number && name.size() <= kMostDigits && !name.starts_with('0') ? layer : 0;
}

struct FigureRange {
  double least, most;
};

// The numbers of one of the archive's files.
class PlateFigures {
 public:
  // `text` is empty if there is no such file.
  PlateFigures(const std::string& text, const char* file) : file_(file) {
    if (text.empty()) return;
    values_ = nlohmann::json::parse(text, nullptr, false);
    if (!values_.is_object()) throw ModelError(fmt::format("{} is damaged: slice the model again", file_));
  }

  [[nodiscard]] std::optional<double> number(const char* key, const FigureRange& range) const {
    const auto found = values_.find(key);
    if (found == values_.end() || found->is_null()) return std::nullopt;
    if (!found->is_number())
      throw ModelError(fmt::format("{} of {} is no number: slice the model again", key, file_));
    const double number = found->get<double>();
    if (number == 0) return std::nullopt;
    if (!(number >= range.least && number <= range.most))
      throw ModelError(
          fmt::format("{} of {} is {}, and a number from {} to {} is possible: slice the model again", key,
                      file_, decimal(number), decimal(range.least), decimal(range.most)));
    return number;
  }

 private:
  nlohmann::json values_ = nlohmann::json::object();
  const char* file_;
};

// Returns the first number of these that there is.
std::optional<double> first_figure(std::initializer_list<std::pair<const PlateFigures*, const char*>> places,
                                   const FigureRange& range) {
  for (const auto& [figures, key] : places)
    if (const std::optional<double> number = figures->number(key, range)) return number;
  return std::nullopt;
}

std::optional<SlicedExposures> plate_exposures(const PlateFigures& profile) {
  constexpr FigureRange kSeconds{0.001, 1000}, kLayers{1, 1000};
  const auto time = [](double seconds) { return std::chrono::nanoseconds(std::llround(seconds * 1e9)); };
  const std::optional<double> normal = profile.number("CureTime", kSeconds);
  if (!normal) return std::nullopt;
  return SlicedExposures{
      .normal = time(*normal),
      .first = time(profile.number("SupportCureTime", kSeconds).value_or(*normal)),
      .first_layers = static_cast<int>(profile.number("SupportLayerNumber", kLayers).value_or(0))};
}

std::optional<SlicedDisplay> plate_display(const PlateFigures& options) {
  constexpr FigureRange kPixels{1, 100'000}, kPixelMm{0.001, 1};
  // DragonFruit rounds the size of a pixel to whole micrometres.
  SlicedDisplay display{.pitch_error_um = 0.5, .mirrors_known = false};
  constexpr std::array<const char*, 2> kPixelKeys{"PWidth", "PHeight"}, kSizeKeys{"XPixelSize", "YPixelSize"};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto pixels = options.number(kPixelKeys[axis], kPixels),
               mm = options.number(kSizeKeys[axis], kPixelMm);
    if (!pixels || !mm) return std::nullopt;
    display.pixels[axis] = std::llround(*pixels);
    display.pitch_um[axis] = 1000 * *mm;
  }
  return display;
}

}  // namespace

bool is_nanodlp(const ZipArchive& archive) {
  return archive.find(kPlate) != nullptr && archive.find("1.png") != nullptr &&
         (archive.find(kProfile) != nullptr || archive.find(kOptions) != nullptr);
}

SlicedSettings read_nanodlp_settings(const NanodlpTexts& texts) {
  constexpr FigureRange kThickness{1, 1000}, kLayers{1, 1e6};
  const PlateFigures plate(texts.plate, kPlate), profile(texts.profile, kProfile),
      options(texts.options, kOptions);
  const auto height = [](double um) { return Nanometers{std::llround(um * 1000)}; };
  const std::optional<double> layer_um =
      first_figure({{&options, "Thickness"}, {&profile, "Depth"}, {&plate, "LayerThickness"}}, kThickness);
  if (!layer_um)
    throw ModelError(
        "neither options.json nor profile.json has the thickness of a layer (Thickness, Depth): slice the "
        "model "
        "again, or print the model itself");
  SlicedSettings settings;
  settings.layer_height = height(*layer_um);
  settings.first_layer = height(
      first_figure({{&options, "SupportDepth"}, {&profile, "SupportDepth"}}, kThickness).value_or(*layer_um));
  settings.exposures = plate_exposures(profile);
  settings.display = plate_display(options);
  settings.layers = std::llround(plate.number("LayersCount", kLayers).value_or(0));
  return settings;
}

std::vector<const ZipEntry*> nanodlp_layers(const ZipArchive& archive, std::int64_t layers) {
  expects(is_nanodlp(archive), "the archive is a plate of NanoDLP");
  std::vector<const ZipEntry*> found;
  for (const ZipEntry& entry : archive.entries())
    if (plate_layer(entry.name) > 0) found.push_back(&entry);
  std::ranges::sort(found, {}, [](const ZipEntry* entry) { return plate_layer(entry->name); });
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t layer = plate_layer(found[i]->name);
    if (layer <= i)
      throw ModelError(fmt::format("the archive has two files {}.png: slice the model again", layer));
    if (layer > i + 1)
      throw ModelError(fmt::format(
          "the picture of layer {0}, {0}.png, is missing: copy the archive again, or slice the model again",
          i + 1));
  }
  if (layers > 0 && static_cast<std::int64_t>(found.size()) != layers)
    throw ModelError(fmt::format(
        "plate.json names {} layers (LayersCount), but the archive has pictures of {}: copy the archive "
        "again, or slice the model again",
        layers, found.size()));
  return found;
}

}  // namespace contourd
