#include "daemon/jobs/print_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <variant>

#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Number of warnings about a model that are logged; a model may cause any number.
constexpr std::size_t kMaxWarnings = 20;

// Returns "434000 facets, 20.00 x 20.00 x 40.00 mm", or a summary of the plate.
std::string content_of(const JobSummary& summary) {
  if (!summary.plate) {
    const ModelSummary& model = summary.models.front();
    const std::string of = summary.sliced ? layers_text(model) : fmt::format("{} facets", model.mesh.facets);
    return fmt::format("{}, {:.2f} x {:.2f} x {:.2f} mm", of, model.size_x_mm, model.size_y_mm,
                       model.size_z_mm);
  }
  std::size_t parts = 0;
  std::uint64_t facets = 0;
  for (const ModelSummary& model : summary.models) {
    parts += model.centers.size();
    facets += model.mesh.facets;
  }
  return fmt::format("{} models, {} parts, {} facets, {:.2f} mm high", summary.models.size(), parts, facets,
                     summary.height_mm);
}

std::string thickness_of(const LayerSummary& layers) {
  const auto um = [](Nanometers thickness) { return to_millimeters(thickness).count() * 1000; };
  if (!layers.adaptive) return fmt::format("{:g} um", um(layers.thinnest));
  return fmt::format("{:g} to {:g} um", um(layers.thinnest), um(layers.thickest));
}

// Returns "1980.3 to 2011.7 ms", or one figure if both are the same.
std::string light_of(const LayerRecord& layer) {
  const std::string most =
      fmt::format("{:.1f} ms{}", milliseconds(layer.exposure_most), layer.dark_confirmed ? "" : " or more");
  const std::string least = fmt::format("{:.1f}", milliseconds(layer.exposure_least));
  return most.starts_with(least + " ") ? most : least + " to " + most;
}

// Returns ", 12 pictures that give pixels their light to 0.9 % of white's", or nothing if one mask gives it.
std::string pictures_of(const LayerRecord& layer) {
  if (layer.pictures == 1 && layer.light_error == 0) return "";
  return fmt::format(", {} that {} pixels their light to {:.1f} % of white's",
                     count_of(layer.pictures, "picture", "pictures"), layer.pictures == 1 ? "gives" : "give",
                     100 * layer.light_error);
}

LogFields layer_fields(const std::string& job, std::int32_t layer) {
  LogFields fields = job_fields(job);
  fields.emplace_back("LAYER", std::to_string(layer + 1));
  return fields;
}

// Layers of a print that have something in common, numbered from 1.
struct LayerSpan {
  std::size_t count = 0;
  std::int32_t first = 0, last = 0;
};

template <typename Predicate>
LayerSpan layers_with(const std::vector<LayerRecord>& layers, const Predicate& is_affected) {
  LayerSpan span;
  for (const LayerRecord& layer : layers) {
    if (!is_affected(layer)) continue;
    if (++span.count == 1) span.first = layer.layer + 1;
    span.last = layer.layer + 1;
  }
  return span;
}

}  // namespace

void PrintLog::refused(const std::string& job, const std::string& reason) const {
  log_.error("refused", fmt::format("{}: {}", printable(job), reason), job_fields(job));
}

void PrintLog::ready(const std::string& job, const JobSummary& summary, Duration first_mask_after) const {
  const LogFields fields = job_fields(job);
  const std::string name = printable(job);
  log_.info("ready",
            fmt::format("{}: {}, {} layers of {}; first mask after {:.0f} ms{}", name, content_of(summary),
                        summary.layers.count, thickness_of(summary.layers), milliseconds(first_mask_after),
                        summary.prepared_before ? ", prepared while it waited" : ""),
            fields);
  log_.info("settings", fmt::format("{}: {}", name, describe_settings(summary)), fields);
  if (const std::string correction = describe_correction(summary); !correction.empty())
    log_.info("compensation", fmt::format("{}: {}", name, correction), fields);
  if (summary.supports) {
    log_.info("supports",
              fmt::format("{}: supports: {}; found in {:.0f} ms", name,
                          supports_line(counts_of(*summary.supports)), milliseconds(summary.supporting)),
              fields);
  }
  const std::size_t turned = std::min(summary.models.size(), kMaxWarnings);
  for (std::size_t i = 0; i < turned; ++i) {
    const ModelSummary& model = summary.models[i];
    if (!model.orientation) continue;
    const std::string what = summary.plate ? name + ": " + printable(model.file) : name;
    log_.info("orientation", fmt::format("{}: {}", what, describe(*model.orientation)), fields);
  }
  const std::size_t logged = std::min(summary.warnings.size(), kMaxWarnings);
  for (std::size_t i = 0; i < logged; ++i)
    log_.warning("model", fmt::format("{}: {}", name, summary.warnings[i]), fields);
  if (logged < summary.warnings.size())
    log_.warning("model", fmt::format("{}: and {} more", name, summary.warnings.size() - logged), fields);
}

