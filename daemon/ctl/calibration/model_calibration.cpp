// The calibrations that print a model as an ordinary job: bridges for the memory at a peel, a ladder of
// lengths, and a tower of exposures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include "core/calibration/calibration_models.hpp"
#include "core/calibration/line_fit.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/stl_file.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kMemoryText =
    R"(Wash the part, dry it and cure it. Measure the thickness of each bridge in its middle, in um, with a
micrometer or calipers that press lightly, or with a microscope from the side. Measure each bridge at
least three times and give all values. The dots in front of a bridge are its number:

dots   layers   drawn um
)";
constexpr const char* kDimensionsText =
    R"(Wash the part, dry it and cure it. Measure the blocks with calipers, in mm, above the strip that carries
them. The blocks' ends are at 0-3, 8-10, 19-21 and 29-30 mm of each strip. x is the strip to the right,
y the strip to the back, as contourctl preview shows the plate; both begin at the front left.

length    from and to, mm
)";
constexpr const char* kExposureText =
    R"(Wash the part and dry it. Steps with too little light may have come off: look for pieces in the vat.
At the back of each step are fins, then slots, of 0.1, 0.2, 0.3, 0.5 and 1 mm. Look at the middle of the
step. The right exposure is the shortest at which the fins of 0.2 or 0.3 mm stand straight and the slots
of the same width are open. The ribs at the front are the step's number:

ribs   exposure ms
)";

struct ModelArgs {
  std::string resin;
  fs::path printer = kDefaultConfig;
  fs::path folder;
};

// A calibration print, ready for `contourctl submit`.
struct CalibrationJob {
  std::string name;
  std::vector<Facet> model;
  Json ticket;
  std::string how_to_measure;  // lines
};

// Makes the jobs for one resin of a printer.
class CalibrationJobs {
 public:
  explicit CalibrationJobs(const ModelArgs& args)
      : args_(args),
        printer_(load_printer_config(args.printer, Places::Elsewhere)),
        resin_(find_resin(printer_, args.resin)),
        layer_mm_(in_mm(resin_.layer_height)) {}

  [[nodiscard]] CalibrationJob memory() const;
  [[nodiscard]] CalibrationJob dimensions() const;
  [[nodiscard]] CalibrationJob exposure() const;

 private:
  // Returns the height in the model of a height in the print, which the resin's shrinkage enlarges.
  [[nodiscard]] Millimeters drawn(double printed_mm) const {
    return Millimeters{printed_mm / resin_.shrinkage_factors.z};
  }
  [[nodiscard]] double normal_exposure_ms() const {
    return milliseconds(
        exposure_time(resin_, resin_.layer_height, first_normal_layer(), printer_.irradiance_mw_cm2));
  }
  [[nodiscard]] int first_normal_layer() const { return resin_.bottom_layers + resin_.fade_layers; }
  [[nodiscard]] std::vector<double> tower_exposures() const;
  [[nodiscard]] double exposure_ms_of(MillijoulesPerCm2 dose) const {
    return dose.count() / printer_.irradiance_mw_cm2 * 1000;
  }
  [[nodiscard]] double bottom_exposure_ms() const;
  [[nodiscard]] Json ticket() const { return {{"resin", args_.resin}, {"supports", "off"}}; }
  // Returns the command that computes the figures, with a question mark for each value.
  [[nodiscard]] std::string fit_command(const char* kind, const std::vector<std::string>& keys) const;

  const ModelArgs& args_;
  PrinterConfig printer_;
  ResinProfile resin_;
  double layer_mm_;
};

std::string CalibrationJobs::fit_command(const char* kind, const std::vector<std::string>& keys) const {
  std::string text = fmt::format("contourctl fit {} {}", kind, printable(args_.resin));
  for (const std::string& key : keys)
    text += fmt::format(" {}=?", key);
  return fmt::format("{} --printer {}\n", text, printable(args_.printer.string()));
}

