#include "daemon/ctl/calibration/fit_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "core/calibration/line_fit.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/ctl/calibration/fit_page.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

void print_points(const FitResult& result) {
  const auto heading = [&result](const char* name) { return with_unit(name, result.unit, " "); };
  fmt::print("\n{:>14} {:>12} {:>10} {:>13}\n", result.given_heading, heading("measured"), heading("fitted"),
             heading("difference"));
  for (const auto& [given, measured, fitted] : result.points)
    fmt::print("{:>14} {:>12.5g} {:>10.4g} {:>13.2g}\n", fmt::format("{:.5g}", fmt::join(given, ", ")),
               measured, fitted, result.without_noise(measured - fitted));
  fmt::print("scatter about the fit: {}\n",
             with_unit(fmt::format("{:.3g}", result.without_noise(result.scatter)), result.unit, " "));
}

void print_result(const FitResult& result, const Json& before) {
  for (const CalibratedValue& each : result.values)
    fmt::print("{:<40} {:>10}{}   now {}\n", each.key.substr(1),
               each.value.is_null() ? "removed" : each.value.dump(),
               each.uncertainty ? fmt::format(" +- {:<8.3g}", *each.uncertainty) : std::string(12, ' '),
               present_value(before, each.key));
  if (!result.points.empty()) print_points(result);
  for (const std::string& note : result.notes)
    fmt::print("note: {}\n", note);
}

Json json_of(const FitResult& result, bool written) {
  Json json{{"kind", result.kind}, {"values", Json::array()}, {"points", Json::array()}};
  for (const auto& [key, value, uncertainty, correlation] : result.values) {
    Json one{{"key", key}, {"value", value}};
    if (uncertainty) one["uncertainty"] = *uncertainty;
    if (correlation) one["correlation"] = *correlation;
    json["values"].push_back(std::move(one));
  }
  const auto named = [&result](const char* name) { return with_unit(name, result.unit, "_"); };
  for (const auto& [given, measured, fitted] : result.points)
    json["points"].push_back({{"given", given.size() == 1 ? Json(given.front()) : Json(given)},
                              {named("measured"), measured},
                              {named("fitted"), fitted}});
  json[named("scatter")] = result.scatter;
  json["notes"] = result.notes;
  json["written"] = written;
  return json;
}

// Writes the values into the file, and the file that they name. Throws std::system_error, and ConfigError
// if the text is invalid; then nothing has changed.
void write_result(const FitTarget& target, const std::string& text, const std::optional<NamedFile>& named) {
  const bool is_new = named && !fs::exists(named->file);
  if (is_new) write_beside(target.file, named->file, named->content);
  try {
    target.check(text);
    replace_file(target.file, text);
  } catch (...) {
    std::error_code ignored;
    if (is_new) fs::remove(named->file, ignored);
    throw;
  }
}

// Writes the page, but not over a file that the fit reads or changes.
void write_page(const FitArgs& args, const std::string& page, const FitTarget& target) {
  std::error_code ignored;  // a file that does not exist is none of them
  for (const fs::path& file : {args.printer, target.file})
    if (fs::equivalent(*args.html, file, ignored))
      throw UsageError(
          fmt::format("--html {}: this file is a configuration", printable(args.html->string())));
  write_text(*args.html, page);
}

}  // namespace

double FitResult::without_noise(double difference) const {
  double most = 0;
  for (const FittedPoint& point : points)
    most = std::max(most, std::abs(point.measured));
  if (most <= 0) return difference;
  const double least = std::pow(10, std::floor(std::log10(most)) - 4);
  return std::round(difference / least) * least + 0.0;  // no negative zero
}

void add_fit_options(Command& command, FitArgs& args) {
  args.printer = kDefaultConfig;
  command.option("--printer", args.printer, "Configuration of the printer");
  command.option("--lamp-hours", args.lamp_hours, "Hours of the lamp, to be kept with the result");
  command.option("--accept", args.accept, "Write the result");
  command.option("--html", args.html, "Write a page with a plot");
  command.option("--json", args.json, "Print JSON");
}

void check_option(std::string_view option, const std::optional<double>& number,
                  const Limits<double>& limits) {
  if (number && !limits.contain(*number))
    throw UsageError(fmt::format("{}: {:g} is not a number from {:g} to {:g}", option, *number, limits.least,
                                 limits.most));
}

