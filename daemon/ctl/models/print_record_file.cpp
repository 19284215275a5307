#include "daemon/ctl/models/print_record_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/model/model.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

// The report of some sixty thousand layers.
constexpr std::size_t kLargestReport = std::size_t{32} << 20U;
constexpr std::uint32_t kMostLayers = 10'000'000;

std::string read_text(const std::filesystem::path& path) {
  const FileDescriptor file = open_regular_file(path, Links::Follow);
  std::string text;
  std::string part(1U << 16U, '\0');
  while (true) {
    const ssize_t size = ::read(file.get(), part.data(), part.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) throw std::system_error(errno, std::generic_category());
    if (size == 0) return text;
    text.append(part, 0, static_cast<std::size_t>(size));
    if (text.size() > kLargestReport)
      throw ModelError(fmt::format("it is larger than {} MiB", kLargestReport >> 20U));
  }
}

// Returns a number of the report between these bounds.
double number(const Json& object, const char* key, double least, double most) {
  const double value = object.at(key).get<double>();
  // Negated, so that NaN is refused, too.
  if (!(value >= least && value <= most))
    throw ModelError(fmt::format("{} is {}, expected {} to {}", key, value, least, most));
  return value;
}

Nanometers height(const Json& object, const char* key) {
  constexpr double kHighest = 10'000;  // mm
  return to_nanometers(Millimeters{number(object, key, 0, kHighest)}).value_or(Nanometers{});
}

Duration exposure(const Json& object, const char* key) {
  constexpr double kLongest = 86'400'000;     // ms, a day
  constexpr double kNanoseconds = 1'000'000;  // in a millisecond
  return Duration{std::llround(number(object, key, 0, kLongest) * kNanoseconds)};
}

std::uint32_t whole_number(const Json& object, const char* key, std::uint32_t least, std::uint32_t most) {
  const double value = number(object, key, least, most);
  if (value != std::floor(value))
    throw ModelError(fmt::format("{} is {}, expected a whole number", key, value));
  return static_cast<std::uint32_t>(value);
}

std::vector<Exclusion> exclusions_of(const Json& report) {
  constexpr std::uint32_t kMostCopies = 1'000'000;
  const Json list = report.value("excluded", Json::array());
  if (!list.is_array()) throw ModelError("excluded is not a list of copies");
  std::vector<Exclusion> exclusions;
  std::set<std::size_t> numbers;
  for (const Json& each : list) {
    if (!each.is_object() || !each.contains("number") || !each.contains("from_layer"))
      throw ModelError("excluded has an entry without number and from_layer");
    Exclusion& exclusion = exclusions.emplace_back();
    exclusion.number = whole_number(each, "number", 1, kMostCopies) - 1;
    exclusion.layer = static_cast<std::int32_t>(whole_number(each, "from_layer", 1, kMostLayers) - 1);
    if (!numbers.insert(exclusion.number).second)
      throw ModelError(fmt::format("excluded has copy {} twice", exclusion.number + 1));
  }
  std::ranges::stable_sort(exclusions, {}, &Exclusion::layer);
  return exclusions;
}

RecordedPrint recorded_print(const Json& report) {
  RecordedPrint print;
  print.job = report.at("job").get<std::string>();
  print.outcome = report.at("outcome").get<std::string>();
  if (report.value("dry", false)) throw ModelError("it is that of a dry run, in which nothing cured");
  const Json& settings = report.at("settings");
  print.undersides =
      settings.at("undersides").get<std::string>() == "dose" ? Undersides::Dose : Undersides::Plain;
  print.unfound_undersides = report.at("unfound_undersides").get<std::int64_t>();
  print.exclusions = exclusions_of(report);
  for (const Json& layer : report.at("layer_records")) {
    LayerRecord& record = print.layers.emplace_back();
    record.layer = static_cast<std::int32_t>(number(layer, "layer", 1, kMostLayers)) - 1;
    record.plate_height = height(layer, "plate_height_mm");
    record.mask_height = height(layer, "mask_height_mm");
    record.exposure_least = exposure(layer, "exposure_least_ms");
    record.exposure_most = exposure(layer, "exposure_most_ms");
    record.dark_confirmed = layer.at("dark_confirmed").get<bool>();
    record.area_mm2 = number(layer, "area_mm2", 0, 1e9);
    record.rises = !layer.value("frames", Json()).is_null();
  }
  if (print.layers.empty()) throw ModelError("no layer was exposed");
  if (settings.contains("temperature"))
    print.temperature_factor = number(settings["temperature"], "light", 1e-3, 1e3);
  print.irradiance_mw_cm2 = number(settings, "irradiance_mw_cm2", 1e-6, 1e6);
  return print;
}

// Returns the path of the frames of a print with this report.
std::filesystem::path frames_beside(const std::filesystem::path& report) {
  constexpr std::string_view kReport = ".report.json";
  std::string name = report.filename().string();
  if (name.ends_with(kReport)) name.resize(name.size() - kReport.size());
  return report.parent_path() / (name + "." + FrameLogFile::kSuffix);
}

}  // namespace

RecordedPrint read_recorded_print(const std::filesystem::path& path) {
  try {
    RecordedPrint print = recorded_print(Json::parse(read_text(path)));
    print.frames = read_print_frames(print.layers, frames_beside(path));
    return print;
  } catch (const UnreadableFile& error) {
    throw UnreadableFile(error.code(),
                         fmt::format("cannot read {}: {}", printable(path.string()), error.what()));
  } catch (const Json::exception&) {
    throw ModelError(
        fmt::format("{} is not the report of a print; give the NAME.report.json of a finished job",
                    printable(path.string())));
  } catch (const std::exception& error) {
    throw ModelError(fmt::format("{} is not the report of a print that can be computed: {}",
                                 printable(path.string()), error.what()));
  }
}

PrintedLight light_of(const RecordedPrint& print, const CureSettings& cure) {
  constexpr std::size_t kMostSteps = 50'000;
  std::optional<PrintedLight> light =
      printed_light(print.layers, print.irradiance_mw_cm2, {print.frames.records, cure, kMostSteps});
  if (!light)
    throw ModelError(
        "the report's layers do not lie one upon another from the first one on, so its part cannot be "
        "computed");
  return *std::move(light);
}

}  // namespace contourd::ctl