CalibrationJob CalibrationJobs::memory() const {
  const WorkingCurve curve = cure_of(resin_).curve;
  constexpr double kJaw = 4;  // mm, for the lower jaw of calipers
  const double dark_mm = 6 * to_millimeters(curve.penetration_depth).count();
  const double clearance_mm = std::max({kJaw, dark_mm, first_normal_layer() * layer_mm_});
  CalibrationJob job{.name = "memory",
                     .model = bridge_model(drawn(layer_mm_), drawn(clearance_mm)),
                     .ticket = ticket(),
                     .how_to_measure = {}};
  // Dimmed undersides would hide what the resin remembers.
  job.ticket["undersides"] = "plain";
  job.how_to_measure = kMemoryText;
  std::vector<std::string> keys;
  for (std::size_t bridge = 0; bridge < kBridgeLayers.size(); ++bridge) {
    const int layers = kBridgeLayers[bridge];
    job.how_to_measure +=
        fmt::format("{:>4} {:>8} {:>10.4g}\n", bridge + 1, layers, layers * layer_mm_ * 1000);
    keys.insert(keys.end(), 3, std::to_string(layers));
  }
  job.how_to_measure +=
      "\nThen type the thicknesses, each after the number of the bridge's layers, without bridges that "
      "tore:\n\n" +
      fit_command("memory", keys);
  return job;
}

CalibrationJob CalibrationJobs::dimensions() const {
  CalibrationJob job{.name = "dimensions", .model = ladder_model(), .ticket = ticket(), .how_to_measure = {}};
  job.how_to_measure = kDimensionsText;
  std::vector<std::string> keys;
  for (const char* axis : {"x", "y"})
    for (const LadderLength& length : ladder_lengths()) {
      keys.push_back(
          fmt::format("{}{}{:g}", axis, length.kind == LengthKind::Inner ? "gap" : "", length.drawn_mm));
      job.how_to_measure +=
          fmt::format("{:<9} {:g} to {:g}, {}\n", keys.back(), length.from.count(), length.to.count(),
                      length.kind == LengthKind::Inner ? "between two blocks" : "over the blocks");
    }
  job.how_to_measure += "\nThen type the measured lengths:\n\n" + fit_command("dimensions", keys);
  return job;
}

// Returns the exposure of a bottom layer of the profile's height, by the curve if the profile has one.
double CalibrationJobs::bottom_exposure_ms() const {
  if (const auto* fixed = std::get_if<FixedExposure>(&resin_.exposure))
    return milliseconds(fixed->bottom_exposure);
  const Micrometers overcure = std::get<CurveExposure>(resin_.exposure).bottom_overcure;
  return exposure_ms_of(cure_of(resin_).curve.dose_for(Micrometers{layer_mm_ * 1000} + overcure));
}

// Returns the exposures of the tower's steps in ms, falling: within the limits for tickets, and such that
// each of them may become that of the profile, see fit_exposure().
std::vector<double> CalibrationJobs::tower_exposures() const {
  const double normal = normal_exposure_ms();
  double least = 0.6 * normal, most = 2 * normal;
  if (!resin_.limits.exposure)
    throw CalibrationRefused(fmt::format(
        "{} has no ticket_limits for exposure_ms, within which a test print varies the exposure: add "
        "\"ticket_limits\": {{\"exposure_ms\": [{:.0f}, {:.0f}]}}",
        printable(resin_.name), least, most));
  least = std::max(least, figure_of(resin_.limits.exposure->least));
  most = std::min(most, figure_of(resin_.limits.exposure->most));
  // With less light than this, layers do not bond, and the tower falls apart.
  if (resin_.cure)
    least = std::max(least, exposure_ms_of(resin_.cure->curve.dose_for(Micrometers{layer_mm_ * 1000})));
  const double bottom = bottom_exposure_ms();
  most = std::min(most, bottom);
  // Whole numbers, since rounding would lead beyond the limits.
  least = std::ceil(least);
  most = std::floor(most);
  if (!(most > 1.2 * least))
    throw CalibrationRefused(fmt::format(
        "{} leaves {:g} to {:g} ms for a test print, whose longest exposure must be 1.2 times the shortest "
        "one: by its ticket_limits of exposure_ms, {:g} to {:g}, and by its bottom layers' {:.4g} ms, the "
        "longest exposure that another layer may get{}; widen the limits, or raise {}",
        printable(resin_.name), least, most, figure_of(resin_.limits.exposure->least),
        figure_of(resin_.limits.exposure->most), bottom,
        resin_.cure ? ", and a layer needs as much as cures its own height" : "",
        resin_.cure ? "bottom_overcure_um" : "bottom_exposure_ms"));
  std::vector<double> exposures;
  for (int step = 0; step < kMostTowerSteps; ++step) {
    const double exposure = most * std::pow(least / most, 1.0 * step / (kMostTowerSteps - 1));
    exposures.push_back(std::clamp(std::round(exposure), least, most));  // rounding of the power
  }
  return exposures;
}

