// The calibrations that cure windows on the bare film: the resin's working curve and the projector's gamma.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/calibration/calibration_windows.hpp"
#include "core/calibration/curve_fit.hpp"
#include "core/mask/exposure_correction.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_plot.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"
#include "daemon/ctl/calibration/light_by_hand.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr double kSpan =
    16;  // between the windows' doses: Dp within 4 um and Ec within 6 % at 10 um of noise
// Grey values whose light cures with any gamma up to 3, in nearly equal steps of their logarithm.
constexpr std::array<std::uint8_t, kMostWindows> kGreys{255, 230, 207, 186, 168, 151, 136, 122, 110};
constexpr std::size_t kIndent = 3;  // after the number of a step

struct WindowArgs {
  std::string resin;
  std::filesystem::path printer = kDefaultConfig;
  std::optional<double> seconds;
  bool confirm = false, in_resin = false;
};

// Exposes windows on the bare film by manual control.
class WindowPrint {
 public:
  WindowPrint(const ClientOptions& client, const WindowArgs& args)
      : client_(client),
        args_(args),
        printer_(load_printer_config(args.printer, Places::Elsewhere)),
        resin_(find_resin(printer_, args.resin)) {}

  // Exposes one window after the other, each longer than the one before.
  int print_curve() {
    const double first_s = args_.seconds.value_or(std::min(normal_exposure_s(), longest_s() / kSpan));
    std::array<double, kMostWindows> times_s{};
    for (std::size_t i = 0; i < kMostWindows; ++i)
      times_s[i] = first_s * std::pow(kSpan, static_cast<double>(i) / (kMostWindows - 1));
    check_longest(times_s.back());
    double sum_s = 0;
    for (const double each_s : times_s)
      sum_s += each_s;
    if (const int code = prepare(sum_s); code != kOk) return code;
    for (std::size_t i = 0; i < kMostWindows; ++i) {
      std::array<std::uint8_t, kMostWindows> greys{};
      greys[i] = 255;
      fmt::print("window {} of {}: {:.3g} s\n", i + 1, kMostWindows, times_s[i]);
      std::fflush(stdout);
      if (const int code = shine(client_, evened(greys), {times_s[i], args_.in_resin}); code != kOk)
        return code;
    }
    std::vector<double> doses;
    for (const double each_s : times_s)
      doses.push_back(each_s * printer_.irradiance_mw_cm2);
    // Without it, the fit would remove the temperature of the previous curve.
    explain("curve", "dose mJ/cm²", doses, resin_.cure_temperature ? " --temperature-c ?" : "");
    return kOk;
  }

  // Exposes all windows at once, each with its grey value.
  int print_greys() {
    const double time_s = args_.seconds.value_or(std::min(normal_exposure_s() * kSpan, longest_s()));
    check_longest(time_s);
    (void)cure_of(resin_);  // without a curve, nothing follows from the windows
    if (const int code = prepare(time_s); code != kOk) return code;
    fmt::print("all windows: {:.3g} s\n", time_s);
    std::fflush(stdout);
    if (const int code = shine(client_, drawn(kGreys), {time_s, args_.in_resin}); code != kOk) return code;
    explain("grey", "grey", {kGreys.begin(), kGreys.end()});
    return kOk;
  }

 private:
  [[nodiscard]] double longest_s() const {
    return std::chrono::duration<double>(printer_.manual.light_limit).count();
  }
  [[nodiscard]] double normal_exposure_s() const {
    const int normal_layer = resin_.bottom_layers + resin_.fade_layers;
    return std::chrono::duration<double>(
               exposure_time(resin_, resin_.layer_height, normal_layer, printer_.irradiance_mw_cm2))
        .count();
  }

  void check_longest(double seconds) const {
    if (seconds > 0 && seconds <= longest_s()) return;
    throw UsageError(
        fmt::format("the longest exposure would be {:.4g} s, and manual.light_limit_s allows more than 0 and "
                    "at most {:g} s: choose --seconds accordingly",
                    seconds, longest_s()));
  }

  int prepare(double sum_s) {
    if (!args_.confirm) {
      Dialog dialog;
      try {
        dialog.say("q quits at any question; Ctrl-C also turns the light off.");
        dialog.say("1. Take the build plate off, or raise it out of the resin.", kIndent);
        dialog.say("2. Pour at least 3 mm of resin into a clean vat, without bubbles.", kIndent);
        (void)dialog.ask(fmt::format(
            "The UV light will shine for {:.3g} s in all. Eyes protected? Press Enter to begin.", sum_s));
      } catch (const DialogLeft&) {
        fmt::print("\nNothing was exposed.\n");
        return kFailed;
      }
    }
    return warm_up(client_);
  }