void PrintLog::analyzed(const std::string& job, const AnalyzedPrint& print) const {
  const LogFields fields = job_fields(job);
  const std::string name = printable(job);
  const auto* const findings = std::get_if<PrintFindings>(&print.findings);
  if (findings == nullptr) {
    log_.warning("analysis",
                 fmt::format("{}: the print continues, but could not be analyzed: {}", name,
                             std::get<std::string>(print.findings)),
                 fields);
    return;
  }
  log_.info(
      "analysis",
      fmt::format("{}: {}; found in {:.0f} ms", name, findings_line(*findings), milliseconds(print.took)),
      fields);
  for (const std::string& warning : warnings_about(*findings))
    log_.warning("analysis", fmt::format("{}: {}", name, warning), fields);
}

void PrintLog::entered(const std::string& job, const PrintState& state) const {
  if (state.logged) log_.info("state", fmt::format("{}: {}", printable(job), state.name), job_fields(job));
}

void PrintLog::layer(const std::string& job, const JobSummary& summary, const LayerRecord& layer,
                     Duration frame) const {
  LogFields fields = layer_fields(job, layer.layer);
  fields.emplace_back("Z_NM", std::to_string(layer.plate_height.count()));
  log_.info(
      "layer",
      fmt::format("layer {} of {}: height {:.4f} mm, {:.2f} mm², {} loops, mask {:.2f} ms, light {}{}{}",
                  layer.layer + 1, summary.layers.count, to_millimeters(layer.plate_height).count(),
                  layer.area_mm2, layer.loops, milliseconds(layer.mask_time), light_of(layer),
                  pictures_of(layer), layer.complete || summary.dry ? "" : ", not finished"),
      fields);
  warn_about_light(summary, layer, frame, fields);
}

void PrintLog::warn_about_light(const JobSummary& summary, const LayerRecord& layer, Duration frame,
                                const LogFields& fields) const {
  const auto asked = fmt::format("layer {}: the light was on for {}, {:.1f} ms were asked for",
                                 layer.layer + 1, light_of(layer), milliseconds(layer.exposure_asked));
  // Longer by more than one refresh: something kept this process from turning the light off.
  if (layer.exposure_least > layer.exposure_asked + frame) log_.warning("overexposed", asked, fields);
  if (layer.late_picture > frame)
    log_.warning(
        "late-picture",
        fmt::format("layer {}: a picture of its exposure came {:.1f} ms late: pixels that it darkens "
                    "got up to {:.1f} % more of white's light than planned",
                    layer.layer + 1, milliseconds(layer.late_picture),
                    100 * in_seconds(layer.late_picture) / in_seconds(layer.exposure_asked)),
        fields);
  if (layer.frames.missed > 0)
    log_.warning("missed-masks",
                 fmt::format("layer {}: {} missed{}", layer.layer + 1,
                             count_of(layer.frames.missed, "mask was", "masks were"),
                             layer.frames.slowed > 0 ? ", and the plate was slowed down" : ""),
                 fields);
  const Duration tolerated = summary.resin.tolerance.bounds;
  if (layer.exposure_most - layer.exposure_least > tolerated) {
    log_.warning(
        "doubtful-light",
        fmt::format("{}; the projector's replies allow no closer bounds, and the resin tolerates {:.0f} ms",
                    asked, milliseconds(tolerated)),
        fields);
  }
}

