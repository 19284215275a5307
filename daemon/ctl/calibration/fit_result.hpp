// Figures that were computed from measurements: how they are printed, and written into a resin profile or the
// printer's configuration. Blocks. Not thread-safe.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/fitted_figures.hpp"
#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Arguments of each command of `fit`.
struct FitArgs {
  std::filesystem::path printer;
  std::optional<double> lamp_hours;
  std::optional<std::filesystem::path> html;  // page to write
  bool accept = false, json = false;
};
// Adds the options.
void add_fit_options(Command& command, FitArgs& args);

// Temperatures of resin that a profile may name, in degrees C, as in its schema.
constexpr Limits<double> kResinTemperatures_c{0, 80};
// Checks the number of an option, if it was given. Throws UsageError.
void check_option(std::string_view option, const std::optional<double>& number, const Limits<double>& limits);

// Parses "10=85": what was made or drawn, and what was measured. Throws UsageError for any other text.
[[nodiscard]] std::vector<std::pair<double, double>> parse_measured(const std::vector<std::string>& words);
// Returns the standard uncertainty of what was measured by the rounding of its last digit: that of the number
// with the most decimals, because closing zeros are not typed. The words are those of parse_measured().
[[nodiscard]] double rounding_of(const std::vector<std::string>& words);

// Rounds to four significant digits, as a figure is written into a file.
[[nodiscard]] double rounded(double number);

// Returns the resin's curve and memory. Throws CalibrationRefused if its profile has no working_curve.
[[nodiscard]] const CureSettings& cure_of(const ResinProfile& resin);

// A file that gets the figures, and the check of its new text, which throws ConfigError.
struct FitTarget {
  std::filesystem::path file;
  std::function<void(std::string_view text)> check;
};
// Return the resin profile of that name, and the printer's configuration. Throw ConfigError.
[[nodiscard]] FitTarget resin_target(const PrinterConfig& printer, const std::string& resin);
[[nodiscard]] FitTarget printer_target(const std::filesystem::path& printer);

// Prints the result and, with --accept, writes its values into the file. Returns the exit code. Throws
// ConfigError if the file with the values would be invalid; then it is unchanged, and the result is not
// printed unless it names a new file.
int finish_fit(const FitArgs& args, const FitTarget& target, const FitResult& result);
// Takes back the last calibration in the file. Returns the exit code.
int undo_fit(const FitTarget& target);

}  // namespace contourd::ctl
