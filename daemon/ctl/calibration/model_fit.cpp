// The figures that follow from calibration prints of a model: the memory at a peel, shrinkage and growth.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/calibration/dimension_fit.hpp"
#include "core/calibration/peel_memory_fit.hpp"
#include "daemon/config/calibration_record.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_plot.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct ModelFitArgs {
  FitArgs fit;
  std::string resin;
  std::vector<std::string> measured;
};

// Returns the uncertainty of the curve that the profile's last calibrations of it state; nullopt if either of
// its figures was set otherwise.
std::optional<CurveUncertainty> curve_uncertainty(const FitTarget& resin) {
  const std::string profile = read_text(resin.file);
  const auto depth = calibrated_error(profile, "/working_curve/penetration_depth_um");
  const auto energy = calibrated_error(profile, "/working_curve/critical_energy_mj_cm2");
  if (!depth || !energy) return std::nullopt;
  return CurveUncertainty{Micrometers{depth->uncertainty}, MillijoulesPerCm2{energy->uncertainty},
                          energy->correlation};
}

// Returns the sentence about the shares of a memory's uncertainty.
std::string describe_shares(const PeelMemoryFit& fit, const std::optional<CurveUncertainty>& curve) {
  if (!curve) return "the uncertainty of the resin's curve is not known, so that the memory's leaves it out";
  return fmt::format(
      "the memory's uncertainty of {:.2g} consists of {:.2g} by the scatter of the bridges, {:.2g} by "
      "penetration_depth_um +- {:.2g} and {:.2g} by critical_energy_mj_cm2 +- {:.2g}, whose errors are "
      "correlated by "
      "{:.2g}",
      fit.memory.uncertainty, fit.shares.scatter, std::abs(fit.shares.penetration_depth),
      curve->penetration_depth.count(), std::abs(fit.shares.critical_dose), curve->critical_dose.count(),
      curve->correlation);
}

// Returns a plot of how far bridges cured beyond their layers.
std::string plot_of(const BridgePrint& print, const std::vector<BridgeThickness>& bridges,
                    const Estimate& memory) {
  const double layer_um = in_mm(print.layer_height) * 1000;
  PlottedFit fit;
  int most = 1;
  for (const auto& [layers, thickness] : bridges) {
    fit.measured.push_back({1.0 * layers, thickness.count() - layers * layer_um});
    most = std::max(most, layers);
  }
  for (int layers = 1; layers <= most; ++layers) {
    const auto thickness = [&](double errors) {
      return bridge_thickness(print, std::clamp(memory.value + errors * memory.uncertainty, 0.0, 1.0), layers)
          .count();
    };
    fit.line.push_back({1.0 * layers, thickness(0) - layers * layer_um, (thickness(1) - thickness(-1)) / 2});
  }
  return svg_of_fit({"layers of the bridge", "depth beyond the layers, um", Scale::Linear, {fit}});
}

int peel_memory(const ModelFitArgs& args) {
  const PrinterConfig printer = load_printer_config(args.fit.printer, Places::Elsewhere);
  const ResinProfile resin = find_resin(printer, args.resin);
  const CureSettings& cure = cure_of(resin);
  const int normal_layer = resin.bottom_layers + resin.fade_layers;
  const std::chrono::duration<double> exposure =
      exposure_time(resin, resin.layer_height, normal_layer, printer.irradiance_mw_cm2);
  const BridgePrint print{cure, resin.layer_height,
                          MillijoulesPerCm2{exposure.count() * printer.irradiance_mw_cm2}};
  std::vector<BridgeThickness> bridges;
  for (const auto& [layers, thickness_um] : parse_measured(args.measured)) {
    if (layers != std::round(layers) || layers < 1 || layers > kMostBridgeLayers)
      throw UsageError(fmt::format("{:.10g}={:g}: a bridge has a whole number of layers, 1 to {}", layers,
                                   thickness_um, kMostBridgeLayers));
    // The bridge was thicker before the part shrank.
    bridges.push_back({static_cast<int>(layers), Micrometers{thickness_um * resin.shrinkage_factors.z}});
  }
  const FitTarget target = resin_target(printer, args.resin);
  const std::optional<CurveUncertainty> curve = curve_uncertainty(target);
  const PeelMemoryFit fit = fit_peel_memory(print, bridges, curve.value_or(CurveUncertainty{}),
                                            Micrometers{rounding_of(args.measured)});
  FitResult result{
      .kind = "memory",
      .values = {{"/working_curve/peel_memory", rounded(fit.memory.value), rounded(fit.memory.uncertainty)}},
      .given_heading = "layers",
      .scatter = fit.scatter_um};
  for (const auto& [layers, thickness] : bridges)
    result.points.push_back({{static_cast<double>(layers)},
                             thickness.count(),
                             bridge_thickness(print, fit.memory.value, layers).count()});
  result.notes.push_back(
      fmt::format("the underside of a thick part is uncertain by {:.2g} um, as far as these "
                  "measurements determine it",
                  fit.underside_um));
  result.notes.push_back(describe_shares(fit, curve));
  // The band by the bridges alone: an error of the curve moves the memory so that the depths stay.
  result.figure = plot_of(print, bridges, {fit.memory.value, fit.shares.scatter});
  return finish_fit(args.fit, target, result);
}

