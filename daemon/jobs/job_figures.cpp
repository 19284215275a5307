#include "daemon/jobs/job_figures.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "daemon/prepare/print_findings.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {}  // namespace

JobFigures figures_of(const JobSummary& summary, const std::vector<LayerRecord>& layers,
                      Duration print_time) {
  JobFigures figures{.resin = summary.resin.name,
                     .settings = describe_settings(summary),
                     .warnings = summary.warnings,
                     .height_mm = summary.height_mm,
                     .layers = summary.layers.count,
                     .layers_exposed = layers_exposed(layers),
                     .print_time_s = in_seconds(print_time)};
  Duration lit{}, asked{}, most_over{};
  double volume_mm3 = 0;
  for (const LayerRecord& layer : layers) {
    lit += layer.exposure_most;
    asked += layer.exposure_asked;
    most_over = std::max(most_over, layer.exposure_most - layer.exposure_asked);
    volume_mm3 += layer.area_mm2 * to_millimeters(layer.thickness).count();
  }
  constexpr double kMm3PerMl = 1000;
  if (!layers.empty()) figures.layer_height_um = to_millimeters(layers.front().thickness).count() * 1000;
  figures.lit_s = in_seconds(lit);
  figures.light_asked_s = in_seconds(asked);
  figures.most_light_over_ms = milliseconds(most_over);
  figures.resin_ml = volume_mm3 / kMm3PerMl;
  return figures;
}

JobFigures figures_of(const PrintReport& report) {
  JobFigures figures = figures_of(report.summary, report.layers, report.print_time);
  if (report.findings) {
    for (const std::string& warning : warnings_about(*report.findings))
      figures.warnings.push_back(warning);
  }
  figures.interruptions =
      static_cast<std::int64_t>(report.stops.interruptions.size() + report.stops.more_interruptions);
  figures.late_steps = static_cast<std::int64_t>(report.late_steps);
  return figures;
}

}  // namespace contourd