  [[nodiscard]] Mask drawn(const std::array<std::uint8_t, kMostWindows>& greys) const {
    return draw_calibration_windows(greys, printer_.display_width, printer_.display_height,
                                    printer_.pixel_pitch);
  }
  // Returns the windows as a print would show them: with the uniformity mask.
  [[nodiscard]] Mask evened(const std::array<std::uint8_t, kMostWindows>& greys) const {
    Mask sent(printer_.display_width, printer_.display_height);
    ExposureCorrection(printer_.tone, printer_.uniformity).apply(drawn(greys), sent);
    return sent;
  }

  void explain(const char* kind, const char* heading, const std::vector<double>& given,
               std::string_view temperature = "") const {
    fmt::print("\nThe windows lie in rows of three; each has as many dots as its number.\n\n{:>6} {:>12}\n",
               "window", heading);
    std::string values;
    for (std::size_t i = 0; i < given.size(); ++i) {
      fmt::print("{:>6} {:>12.4g}\n", i + 1, given[i]);
      values += fmt::format(" {:.4g}=?", given[i]);
    }
    fmt::print("\n");
    const Dialog dialog;
    dialog.say(
        "Wait a minute, pour the resin off, peel the windows off the film and wipe them; do not wash "
        "or cure them. Measure the thickness of each with a micrometer that presses little, three "
        "times. Then type the mean in um instead of each question mark, and leave out windows that "
        "did not cure or tore:");
    if (!temperature.empty())
      dialog.say(
          "Type the temperature of the resin during the exposure after --temperature-c, in degrees C.");
    fmt::print("\ncontourctl fit {} {}{}{} --printer {}\n", kind, printable(args_.resin), values, temperature,
               printable(args_.printer.string()));
  }

  const ClientOptions& client_;
  const WindowArgs& args_;
  PrinterConfig printer_;
  ResinProfile resin_;
};

struct FitWindowsArgs {
  FitArgs fit;
  std::string resin;
  std::vector<std::string> measured;
  std::optional<double> temperature_c;  // the resin's; only for the curve
};

// Returns the cure depth beyond a layer of the profile's height that this exposure gives by the curve.
double overcure_um(const ResinProfile& resin, const CurveFit& curve, Duration exposure,
                   double irradiance_mw_cm2) {
  const double dose = std::chrono::duration<double>(exposure).count() * irradiance_mw_cm2;
  const double depth = curve.thickness_of(MillijoulesPerCm2{dose}).count();
  const double layer = in_mm(resin.layer_height) * 1000;
  if (depth < layer)
    throw CalibrationRefused(fmt::format(
        "with this curve the profile's exposure of {:.4g} ms cures {:.4g} um, less than a layer of {:.4g} "
        "um: "
        "check the measurements and projector.irradiance_mw_cm2, or set exposures that cure a layer first",
        milliseconds(exposure), depth, layer));
  return rounded(depth - layer);
}

// Adds the values that turn a profile of fixed exposures into one of the curve with the same exposures, and
// the sentences about what changes.
void keep_exposures(const ResinProfile& resin, const PrinterConfig& printer, const CurveFit& curve,
                    FitResult& result) {
  const auto add = [&result](const char* key, nlohmann::ordered_json value) {
    result.values.push_back({key, std::move(value)});
  };
  if (const auto* fixed = std::get_if<FixedExposure>(&resin.exposure)) {
    const double irradiance = printer.irradiance_mw_cm2;
    add("/working_curve/overcure_um", overcure_um(resin, curve, fixed->exposure, irradiance));
    add("/working_curve/bottom_overcure_um", overcure_um(resin, curve, fixed->bottom_exposure, irradiance));
    add("/exposure_ms", nullptr);
    add("/bottom_exposure_ms", nullptr);
    result.notes.emplace_back(
        "the exposures follow from the curve now; those of a layer of the profile's "
        "height stay as they are");
    return;
  }
  ResinProfile changed = resin;
  changed.cure->curve = {Micrometers{curve.penetration_depth_um.value},
                         MillijoulesPerCm2{curve.critical_dose_mj_cm2.value}};
  for (const std::string& problem :
       layer_height_problems(changed, resin.layer_height, printer.irradiance_mw_cm2))
    throw CalibrationRefused(fmt::format("with this curve, {}", problem));
  const int normal_layer = resin.bottom_layers + resin.fade_layers;
  const auto exposure = [&](const ResinProfile& of) {
    return milliseconds(exposure_time(of, of.layer_height, normal_layer, printer.irradiance_mw_cm2));
  };
  result.notes.push_back(fmt::format("the exposure of a normal layer changes from {:.4g} to {:.4g} ms",
                                     exposure(resin), exposure(changed)));
  if (resin.peel_memory_measured) {
    add("/working_curve/peel_memory", nullptr);
    result.notes.emplace_back(
        "peel_memory was measured with the previous curve and is removed: measure it again (contourctl "
        "calibrate memory); until then, undersides are exposed plainly");
  }
}