void PrintLog::interrupted(const std::string& job, std::int32_t layer, const std::string& what,
                           bool dark) const {
  log_.warning("disturbed",
               fmt::format("{}: layer {}: {}; {}; \"contourctl resume\" completes the layer and continues",
                           printable(job), layer + 1, printable(what),
                           dark ? "the light is off" : "light off was sent"),
               layer_fields(job, layer));
}

void PrintLog::ended(const PrintReport& report) const {
  const std::string summary =
      fmt::format("{}: {} after {} of {} layers and {}{}", printable(report.job), name_of(report.outcome),
                  layers_exposed(report.layers), report.summary.layers.count, readable(report.print_time),
                  report.reason.empty() ? "" : ": " + report.reason);
  log_.write(report.outcome == PrintOutcome::Failed ? LogLevel::Error : LogLevel::Info,
             name_of(report.outcome), summary, job_fields(report.job));
  warn_about_sections(report);
  warn_about_lateness(report);
}

void PrintLog::warn_about_sections(const PrintReport& report) const {
  Millimeters widest{};
  for (const LayerRecord& layer : report.layers)
    widest = std::max(widest, layer.cracks.widest_gap);
  const auto warn = [&](const char* kind, const std::string& what, const auto& is_affected) {
    const LayerSpan span = layers_with(report.layers, is_affected);
    if (span.count == 0) return;
    log_.warning(kind,
                 fmt::format("{}: {} of {}, from layer {} to {}: {}", printable(report.job), span.count,
                             count_of(report.layers.size(), "layer", "layers"), span.first, span.last, what),
                 job_fields(report.job));
  };
  warn("gaps", fmt::format("contours did not close; the widest gap bridged is {:.3f} mm", widest.count()),
       [](const LayerRecord& layer) { return layer.cracks.open_chains > 0; });
  warn("turned", "sections of contours run in the wrong direction; they were reversed",
       [](const LayerRecord& layer) { return layer.cracks.turned_chains > 0; });
  warn("empty", "nothing to expose", [&report](const LayerRecord& layer) {
    return layer.area_mm2 == 0 && layer.layer + 1 < report.summary.layers.count;
  });
  const double light_error = split_figures(report.layers).light_error;
  warn("coarse-light",
       fmt::format("exposures too short for more pictures: pixels get their light to {:.1f} % of white's",
                   100 * light_error),
       [](const LayerRecord& layer) { return layer.light_error > LightSplit::kExactness; });
  warn("undersides", "undersides kept all their light, because they were not found within mask_budget_ms",
       [](const LayerRecord& layer) { return !layer.undersides_found; });
}

void PrintLog::warn_about_lateness(const PrintReport& report) const {
  if (const FrameFigures frames = frame_figures(report.layers); frames.missed > 0) {
    log_.warning(
        "late-masks",
        fmt::format("{}: {} of {} masks came too late for their refresh: this computer was too busy, "
                    "or is too slow{}",
                    printable(report.job), frames.missed, frames.shown + frames.missed,
                    frames.slowed > 0 ? ", and the plate was slowed down" : ""),
        job_fields(report.job));
  }
  if (report.late_steps > 0) {
    log_.warning(
        "late",
        fmt::format("{}: {} steps of the motor came late and delayed the steps after them: this computer "
                    "was too busy, or is too slow",
                    printable(report.job), report.late_steps),
        job_fields(report.job));
  }
  const EventLoop::Turn& turn = report.busiest_lit;
  if (turn.busy > kLongestLitTurn) {
    log_.warning(
        "busy",
        fmt::format(
            "{}: {} kept the event loop busy for {:.1f} ms, of which {:.1f} ms were computing, while the "
            "light was on or not known to be off; the limit is {:.0f} ms: light off may have come "
            "that much later",
            printable(report.job), turn.source, milliseconds(turn.busy), milliseconds(turn.computing),
            milliseconds(kLongestLitTurn)),
        job_fields(report.job));
  }
}

}  // namespace contourd