// Parses "x30" or "ygap9" and the measured length. Throws UsageError.
MeasuredLength parse_length(const std::string& word) {
  MeasuredLength length{.axis = word.starts_with('x') ? PlateAxis::X : PlateAxis::Y};
  std::string rest = word.starts_with('x') || word.starts_with('y') ? word.substr(1) : "";
  constexpr std::string_view kGap = "gap";
  if (rest.starts_with(kGap)) {
    length.kind = LengthKind::Inner;
    rest.erase(0, kGap.size());
  }
  try {
    const auto [drawn, measured] = parse_measured({rest}).front();
    length.drawn = Millimeters{drawn};
    length.measured = Millimeters{measured};
  } catch (const UsageError&) {
    throw UsageError(
        fmt::format("\"{}\" is not a measured length, as in x30=29.93 or ygap9=8.95", printable(word)));
  }
  return length;
}

// Returns a plot of how much longer than drawn the lengths are.
std::string plot_of(const std::vector<MeasuredLength>& lengths, const DimensionFit& fit) {
  FitPlot plot{"drawn, mm", "measured less drawn, um"};
  for (const PlateAxis axis : {PlateAxis::X, PlateAxis::Y})
    for (const LengthKind kind : {LengthKind::Outer, LengthKind::Inner}) {
      PlottedFit one{.name = fmt::format("{}{}", axis == PlateAxis::X ? "x" : "y",
                                         kind == LengthKind::Inner ? ", gaps" : "")};
      for (std::size_t i = 0; i < lengths.size(); ++i) {
        const MeasuredLength& length = lengths[i];
        if (length.axis != axis || length.kind != kind) continue;
        const double drawn = length.drawn.count();
        one.measured.push_back({drawn, (length.measured.count() - drawn) * 1000});
        const auto& [value, uncertainty] = fit.lengths_mm[i];
        one.line.push_back({drawn, (value - drawn) * 1000, uncertainty * 1000});
      }
      std::ranges::sort(one.line, {}, &PlottedPoint::x);
      if (!one.measured.empty()) plot.fits.push_back(std::move(one));
    }
  return svg_of_fit(plot);
}

int dimensions(const ModelFitArgs& args) {
  const PrinterConfig printer = load_printer_config(args.fit.printer, Places::Elsewhere);
  const ResinProfile resin = find_resin(printer, args.resin);
  const auto percent = [](double factor) { return 100 * (1 - 1 / factor); };
  std::vector<MeasuredLength> lengths;
  for (const std::string& word : args.measured)
    lengths.push_back(parse_length(word));
  const DimensionFit fit =
      fit_dimensions({percent(resin.shrinkage_factors.x), percent(resin.shrinkage_factors.y),
                      resin.compensation.growth.count()},
                     lengths, Millimeters{rounding_of(args.measured)});
  FitResult result{.kind = "dimensions", .scatter = fit.scatter_um};
  const auto add = [&result](const char* key, const std::optional<Estimate>& figure) {
    if (figure) result.values.push_back({key, rounded(figure->value), rounded(figure->uncertainty)});
  };
  add("/shrinkage_percent/x", fit.shrinkage_x_percent);
  add("/shrinkage_percent/y", fit.shrinkage_y_percent);
  add("/growth_um", fit.growth_um);
  result.notes.push_back(fmt::format("the lengths scatter by {:.3g} um about the fit", fit.scatter_um));
  result.notes.emplace_back(
      "the part was printed with the profile as it is now: these values replace its own");
  result.figure = plot_of(lengths, fit);
  return finish_fit(args.fit, resin_target(printer, args.resin), result);
}

}  // namespace

void add_fit_models(Command& fit) {
  const auto add = [&fit](const char* name, const char* help, const char* measured_help,
                          int (*run)(const ModelFitArgs&)) {
    Command& command = fit.add(name, help);
    auto& args = command.arguments<ModelFitArgs>();
    command.option("RESIN", args.resin, "Resin profile").required();
    command.option("MEASURED", args.measured, measured_help).required();
    add_fit_options(command, args.fit);
    command.run = [&args, run] { return run(args); };
  };
  add("memory", "Compute how much of its light the resin remembers at a peel",
      "Layers and measured thickness of a bridge, um: 8=620", peel_memory);
  add("dimensions", "Compute the resin's shrinkage and growth from measured lengths",
      "Axis, drawn and measured length, mm: x30=29.93, or ygap9=8.95 for a gap", dimensions);
}

}  // namespace contourd::ctl