// Adds the values that belong to a curve that was measured at an irradiance, and removes those of a curve by
// the resin's ingredients.
void measure_at(MilliwattsPerCm2 irradiance, const ResinProfile& resin, FitResult& result) {
  if (!resin.curve_measured)
    for (const char* key : {"absorptivity_l_mol_cm", "initiator_mmol_l", "gel_dose_mj_cm2"})
      result.values.push_back({fmt::format("/working_curve/{}", key), nullptr});
  if (!resin.cure_irradiance) return;
  result.values.push_back({"/working_curve/irradiance_mw_cm2", irradiance.count()});
  // The dead zone was measured at the irradiance of the previous curve.
  if (resin.cure->dead_zone.count() > 0)
    result.values.push_back({"/working_curve/dead_zone_um", rounded(resin.cure->dead_zone.count())});
}

// Returns places from one value to another, in equal steps of their logarithm.
std::vector<double> places_between(double least, double most) {
  constexpr int kSteps = 40;
  std::vector<double> places;
  for (int i = 0; i <= kSteps; ++i)
    places.push_back(least * std::pow(most / least, 1.0 * i / kSteps));
  return places;
}

std::string plot_of(const CurveFit& curve, const std::vector<CuredWindow>& windows) {
  PlottedFit fit;
  for (const auto& [dose, thickness] : windows)
    fit.measured.push_back({dose.count(), thickness.count()});
  const auto [least, most] = std::ranges::minmax(fit.measured, {}, &PlottedPoint::x);
  for (const double dose : places_between(least.x, most.x))
    fit.line.push_back({dose, curve.line.at(std::log(dose)), curve.line.uncertainty_at(std::log(dose))});
  return svg_of_fit({"dose, mJ/cm²", "thickness, um", Scale::Logarithmic, {fit}});
}

std::string plot_of(const GammaFit& gamma, const std::vector<GreyWindow>& windows,
                    double penetration_depth_um) {
  // The light over that of white, whose thickness is the line's.
  const auto light_of = [&](Micrometers thickness) {
    return std::exp((thickness.count() - gamma.line.at(0)) / penetration_depth_um);
  };
  PlottedFit fit;
  for (const auto& [grey, thickness] : windows)
    fit.measured.push_back({1.0 * grey, light_of(thickness)});
  const double least = std::ranges::min(fit.measured, {}, &PlottedPoint::x).x;
  for (const double grey : places_between(least, 255)) {
    const double light = std::pow(grey / 255, gamma.gamma.value);
    fit.line.push_back({grey, light, light * std::abs(std::log(grey / 255)) * gamma.gamma.uncertainty});
  }
  return svg_of_fit({"grey value", "light, white's is 1", Scale::Linear, {fit}});
}

int fit_curve(const FitWindowsArgs& args) {
  check_option("--temperature-c", args.temperature_c, kResinTemperatures_c);
  const PrinterConfig printer = load_printer_config(args.fit.printer, Places::Elsewhere);
  const FitTarget target = resin_target(printer, args.resin);
  std::vector<CuredWindow> windows;
  for (const auto& [dose, thickness] : parse_measured(args.measured))
    windows.push_back({MillijoulesPerCm2{dose}, Micrometers{thickness}});
  const CurveFit curve = fit_working_curve(windows, Micrometers{rounding_of(args.measured)});
  const Estimate &depth = curve.penetration_depth_um, &critical = curve.critical_dose_mj_cm2;
  FitResult result{
      .kind = "curve",
      .values = {{"/working_curve/penetration_depth_um", rounded(depth.value), rounded(depth.uncertainty)},
                 {"/working_curve/critical_energy_mj_cm2", rounded(critical.value),
                  rounded(critical.uncertainty), rounded(curve.correlation)}},
      .given_heading = "dose mJ/cm²",
      .scatter = curve.line.scatter};
  const ResinProfile resin = find_resin(printer, args.resin);
  if (args.temperature_c) {
    result.values.push_back({"/working_curve/temperature_c", *args.temperature_c});
  } else if (resin.cure_temperature) {
    result.values.push_back({"/working_curve/temperature_c", nullptr});
    result.notes.emplace_back(
        "temperature_c is that of the previous curve and is removed, so that exposures do not follow the "
        "temperature: give --temperature-c to keep that");
  }
  measure_at(MilliwattsPerCm2{printer.irradiance_mw_cm2}, resin, result);
  keep_exposures(resin, printer, curve, result);
  for (const auto& [dose, thickness] : windows)
    result.points.push_back({{dose.count()}, thickness.count(), curve.thickness_of(dose).count()});
  result.figure = plot_of(curve, windows);
  return finish_fit(args.fit, target, result);
}