CalibrationJob CalibrationJobs::exposure() const {
  const std::vector<double> exposures = tower_exposures();
  const auto layers_of = [this](double mm) { return static_cast<int>(std::ceil(mm / layer_mm_)); };
  const int base = std::max(layers_of(1), first_normal_layer()), step_layers = layers_of(2);
  const auto height_mm = [this](int layers) { return in_mm(resin_.layer_height * layers); };
  CalibrationJob job{
      .name = "exposure",
      .model = tower_model({kMostTowerSteps, drawn(height_mm(base)), drawn(height_mm(step_layers))}),
      .ticket = ticket(),
      .how_to_measure = {}};
  job.how_to_measure = kExposureText;
  for (int step = 0; const double exposure_ms : exposures) {
    job.ticket["exposure_steps"].push_back(
        {{"from_mm", height_mm(base + step++ * step_layers)}, {"exposure_ms", exposure_ms}});
    job.how_to_measure += fmt::format("{:>4} {:>13.6g}", step, exposure_ms);
    if (resin_.cure) {
      const MillijoulesPerCm2 dose{exposure_ms / 1000 * printer_.irradiance_mw_cm2};
      job.how_to_measure +=
          fmt::format("   overcure_um {:.1f}", resin_.cure->curve.depth_of(dose).count() - layer_mm_ * 1000);
    }
    job.how_to_measure += "\n";
  }
  job.how_to_measure += fmt::format(
      "\nThen type the number of the best step:\n\ncontourctl fit exposure {} ? --ticket {}{} --printer {}\n",
      printable(args_.resin), printable((args_.folder / (job.name + ".json")).string()),
      resin_.cure_temperature ? " --temperature-c ?" : "", printable(args_.printer.string()));
  return job;
}

// Writes the job into the folder and prints the text.
int write_job(const ModelArgs& args, const CalibrationJob& job) {
  std::error_code failed;
  fs::create_directories(args.folder, failed);
  if (failed)
    throw OutputError(fmt::format("cannot make the folder {}: {}", args.folder.string(), failed.message()));
  const auto file = [&](const char* suffix) { return args.folder / (job.name + suffix); };
  const std::string text =
      fmt::format("Print it:\n\ncontourctl submit {} --ticket {}\n\n{}", printable(file(".stl").string()),
                  printable(file(".json").string()), job.how_to_measure);
  write_text(file(".stl"), binary_stl(job.model, job.name));
  write_text(file(".json"), job.ticket.dump(2) + "\n");
  write_text(file(".txt"), text);
  fmt::print("{}", text);
  return kOk;
}

}  // namespace

void add_calibrate_models(Command& calibrate) {
  const auto add = [&calibrate](const char* name, const char* help,
                                CalibrationJob (CalibrationJobs::*make)() const) {
    Command& command = calibrate.add(name, help);
    auto& args = command.arguments<ModelArgs>();
    command.option("RESIN", args.resin, "Resin profile").required();
    command.option("--printer", args.printer, "Configuration of the printer");
    command.option("-o,--output", args.folder, "Folder for the model, its ticket and the text").required();
    command.run = [&args, make] { return write_job(args, (CalibrationJobs(args).*make)()); };
  };
  add("exposure", "Make a tower with a different exposure in each step", &CalibrationJobs::exposure);
  add("memory", "Make bridges that show how much of its light the resin remembers at a peel",
      &CalibrationJobs::memory);
  add("dimensions", "Make rows of blocks that show the resin's shrinkage and growth",
      &CalibrationJobs::dimensions);
}

}  // namespace contourd::ctl
