#include <fmt/format.h>

#include <algorithm>

#include "daemon/html_page.hpp"
#include "daemon/print_findings.hpp"
#include "daemon/print_report.hpp"
#include "daemon/readable.hpp"

namespace contourd {
namespace {

template <typename Value>
std::string plot_of(const PrintReport& report, const std::string& title, Value&& value) {
  std::vector<PlotPoint> points;
  for (const LayerRecord& layer : report.layers) {
    points.push_back({to_millimeters(layer.mask_height).count(), static_cast<double>(value(layer))});
  }
  return svg_plot(title, points);
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
}

double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

std::string model_rows(const ModelSummary& model) {
  std::string rows;
  if (!model.file.empty()) rows += row("File", model.file);
  rows += row("Size",
              fmt::format("{:.2f} x {:.2f} x {:.2f} mm", model.size_x_mm, model.size_y_mm, model.size_z_mm));
  rows += row("Model", fmt::format("{} facets, {}, {}", model.mesh.facets, model.format,
                                   model.mesh.watertight ? "watertight" : "not watertight"));
  if (model.centers.size() != 1) rows += row("Copies", std::to_string(model.centers.size()));
  const Scale& scale = model.scale;
  if (!scale.uniform()) {
    rows += row("Scale", fmt::format("{:.4g} x {:.4g} x {:.4g}", scale.x, scale.y, scale.z));
  } else if (scale.x != 1) {
    rows += row("Scale", fmt::format("{:.4g}", scale.x));
  }
  return rows;
}

std::string facts(const PrintReport& report) {
  const JobSummary& s = report.summary;
  std::string rows;
  rows += row("Printer", report.printer);
  rows += row("Started", iso_time(report.started));
  rows += row("Print time", readable(report.print_time));
  const double thinnest_um = to_millimeters(s.layers.thinnest).count() * 1000;
  const double thickest_um = to_millimeters(s.layers.thickest).count() * 1000;
  rows +=
      row("Layers", fmt::format("{} of {} exposed, {}", layers_exposed(report.layers), s.layers.count,
                                s.layers.adaptive
                                    ? fmt::format("{:g} to {:g} um (cusp {:g} um)", thinnest_um, thickest_um,
                                                  to_millimeters(s.layers.adaptive->cusp).count() * 1000)
                                    : fmt::format("{:g} um each", thinnest_um)));
  for (const ModelSummary& model : s.models)
    rows += model_rows(model);
  rows += row("Resin", describe_settings(s));
  rows +=
      row("Lift", fmt::format("{:g} mm, {:g} mm/s up, {:g} mm/s down", to_millimeters(s.resin.lift).count(),
                              s.resin.lift_speed.count(), s.resin.retract_speed.count()));
  rows += row("Waits",
              fmt::format("{:g} ms before the light, {:g} ms after", ms(s.resin.settle), ms(s.resin.rest)));
  const std::string correction = describe_correction(s);
  if (!correction.empty()) rows += row("Compensation", correction);
  if (!report.layers.empty()) {
    rows += row("Exposure",
                fmt::format("{:.0f} ms first, {:.0f} ms last", ms(report.layers.front().exposure_asked),
                            ms(report.layers.back().exposure_asked)));
    Duration least{0}, most{0};
    for (const LayerRecord& layer : report.layers) {
      if (!layer.complete) continue;
      least = std::min(least, layer.exposure_least - layer.exposure_asked);
      most = std::max(most, layer.exposure_most - layer.exposure_asked);
    }
    rows += row("Light against asked",
                fmt::format("{:.2f} ms at the least, +{:.2f} ms at the most", ms(least), ms(most)));
  }
  for (const std::string& interruption : report.interruptions)
    rows += row("Interrupted", interruption);
  if (report.late_steps > 0)
    rows += row("Late steps", fmt::format("{}: the computer was too busy for them", report.late_steps));
  if (report.busiest_lit.busy > kLongestLitTurn) {
    rows += row("Late light", fmt::format("by up to {:.0f} ms: the event loop was busy with {}",
                                          ms(report.busiest_lit.busy), report.busiest_lit.source));
  }
  rows += row("First mask", fmt::format("{:.1f} ms after its turn came", ms(report.first_mask_after)));
  Duration slowest{0}, sum{0};
  for (const LayerRecord& layer : report.layers) {
    slowest = std::max(slowest, layer.mask_time);
    sum += layer.mask_time;
  }
  if (!report.layers.empty()) {
    rows += row("Masks", fmt::format("{:.2f} ms each, the slowest {:.2f} ms",
                                     ms(sum) / static_cast<double>(report.layers.size()), ms(slowest)));
  }
  if (report.findings) rows += row("Analysis", findings_line(*report.findings));
  for (const std::string& warning : s.warnings)
    rows += row("Warning", warning);
  if (report.findings) {
    for (const std::string& warning : warnings_about(*report.findings))
      rows += row("Warning", warning);
  }
  return rows;
}

}  // namespace

std::string report_as_html(const PrintReport& report) {
  const std::string job = escaped(report.job);
  const std::string outcome(name_of(report.outcome));
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}: {1}</title>\n<style>{2}</style>\n"
      "<h1>{0}</h1>\n<div class=\"outcome {1}\">{1}{3}</div>\n<div class=\"top\">\n",
      job, outcome, kPageStyle, report.reason.empty() ? "" : ": " + escaped(report.reason));
  if (!report.preview_png.empty()) {
    html += fmt::format("<img alt=\"The part as far as it was printed\" src=\"data:image/png;base64,{}\">\n",
                        base64(report.preview_png));
  }
  html += "<table>\n" + facts(report) + "</table>\n</div>\n";
  if (!report.layers.empty()) {
    html += plot_of(report, "Exposed area, mm² by height", [](const LayerRecord& l) { return l.area_mm2; });
    html += plot_of(report, "Time from height to mask, ms by height",
                    [](const LayerRecord& l) { return ms(l.mask_time); });
    html += plot_of(report, "Contour loops by height", [](const LayerRecord& l) { return l.loops; });
  }
  return html + "</html>\n";
}

}  // namespace contourd