int fit_grey(const FitWindowsArgs& args) {
  const PrinterConfig printer = load_printer_config(args.fit.printer, Places::Elsewhere);
  const ResinProfile resin = find_resin(printer, args.resin);
  const WorkingCurve curve = cure_of(resin).curve;
  FitResult result{.kind = "grey", .given_heading = "grey"};
  const std::optional<CalibratedError> known = calibrated_error(
      read_text(resin_target(printer, args.resin).file), "/working_curve/penetration_depth_um");
  if (!known)
    result.notes.emplace_back(
        "the uncertainty of the resin's penetration depth is not known, so that gamma's leaves it out");
  const Estimate depth{curve.penetration_depth.count(), known ? known->uncertainty : 0};
  std::vector<GreyWindow> windows;
  for (const auto& [grey, thickness] : parse_measured(args.measured)) {
    if (grey != std::round(grey) || grey < 0 || grey > 255)
      throw UsageError(fmt::format("{:g} is not a grey value, a whole number from 0 to 255", grey));
    windows.push_back({static_cast<std::uint8_t>(grey), Micrometers{thickness}});
  }
  const GammaFit fit = fit_gamma(windows, depth, Micrometers{rounding_of(args.measured)});
  result.values.push_back({"/display/gamma", rounded(fit.gamma.value), rounded(fit.gamma.uncertainty)});
  // By cured resin, gamma contains the resin's answer to faint light.
  if (printer.gamma_of_light) result.values.push_back({"/display/gamma_of", nullptr});
  result.scatter = fit.line.scatter;
  for (const auto& [grey, thickness] : windows)
    result.points.push_back({{static_cast<double>(grey)}, thickness.count(), fit.thickness_of(grey).count()});
  result.figure = plot_of(fit, windows, depth.value);
  return finish_fit(args.fit, printer_target(args.fit.printer), result);
}

void add_window_print(Command& calibrate, const char* name, const char* help, const char* seconds_help,
                      int (WindowPrint::*print)()) {
  Command& command = calibrate.add(name, help);
  auto& args = command.arguments<WindowArgs>();
  command.option("RESIN", args.resin, "Resin profile").required();
  command.option("--printer", args.printer, "Configuration of the printer");
  command.option("--seconds", args.seconds, seconds_help);
  command.option("--confirm", args.confirm,
                 "Confirm that plate and vat are prepared and eyes are protected, without being asked");
  command.option("--in-resin", args.in_resin, "Allow light while the plate may be in the resin");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &args, print] { return (WindowPrint(client, args).*print)(); };
}

FitWindowsArgs& add_window_fit(Command& fit, const char* name, const char* help, const char* measured_help,
                               int (*run)(const FitWindowsArgs&)) {
  Command& command = fit.add(name, help);
  auto& args = command.arguments<FitWindowsArgs>();
  command.option("RESIN", args.resin, "Resin profile").required();
  command.option("MEASURED", args.measured, measured_help).required();
  add_fit_options(command, args.fit);
  command.run = [&args, run] { return run(args); };
  return args;
}

}  // namespace

void add_calibrate_windows(Command& calibrate) {
  add_window_print(calibrate, "curve",
                   "Cure nine windows on the bare film, each with more light, for the resin's working curve",
                   "Exposure of the first window, s (default: that of a normal layer, at most a sixteenth of "
                   "manual.light_limit_s)",
                   &WindowPrint::print_curve);
  add_window_print(calibrate, "grey",
                   "Cure nine windows of different grey values on the bare film, for the projector's gamma",
                   "Exposure, s (default: 16 times that of a normal layer, at most manual.light_limit_s)",
                   &WindowPrint::print_greys);
}

void add_fit_windows(Command& fit) {
  FitWindowsArgs& curve =
      add_window_fit(fit, "curve", "Compute a resin's working curve from the thickness of windows",
                     "Dose and measured thickness of a window, mJ/cm² and um: 37.5=210", fit_curve);
  fit.commands.back().option(
      "--temperature-c", curve.temperature_c,
      "Temperature of the resin during the exposure, °C; exposures can follow it then");
  (void)add_window_fit(fit, "grey", "Compute the projector's gamma from the thickness of windows",
                       "Grey value and measured thickness of a window in um: 240=350", fit_grey);
}

}  // namespace contourd::ctl
