#include "daemon/report/print_report_html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/cured_part_html.hpp"
#include "daemon/report/cured_part_text.hpp"
#include "daemon/report/first_items.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/report/light_histogram.hpp"
#include "daemon/report/range_times.hpp"
#include "daemon/report/rise_forecast_text.hpp"
#include "daemon/report/state_time_line.hpp"
#include "daemon/report/time_causes.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Style sheet of the report page, in addition to kPageStyle.
constexpr std::string_view kReportPageStyle = R"(
:root { --exposing: #6a3fb5; --moving: #2673ad; --waiting: #87909b; --preparing: #1f8a63; --stopped: #cf5a17; }
@media (prefers-color-scheme: dark) { :root { --exposing: #b08af5; --moving: #56a8e0; --waiting: #6d7886; --preparing: #3fbd8d; --stopped: #f0863f; } }
@media print { :root { --exposing: #6a3fb5; --moving: #2673ad; --waiting: #87909b; --preparing: #1f8a63; --stopped: #cf5a17; } }
.top table { flex: 1 1 22rem; } .top th { white-space: nowrap; } td { overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
.notes { margin: .3rem 0; padding-left: 1.2rem; } .notes li { margin: .3rem 0; overflow-wrap: anywhere; }
.notes a { white-space: nowrap; } .warnings li::marker { color: var(--bad); content: "! "; }
.layers { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 12.5rem), 1fr)); gap: 1rem; }
.exposing { fill: var(--exposing); background: var(--exposing); } .moving { fill: var(--moving); background: var(--moving); }
.waiting { fill: var(--waiting); background: var(--waiting); } .preparing { fill: var(--preparing); background: var(--preparing); }
.stopped, .pause { fill: var(--stopped); background: var(--stopped); } .interruption { fill: var(--bad); background: var(--bad); }
svg .tick { stroke: var(--ink); stroke-width: 1; } svg .most { fill: var(--accent); } svg .least { fill: var(--waiting); }
.swatch.most { background: var(--accent); } .swatch.least { background: var(--waiting); }
.figures td, .figures th { font-variant-numeric: tabular-nums; }
.figures .differs { color: var(--bad); }
.figures td:nth-child(n+2), .figures th:nth-child(n+2) { text-align: right; }
@media (max-width: 40rem) { .layers { grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .5rem; } body { margin: 1rem auto; } }
@media print {
  body { max-width: none; margin: 0; font-size: 10pt; } svg, .swatch, .shot { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h2 { break-after: avoid; } svg, tr { break-inside: avoid; } .layers { grid-template-columns: repeat(4, 1fr); } .part { width: 14rem; }
}
)";

// Limits on the page of any print: warnings, interruptions and pauses each; models; bytes of a sentence. The
// JSON report has all of them.
constexpr std::size_t kMaxItems = 50, kMaxModels = 20, kMaxSentence = 500;

template <typename Value>
std::string plot_of(const PrintReport& report, const std::string& title, Value&& value) {
  std::vector<PlotPoint> points;
  for (const LayerRecord& layer : report.layers) {
    points.push_back({to_millimeters(layer.mask_height).count(), static_cast<double>(value(layer))});
  }
  return svg_plot(title, points);
}

std::string hollow_text(const HollowSummary& hollow) {
  if (hollow.cavities == 0) return "no room for a cavity";
  return fmt::format("{} of {:.2f} ml, walls of {:g} mm, {} added",
                     count_of(hollow.cavities, "cavity", "cavities"), hollow.volume_mm3 / 1000,
                     hollow.settings.wall.count(), count_of(hollow.holes.size(), "hole", "holes"));
}

std::string model_rows(const ModelSummary& model) {
  std::string rows;
  if (!model.file.empty()) rows += table_row("File", model.file);
  rows += table_row(
      "Size", fmt::format("{:.2f} x {:.2f} x {:.2f} mm", model.size_x_mm, model.size_y_mm, model.size_z_mm));
  const bool is_mesh = model.mesh.facets > 0;
  rows += is_mesh ? table_row("Model", fmt::format("{} facets, {}, {}", model.mesh.facets, model.format,
                                                   model.mesh.watertight ? "watertight" : "not watertight"))
                  : table_row("Model", fmt::format("{}, {}", layers_text(model), model.format));
  if (model.centers.size() != 1) rows += table_row("Copies", std::to_string(model.centers.size()));
  if (model.drain_holes > 0) rows += table_row("Drain holes", std::to_string(model.drain_holes));
  if (model.hollow) rows += table_row("Hollow", hollow_text(*model.hollow));
  const Scale& scale = model.scale;
  if (!scale.uniform()) {
    rows += table_row("Scale", fmt::format("{:.4g} x {:.4g} x {:.4g}", scale.x, scale.y, scale.z));
  } else if (scale.x != 1) {
    rows += table_row("Scale", fmt::format("{:.4g}", scale.x));
  }
  if (model.orientation) rows += table_row("Way up", describe(*model.orientation));
  return rows;
}

std::string thickness_of(const JobSummary& summary) {
  const double thinnest_um = to_millimeters(summary.layers.thinnest).count() * 1000;
  if (!summary.layers.adaptive) return fmt::format("{:g} um each", thinnest_um);
  return fmt::format("{:g} to {:g} um (cusp {:g} um)", thinnest_um,
                     to_millimeters(summary.layers.thickest).count() * 1000,
                     to_millimeters(summary.layers.adaptive->cusp).count() * 1000);
}

std::string settings_rows(const PrintReport& report) {
  const JobSummary& summary = report.summary;
  std::string rows = table_row("Resin", describe_settings(summary));
  for (const Exclusion& each : first_items(report.exclusions, kMaxItems))
    rows += table_row("Excluded", describe(each));
  if (!report.changes.empty()) rows += table_row("Changed while printing", describe(report.changes));
  const std::string correction = describe_correction(summary);
  if (!correction.empty()) rows += table_row("Compensation", correction);
  return rows;
}

std::string exposure_rows(const std::vector<LayerRecord>& layers) {
  if (layers.empty()) return "";
  Duration least{0}, most{0};
  for (const LayerRecord& layer : layers) {
    if (!layer.complete) continue;
    least = std::min(least, layer.exposure_least - layer.exposure_asked);
    most = std::max(most, layer.exposure_most - layer.exposure_asked);
  }
  return table_row("Exposure",
                   fmt::format("{:.0f} ms first, {:.0f} ms last", in_ms(layers.front().exposure_asked),
                               in_ms(layers.back().exposure_asked))) +
         table_row("Light", fmt::format("{:+.2f} to {:+.2f} ms from the requested exposure", in_ms(least),
                                        in_ms(most)));
}

std::string mask_row(const std::vector<LayerRecord>& layers) {
  if (layers.empty()) return "";
  Duration slowest{0}, sum{0};
  for (const LayerRecord& layer : layers) {
    slowest = std::max(slowest, layer.mask_time);
    sum += layer.mask_time;
  }
  return table_row("Masks", fmt::format("{:.2f} ms each, the slowest {:.2f} ms",
                                        in_ms(sum) / static_cast<double>(layers.size()), in_ms(slowest)));
}

// Returns the row about split exposures, if there was one.
std::string pictures_row(const std::vector<LayerRecord>& layers) {
  const SplitFigures split = split_figures(layers);
  if (split.most_pictures == 1 && split.light_error == 0) return "";
  return table_row("Pictures",
                   fmt::format("up to {} a layer; pixels get their light to {:.1f} % of white's, "
                               "pictures came up to {:.1f} ms late",
                               split.most_pictures, 100 * split.light_error, in_ms(split.late_picture)));
}

// Returns the row about the peels, if there is a force line.
std::string peels_row(const std::vector<LayerRecord>& layers) {
  const PeelFigures peels = peel_figures(layers);
  if (peels.judged == 0) return "";
  std::string text = fmt::format("felt in {} of {}, lifts shorter by {:.1f} s", peels.felt,
                                 count_of(static_cast<std::size_t>(peels.judged), "layer", "layers"),
                                 in_seconds(peels.saved));
  if (peels.missed > 0)
    text += fmt::format("; missed {}: the part may have come off",
                        count_of(static_cast<std::size_t>(peels.missed), "time", "times"));
  return table_row("Peel", text);
}

// Returns the row about the masks of a rise, if there was one.
std::string frames_row(const PrintReport& report) {
  const FrameFigures frames = frame_figures(report.layers);
  if (frames.shown == 0 && frames.missed == 0) return "";
  std::string text = fmt::format("{} masks shown, {} missed, up to {:.2f} um from the plate's height",
                                 frames.shown, frames.missed, in_mm(frames.farthest) * 1000);
  if (frames.slowed > 0) text += fmt::format("; slowed down {}", count_of(frames.slowed, "time", "times"));
  if (report.frames) {
    text += fmt::format("; {} lists {} of them", report.frames->name, report.frames->recorded);
    if (report.frames->lost > 0) text += fmt::format(", {} could not be written", report.frames->lost);
  }
  return table_row("Rise", text);
}

// Returns rows for what went wrong in the print, apart from its stops and the model's warnings.
std::string trouble_rows(const PrintReport& report) {
  std::string rows;
  if (report.late_steps > 0)
    rows += table_row("Late steps",
                      fmt::format("{}: the computer was too busy to make them on time", report.late_steps));
  if (const std::int64_t layers = layers_with_unfound_undersides(report.layers); layers > 0)
    rows +=
        table_row("Undersides", fmt::format("kept all their light in {}: they were not found within "
                                            "mask_budget_ms",
                                            count_of(static_cast<std::size_t>(layers), "layer", "layers")));
  if (report.busiest_lit.busy > kLongestLitTurn) {
    rows += table_row("Late light", fmt::format("by up to {:.0f} ms: the event loop was busy with {}",
                                                in_ms(report.busiest_lit.busy), report.busiest_lit.source));
  }
  return rows;
}

// Returns the row with the exposed volume, and the volume of all layers if the print was not completed.
std::string resin_row(const PrintReport& report) {
  std::string used = fmt::format("{:.2f} ml", exposed_volume_mm3(report.layers) / 1000);
  if (report.findings && report.outcome != PrintOutcome::Done)
    used += fmt::format(" of {:.2f} ml in all layers", report.findings->resin_ml());
  return table_row("Resin used", used);
}

// Returns the rows of the models. A plate may hold hundreds of models; copies of a model count as one.
std::string models_rows(const std::vector<ModelSummary>& models) {
  std::string rows;
  for (const ModelSummary& model : first_items(models, kMaxModels))
    rows += model_rows(model);
  if (models.size() > kMaxModels)
    rows += table_row("Models", fmt::format("and {} more", models.size() - kMaxModels));
  return rows;
}

// Returns a table of the possible ways up for each model whose way up contourd chose.
std::string orientation_section(const std::vector<ModelSummary>& models) {
  std::string html;
  std::size_t tables = 0;
  for (const ModelSummary& model : models) {
    if (!model.orientation || tables == kMaxModels) continue;
    ++tables;
    html += fmt::format("<h2>Ways up{}</h2>\n<table id=\"ways-up-{}\">\n",
                        model.file.empty() ? "" : ": " + escaped(model.file), tables);
    for (const OrientationFigures& each : reported(model.orientation->choice))
      html += table_row(text_of(each.up), describe(each));
    html += "</table>\n";
  }
  return html;
}

std::string facts(const PrintReport& report) {
  const JobSummary& summary = report.summary;
  std::string rows = table_row("Printer", report.printer);
  rows += table_row("Started", local_time(report.started));
  rows += table_row("Print time", readable(report.print_time));
  rows += table_row("Layers", fmt::format("{} of {} exposed, {}", layers_exposed(report.layers),
                                          summary.layers.count, thickness_of(summary)));
  rows += resin_row(report) + models_rows(summary.models);
  if (summary.supports) rows += table_row("Supports", supports_line(counts_of(*summary.supports)));
  rows += settings_rows(report) + exposure_rows(report.layers) + trouble_rows(report);
  rows += table_row("First mask",
                    fmt::format("{:.1f} ms after the job's turn came", in_ms(report.first_mask_after)));
  rows +=
      mask_row(report.layers) + pictures_row(report.layers) + frames_row(report) + peels_row(report.layers);
  if (report.findings) rows += table_row("Analysis", findings_line(*report.findings));
  return rows;
}

// --- Warnings and stops

// Returns "<a href="#layer-8">layer 8</a>" for each of these layers that has a picture.
std::string links_to(const PrintReport& report, std::span<const std::int32_t> layers) {
  std::string links;
  for (const std::int32_t layer : layers) {
    if (std::ranges::find(report.layer_pictures, layer, &LayerPicture::layer) == report.layer_pictures.end())
      continue;
    links += fmt::format("{}<a href=\"#layer-{}\">layer {}</a>", links.empty() ? "; see " : ", ", layer + 1,
                         layer + 1);
  }
  return links;
}

std::string item(const std::string& sentence, const std::string& links = "") {
  return fmt::format("<li>{}{}</li>\n", escaped(shortened(sentence, kMaxSentence)), links);
}

// Returns how many items are beyond kMaxItems.
template <typename Items>
std::size_t beyond(const Items& items) {
  return items.size() - std::min(items.size(), kMaxItems);
}

std::string more_items(std::uint64_t more) {
  return more > 0 ? item(fmt::format("and {} more", more)) : "";
}

std::string warning_list(const PrintReport& report) {
  const std::vector<std::string>& of_model = report.summary.warnings;
  const auto of_layers =
      report.findings ? findings_warnings(*report.findings) : std::vector<FindingWarning>{};
  if (of_model.empty() && of_layers.empty()) return "";
  std::string list = "<h2>Warnings</h2>\n<ul class=\"notes warnings\">\n";
  for (const FindingWarning& warning : of_layers)
    list += item(warning.sentence, links_to(report, warning.layers));
  for (const std::string& warning : first_items(of_model, kMaxItems))
    list += item(warning);
  return list + more_items(beyond(of_model)) + "</ul>\n";
}

std::string stop_list(const PrintReport& report) {
  const PrintStops& stops = report.stops;
  std::string list;
  for (const PrintInterruption& each : first_items(stops.interruptions, kMaxItems)) {
    const std::int32_t layers[]{each.layer};
    list +=
        item(fmt::format("After {}, layer {}: interrupted: {}", readable(each.at), each.layer + 1, each.what),
             links_to(report, layers));
  }
  list += more_items(beyond(stops.interruptions) + stops.more_interruptions);
  for (const PrintPause& pause : first_items(stops.pauses, kMaxItems)) {
    list += item(fmt::format("After {}, layer {}: stopped for {}", readable(pause.at), pause.layer + 1,
                             readable(pause.lasted)));
  }
  list += more_items(beyond(stops.pauses) + stops.more_pauses);
  return list.empty() ? "" : "<ul class=\"notes\">\n" + list + "</ul>\n";
}

std::string time_section(const PrintReport& report) {
  const std::string line = state_time_line(report);
  if (line.empty()) return "";
  return "<h2>Where the time went</h2>\n" + line + times_table(report) + stop_list(report) +
         state_table(report.states);
}

// Returns a list of the plans that replaced the first one.
std::string changed_rises(const PrintReport& report) {
  if (report.changed_rises.empty()) return "";
  std::string list = "<ul class=\"notes\" id=\"changed-rises\">\n";
  for (const ChangedForecast& each : first_items(report.changed_rises, kMaxItems))
    list += item(
        fmt::format("From {:.3f} mm on with speed {:g} mm/h, light {:g} % and margin {:g}: {}; gel gap {}",
                    in_mm(each.from), each.settings.speed_mm_h, each.settings.light_percent,
                    each.settings.margin, continuous_line(each.plan), gel_line(each.plan)));
  return list + more_items(beyond(report.changed_rises)) + "</ul>\n";
}

// Returns the plan of a continuous print, and how long its ranges took.
std::string rises_section(const PrintReport& report) {
  if (!report.summary.continuous) return "";
  const ContinuousForecast& plan = *report.summary.continuous;
  return "<h2>Rises</h2>\n<table>\n" + table_row("Planned", continuous_line(plan)) +
         table_row("Gel gap", gel_line(plan)) + "</table>\n" +
         ranges_table(plan, range_times(report, plan.ranges)) + changed_rises(report);
}

std::string light_section(const PrintReport& report) {
  const LightHistogram histogram = histogram_of_light(report.layers);
  if (histogram.bins.empty()) return "";
  std::string html = "<h2>Actual minus requested exposure, ms</h2>\n" + svg_of(histogram);
  std::string text =
      fmt::format("{}, by the difference between actual and requested exposure.",
                  histogram.layers == 1 ? "1 layer" : fmt::format("{} layers", histogram.layers));
  if (std::abs(histogram.farthest_ms) >= LightHistogram::kFinest_ms) {
    text += fmt::format(" The largest difference is in layer {}: {:+.2f} ms.", histogram.farthest + 1,
                        histogram.farthest_ms);
  }
  if (histogram.left_out > 0)
    text +=
        fmt::format(" Not counted: {} whose light was incomplete or not confirmed off.", histogram.left_out);
  html += "<p>" + text;
  if (!histogram.exact) {
    html +=
        " Only bounds are known: <span class=\"swatch least\"></span>at least, "
        "<span class=\"swatch most\"></span>at most.";
  }
  return html + "</p>\n";
}

std::string rings_on(const LayerPicture& picture, const std::vector<LayerMark>& marks,
                     std::string_view style_class, std::string_view label) {
  if (marks.empty()) return "";
  std::string html = fmt::format("<svg class=\"{}\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                 style_class, picture.width.count(), picture.height.count(), label);
  for (const LayerMark& mark : marks) {
    html += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>", mark.middle.x, mark.middle.y,
                        mark.radius);
  }
  return html + "</svg>";
}

std::string figure(const PrintReport& report, const LayerPicture& picture) {
  const auto record = std::ranges::lower_bound(report.layers, picture.layer, {}, &LayerRecord::layer);
  const std::string height = record == report.layers.end()
                                 ? ""
                                 : fmt::format(", {:.3f} mm, {:.2f} mm²",
                                               to_millimeters(record->mask_height).count(), record->area_mm2);
  std::string html = fmt::format(
      "<figure id=\"layer-{0}\"><div class=\"shot\"><img alt=\"The projector's picture of layer {0}\" "
      "width=\"{1}\" height=\"{2}\" src=\"data:image/png;base64,{3}\">",
      picture.layer + 1, picture.width.count(), picture.height.count(), base64(picture.png));
  html += rings_on(picture, picture.islands, "islands", "Islands that begin here");
  html += rings_on(picture, picture.voids, "voids", "Suction cups and resin traps that are widest here");
  return html + fmt::format("</div><figcaption>Layer {}{}{}</figcaption></figure>\n", picture.layer + 1,
                            height, picture.why.empty() ? "" : ": " + escaped(picture.why));
}

std::string layer_section(const PrintReport& report) {
  if (report.layer_pictures.empty()) return "";
  std::string html = "<h2>Layers, as the projector showed them</h2>\n<div class=\"layers\">\n";
  for (const LayerPicture& picture : report.layer_pictures)
    html += figure(report, picture);
  return html + "</div>\n";
}

// Returns the part that the print's light cured.
std::string cured_part_section(const PrintReport& report) {
  if (!report.cured) return "";
  std::string html = "<h2>The part that was cured</h2>\n";
  if (!report.cured->part) return html + "<p>Not computed: " + escaped(report.cured->why_not) + ".</p>\n";
  const CuredPart& part = *report.cured->part;
  html +=
      "<p>By the light that the layers really had, this is the part that you should have in your hand: its "
      "distance from the model, positive where it is too large.</p>\n<table class=\"cured-figures\">\n";
  std::vector<CureLine> lines = cured_part_lines(part);
  if (report.cured->rise) lines.push_back(rise_light_line(*report.cured->rise));
  for (const CureLine& line : lines)
    html += table_row(line.name, line.text);
  for (const std::string& warning : warnings_of(*report.cured, report.summary.resin.peel_memory_measured))
    html += table_row("warning", warning);
  return html + "</table>\n" + cured_section(part.figures.section) + distance_plots(part.figures);
}

// Returns the plot of the way until each layer let go of the film, if a force line tells of it.
std::string peel_plot(const PrintReport& report) {
  std::vector<PlotPoint> points;
  for (const LayerRecord& layer : report.layers)
    if (layer.peel && layer.peel->distance)
      points.push_back({in_mm(layer.mask_height), in_mm(*layer.peel->distance)});
  return points.empty() ? "" : svg_plot("Peel, mm until the layer let go of the film, by height", points);
}

std::string plots(const PrintReport& report) {
  if (report.layers.empty()) return "";
  return plot_of(report, "Exposed area, mm² by height", [](const LayerRecord& l) { return l.area_mm2; }) +
         plot_of(report, "Time from height to mask, ms by height",
                 [](const LayerRecord& l) { return in_ms(l.mask_time); }) +
         plot_of(report, "Contour loops by height", [](const LayerRecord& l) { return l.loops; }) +
         peel_plot(report);
}

// Returns the picture of the part, if there is one.
std::string preview_figure(const PrintReport& report) {
  if (!report.preview) return "";
  const bool done = report.outcome == PrintOutcome::Done;
  return picture_figure(*report.preview, done ? "The part as far as it was printed"
                                              : "The part as far as it was printed, the rest faint");
}

}  // namespace

std::string report_as_html(const PrintReport& report) {
  const std::string job = escaped(report.job);
  const std::string outcome(name_of(report.outcome));
  const std::string reason =
      report.reason.empty() ? "" : ": " + escaped(shortened(report.reason, kMaxSentence));
  std::string html =
      page_start(fmt::format("{}: {}", job, outcome),
                 std::string(kReportPageStyle) + std::string(kCuredPartStyle)) +
      fmt::format("<h1>{0}</h1>\n<div class=\"outcome {1}\">{1}{2}</div>\n<div class=\"top\">\n", job,
                  outcome, reason);
  html += preview_figure(report) + "<table>\n" + facts(report) + "</table>\n</div>\n";
  html += warning_list(report) + orientation_section(report.summary.models) + layer_section(report) +
          rises_section(report) + time_section(report) + light_section(report) + cured_part_section(report);
  return html + plots(report) + "</html>\n";
}

}  // namespace contourd
