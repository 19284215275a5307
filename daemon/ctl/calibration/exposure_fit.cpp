// The exposure that follows from the tower of exposures: the step that a person found to be the best.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/line_fit.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct ExposureFitArgs {
  FitArgs fit;
  std::string resin;
  int step = 0;
  std::filesystem::path ticket;
  std::optional<double> temperature_c;  // of the resin during the print
};

// Returns the tower's exposures in ms, falling, from the ticket that it was printed with. Throws UsageError.
std::vector<double> tower_exposures(const ExposureFitArgs& args, const ResinProfile& resin) {
  const std::string name = printable(args.ticket.string());
  const JobTicket ticket = load_job_ticket(args.ticket);
  if (ticket.layer_height && *ticket.layer_height != resin.layer_height)
    throw UsageError(
        fmt::format("{} sets a layer height of its own: the tower's exposures would be written for that of "
                    "the profile; print a tower with the layer height of the profile",
                    name));
  if (ticket.resin && *ticket.resin != args.resin)
    throw UsageError(fmt::format("{} is the ticket of a tower of the resin {}, not of {}", name,
                                 printable(*ticket.resin), printable(args.resin)));
  std::vector<double> exposures;
  for (const ExposureStep& step : ticket.overrides.exposure_steps)
    exposures.push_back(milliseconds(step.exposure));
  if (exposures.size() < 2 || !std::ranges::is_sorted(exposures, std::greater{}))
    throw UsageError(
        fmt::format("{} is not the ticket that contourctl calibrate exposure wrote: it has no "
                    "falling exposure_steps",
                    name));
  if (args.step < 1 || static_cast<std::size_t>(args.step) > exposures.size())
    throw UsageError(fmt::format("{} is not a step of the tower, 1 to {}", args.step, exposures.size()));
  return exposures;
}

// The best step's exposure. The shortest exposure that is right lies between it and the next shorter one, so
// that its uncertainty is that of a uniform distribution; beside the last step, of one as wide as the step
// before.
struct BestStep {
  double exposure_ms;
  double ratio;  // of the exposure to the next shorter one

  // Returns the standard uncertainty of the exposure's logarithm.
  [[nodiscard]] double log_uncertainty() const { return std::log(ratio) / std::sqrt(12); }
};

BestStep best_step(const std::vector<double>& exposures, int step) {
  const auto at = static_cast<std::size_t>(step - 1);
  const std::size_t longer = std::min(at, exposures.size() - 2);
  return {exposures[at], exposures[longer] / exposures[longer + 1]};
}

// Returns the curve at the temperature of the print, and adds a note about it.
WorkingCurve curve_of_print(const ExposureFitArgs& args, const ResinProfile& resin, FitResult& result) {
  const WorkingCurve& curve = cure_of(resin).curve;
  if (args.temperature_c && !resin.cure_temperature)
    throw UsageError(
        fmt::format("--temperature-c: the working_curve of {} has no temperature_c to compare with",
                    printable(args.resin)));
  if (!resin.cure_temperature) return curve;
  if (args.temperature_c) return at_temperature(curve, *resin.cure_temperature, *args.temperature_c);
  result.notes.push_back(fmt::format(
      "the resin is taken to have had {:g} degrees C, at which its curve was measured: give --temperature-c "
      "if it had another temperature",
      resin.cure_temperature->measured_at_c));
  return curve;
}

CalibratedValue overcure_of(const ExposureFitArgs& args, const ResinProfile& resin,
                            const PrinterConfig& printer, const BestStep& best, FitResult& result) {
  const WorkingCurve curve = curve_of_print(args, resin, result);
  const MillijoulesPerCm2 dose{best.exposure_ms / 1000 * printer.irradiance_mw_cm2};
  const double depth_um = curve.depth_of(dose).count(), layer_um = in_mm(resin.layer_height) * 1000;
  if (depth_um < layer_um)
    throw CalibrationRefused(fmt::format(
        "by its working_curve, {} cures {:.4g} um in the {:g} ms of step {}, less than a layer of "
        "{:g} um: calibrate the curve again",
        printable(args.resin), depth_um, best.exposure_ms, args.step, layer_um));
  const double bottom_um = std::get<CurveExposure>(resin.exposure).bottom_overcure.count();
  if (depth_um - layer_um > bottom_um)
    throw CalibrationRefused(fmt::format(
        "step {} cures {:.4g} um more than a layer, and bottom layers, which may not get less, only "
        "{:g}: raise bottom_overcure_um of {} first",
        args.step, depth_um - layer_um, bottom_um, printable(args.resin)));
  return {"/working_curve/overcure_um", std::min(rounded(depth_um - layer_um), bottom_um),
          rounded(curve.penetration_depth.count() * best.log_uncertainty())};
}

int fit_exposure(const ExposureFitArgs& args) {
  check_option("--temperature-c", args.temperature_c, kResinTemperatures_c);
  const PrinterConfig printer = load_printer_config(args.fit.printer, Places::Elsewhere);
  const ResinProfile resin = find_resin(printer, args.resin);
  const std::vector<double> exposures = tower_exposures(args, resin);
  const BestStep best = best_step(exposures, args.step);
  FitResult result{.kind = "exposure"};
  if (resin.cure) {
    result.values.push_back(overcure_of(args, resin, printer, best, result));
  } else {
    if (args.temperature_c)
      throw UsageError(fmt::format("--temperature-c: {} has fixed exposures, which follow no temperature",
                                   printable(args.resin)));
    const double bottom_ms = milliseconds(std::get<FixedExposure>(resin.exposure).bottom_exposure);
    if (best.exposure_ms > bottom_ms)
      throw CalibrationRefused(
          fmt::format("step {} got {:g} ms, and bottom layers, which may not get less, get {:g}: raise "
                      "bottom_exposure_ms of {} first",
                      args.step, best.exposure_ms, bottom_ms, printable(args.resin)));
    result.values.push_back(
        {"/exposure_ms", best.exposure_ms, rounded(best.exposure_ms * best.log_uncertainty())});
  }
  result.notes.push_back(
      fmt::format("step {} of {} got {:g} ms, {:.3g} times the light of the next shorter one", args.step,
                  exposures.size(), best.exposure_ms, best.ratio));
  if (args.step == 1 || static_cast<std::size_t>(args.step) == exposures.size())
    result.notes.push_back(fmt::format(
        "the best step is the tower's {}: the best exposure may lie beyond it; accept this one, and print a "
        "tower around it",
        args.step == 1 ? "longest" : "shortest"));
  return finish_fit(args.fit, resin_target(printer, args.resin), result);
}

}  // namespace

void add_fit_exposure(Command& fit) {
  Command& command = fit.add("exposure", "Set the exposure to that of the best step of a tower");
  auto& args = command.arguments<ExposureFitArgs>();
  command.option("RESIN", args.resin, "Resin profile").required();
  command.option("STEP", args.step, "Number of the best step: its ribs").required();
  command.option("--ticket", args.ticket, "Ticket that the tower was printed with").required();
  command.option("--temperature-c", args.temperature_c,
                 "Temperature of the resin during the print, °C, if its curve has one");
  add_fit_options(command, args.fit);
  command.run = [&args] { return fit_exposure(args); };
}

}  // namespace contourd::ctl
