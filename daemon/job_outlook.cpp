#include "daemon/job_outlook.hpp"

#include <filesystem>
#include <numeric>
#include <system_error>

#include "daemon/config/config_error.hpp"
#include "daemon/copied_originals.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/motion_profile.hpp"

namespace contourd {

namespace fs = std::filesystem;

std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer) {
  const auto move = [&printer](Nanometers distance, MillimetersPerSecond speed) {
    if (printer.real) return move_duration(printer.real->axis, distance, speed);
    return MotionProfile(distance, speed, printer.simulated.axis.acceleration).duration();
  };
  std::vector<Duration> durations;
  for (std::size_t layer = 0; layer < plan.expected_layers.size(); ++layer)
    durations.push_back(layer_duration(plan, static_cast<std::int32_t>(layer), move));
  return durations;
}

namespace {

// As far as the files are there still.
std::uintmax_t bytes_of(const JobFiles& files) {
  std::uintmax_t all = 0;
  try {
    for (const fs::path& part : parts_of(files)) {
      std::error_code gone;
      const std::uintmax_t bytes = fs::file_size(part, gone);
      if (!gone) all += bytes;
    }
  } catch (const ConfigError&) {
    // A plate's ticket that is being written anew: the check will be, too.
  }
  return all;
}

}  // namespace

JobOutlook outlook_of(const PreparedJob& job, const JobFiles& files, const PrinterConfig& printer) {
  const JobSummary& summary = job.summary;
  JobOutlook outlook{.bytes = bytes_of(files),
                     .resin = summary.resin.name,
                     .overridden = summary.overridden,
                     .layers = summary.layers.count,
                     .thinnest_layer = summary.layers.thinnest,
                     .thickest_layer = summary.layers.thickest,
                     .height_mm = summary.height_mm};
  for (const ModelSummary& model : summary.models)
    outlook.parts += model.centers.size();
  const std::vector<Duration> durations = layer_durations(job.plan, printer);
  outlook.print_time = std::accumulate(durations.begin(), durations.end(), Duration{0});
  return outlook;
}

}  // namespace contourd
