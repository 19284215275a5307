#include "daemon/prepare/resin_temperature.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {
namespace {

constexpr double kMostDifference_c = 20;
constexpr double kColdest_c = 0, kWarmest_c = 80;  // as in the schema

double read_sensor(const std::filesystem::path& sensor) {
  const FileDescriptor file = open_regular_file(sensor, Links::Follow);
  std::array<char, 32> text{};
  const ssize_t size = ::read(file.get(), text.data(), text.size());
  if (size < 0) throw std::system_error(errno, std::generic_category());
  long thousandths = 0;
  const char* const end = text.data() + size;
  const auto [rest, error] = std::from_chars(text.data(), end, thousandths);
  if (error != std::errc() || (rest != end && *rest != '\n'))
    throw std::runtime_error(fmt::format("it contains \"{}\", no whole number of thousandths of a degree",
                                         printable({text.data(), static_cast<std::size_t>(size)})));
  const double celsius = static_cast<double>(thousandths) / 1000;
  if (celsius < kColdest_c || celsius > kWarmest_c)
    throw std::runtime_error(
        fmt::format("its {:g} degrees C are outside {:g} to {:g}", celsius, kColdest_c, kWarmest_c));
  return celsius;
}

// Returns the first reason why an exposure of this profile is impossible; empty if there is none.
std::string impossible_exposure(const ResinProfile& resin, const JobSummary& summary) {
  for (const Nanometers thickness : {summary.layers.thinnest, summary.layers.thickest}) {
    const std::vector<std::string> problems =
        layer_height_problems(resin, thickness, summary.irradiance_mw_cm2);
    if (!problems.empty()) return problems.front();
  }
  return {};
}

// Makes the light that of the profile again.
void take_back(PreparedJob& job, const WorkingCurve& measured, double irradiance_mw_cm2) {
  JobSummary& summary = job.summary;
  if (!summary.temperature_warning.empty()) std::erase(summary.warnings, summary.temperature_warning);
  summary.temperature_warning.clear();
  summary.temperature.reset();
  summary.resin.cure->curve = measured;
  job.plan.exposure = exposure_by(summary.resin, irradiance_mw_cm2);
}

// Makes the exposures those for the resin's temperature.
void adjust_exposures(PreparedJob& job, const PrinterConfig& printer) {
  JobSummary& summary = job.summary;
  const WorkingCurve& measured = job.settings.resin.cure.value().curve;
  take_back(job, measured, printer.irradiance_mw_cm2);
  const double curve_c = summary.resin.cure_temperature->measured_at_c;
  const auto warn = [&](std::string sentence) {
    summary.temperature_warning = sentence;
    summary.warnings.push_back(std::move(sentence));
  };
  const auto keep_light = [&](const std::string& why) {
    warn(fmt::format("the light is that for resin of {:g} degrees C, and does not follow the temperature: {}",
                     curve_c, why));
  };
  try {
    const double resin_c = read_temperature(*printer.resin_temperature);
    const double followed_c = std::clamp(resin_c, curve_c - kMostDifference_c, curve_c + kMostDifference_c);
    ResinProfile adjusted = summary.resin;
    adjusted.cure->curve = at_temperature(measured, *adjusted.cure_temperature, followed_c);
    if (const std::string why = impossible_exposure(adjusted, summary); !why.empty()) return keep_light(why);
    if (followed_c != resin_c)
      warn(fmt::format(
          "the resin has {:.1f} degrees C, and its working curve was measured at {:g}: the light is that for "
          "{:g} degrees, since more than {:g} degrees of difference are not followed",
          resin_c, curve_c, followed_c, kMostDifference_c));
    summary.temperature =
        FollowedTemperature{resin_c, curve_c, adjusted.cure->curve.critical_dose / measured.critical_dose};
    summary.resin = std::move(adjusted);
    job.plan.exposure = exposure_by(summary.resin, printer.irradiance_mw_cm2);
  } catch (const std::runtime_error& error) {
    keep_light(error.what());
  }
}

}  // namespace

double read_temperature(const ResinTemperature& from) {
  if (const auto* const celsius = std::get_if<double>(&from)) return *celsius;
  const auto& sensor = std::get<std::filesystem::path>(from);
  try {
    return read_sensor(sensor);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("the sensor {}: {}", sensor.string(), error.what()));
  }
}

void follow_temperature(PreparedJob& job, const PrinterConfig& printer) {
  const JobSummary& summary = job.summary;
  if (!printer.resin_temperature || !summary.resin.cure_temperature ||
      !std::holds_alternative<CurveExposure>(summary.resin.exposure))
    return;
  adjust_exposures(job, printer);
  plan_rises_of(job, printer);
}

}  // namespace contourd