std::vector<std::pair<double, double>> parse_measured(const std::vector<std::string>& words) {
  std::vector<std::pair<double, double>> pairs;
  for (const std::string& word : words) {
    const std::size_t middle = std::min(word.find('='), word.size());
    const auto given = number_of(word.substr(0, middle));
    const auto measured = number_of(word.substr(std::min(middle + 1, word.size())));
    if (!given || !measured)
      throw UsageError(
          fmt::format("\"{}\" is not a measurement, two numbers as in 37.5=210", printable(word)));
    pairs.emplace_back(*given, *measured);
  }
  return pairs;
}

double rounding_of(const std::vector<std::string>& words) {
  double finest = std::numeric_limits<double>::infinity();
  for (const std::string& word : words) {
    const std::string number = word.substr(word.find('=') + 1);
    const std::size_t mantissa = std::min(number.find_first_of("eE"), number.size());
    const std::size_t point = std::min(number.find('.'), mantissa);
    const std::size_t decimals = point < mantissa ? mantissa - point - 1 : 0;
    const double exponent = mantissa < number.size() ? number_of(number.substr(mantissa + 1)).value_or(0) : 0;
    finest = std::min(finest, std::pow(10, exponent - static_cast<double>(decimals)));
  }
  return finest / std::sqrt(12);  // a uniform distribution
}

double rounded(double number) {
  if (number == 0 || !std::isfinite(number)) return number;
  const double unit = std::pow(10, 3 - std::floor(std::log10(std::abs(number))));
  return std::round(number * unit) / unit;
}

const CureSettings& cure_of(const ResinProfile& resin) {
  if (resin.cure) return *resin.cure;
  throw CalibrationRefused(
      fmt::format("{0} has no working_curve, on which the thickness of cured resin depends: calibrate the "
                  "curve first (contourctl calibrate curve {0})",
                  printable(resin.name)));
}

FitTarget resin_target(const PrinterConfig& printer, const std::string& resin) {
  (void)find_resin(printer, resin);  // names the profile's mistakes, or the existing profiles
  return {profile_file(printer.resins_folder, resin).value(),
          [file = *profile_file(printer.resins_folder, resin), machine = resin_machine(printer)](
              std::string_view text) { (void)read_resin_profile(text, file, machine); }};
}

FitTarget printer_target(const fs::path& printer) {
  return {printer,
          [printer](std::string_view text) { (void)read_printer_config(text, printer, Places::Elsewhere); }};
}

int finish_fit(const FitArgs& args, const FitTarget& target, const FitResult& result) {
  check_option("--lamp-hours", args.lamp_hours, {0, 1'000'000});
  const std::string before = read_text(target.file);
  const Calibration calibration{.kind = result.kind,
                                .date = local_time(std::chrono::system_clock::now()).substr(0, 10),
                                .lamp_hours = args.lamp_hours,
                                .values = result.values};
  const std::string after = with_calibration(before, calibration);
  if (!result.named) target.check(after);  // a new file is not there yet
  const Json file = Json::parse(before);
  if (!args.json) print_result(result, file);
  if (args.html) write_page(args, fit_page(result, target.file.string(), file), target);
  if (args.accept) write_result(target, after, result.named);
  if (args.json)
    print_json(json_of(result, args.accept));
  else if (args.accept)
    fmt::print("Written to {}; contourctl fit undo takes it back.\n", printable(target.file.string()));
  else
    fmt::print("Nothing was written: --accept writes these values to {}.\n", printable(target.file.string()));
  return kOk;
}

int undo_fit(const FitTarget& target) {
  const std::string text = read_text(target.file);
  UndoneCalibration undone;
  try {
    undone = without_last_calibration(text);
  } catch (const std::runtime_error& error) {
    throw CalibrationRefused(fmt::format("{}: {}", target.file.string(), error.what()));
  }
  target.check(undone.text);
  replace_file(target.file, undone.text);
  fmt::print("{}: the calibration {} of {} was taken back.\n", printable(target.file.string()),
             printable(undone.kind), printable(undone.date));
  return kOk;
}

}  // namespace contourd::ctl
