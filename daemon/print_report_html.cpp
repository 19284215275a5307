#include "daemon/print_report_html.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/base64.hpp"
#include "daemon/html_page.hpp"
#include "daemon/print_findings.hpp"
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

std::string thickness_of(const JobSummary& summary) {
  const double thinnest_um = to_millimeters(summary.layers.thinnest).count() * 1000;
  if (!summary.layers.adaptive) return fmt::format("{:g} um each", thinnest_um);
  return fmt::format("{:g} to {:g} um (cusp {:g} um)", thinnest_um,
                     to_millimeters(summary.layers.thickest).count() * 1000,
                     to_millimeters(summary.layers.adaptive->cusp).count() * 1000);
}

std::string settings_rows(const JobSummary& summary) {
  const ResinProfile& resin = summary.resin;
  std::string rows = row("Resin", describe_settings(summary));
  rows += row("Lift", fmt::format("{:g} mm, {:g} mm/s up, {:g} mm/s down", to_millimeters(resin.lift).count(),
                                  resin.lift_speed.count(), resin.retract_speed.count()));
  rows +=
      row("Waits", fmt::format("{:g} ms before the light, {:g} ms after", ms(resin.settle), ms(resin.rest)));
  const std::string correction = describe_correction(summary);
  if (!correction.empty()) rows += row("Compensation", correction);
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
  return row("Exposure", fmt::format("{:.0f} ms first, {:.0f} ms last", ms(layers.front().exposure_asked),
                                     ms(layers.back().exposure_asked))) +
         row("Light against asked",
             fmt::format("{:.2f} ms at the least, +{:.2f} ms at the most", ms(least), ms(most)));
}

std::string mask_row(const std::vector<LayerRecord>& layers) {
  if (layers.empty()) return "";
  Duration slowest{0}, sum{0};
  for (const LayerRecord& layer : layers) {
    slowest = std::max(slowest, layer.mask_time);
    sum += layer.mask_time;
  }
  return row("Masks", fmt::format("{:.2f} ms each, the slowest {:.2f} ms",
                                  ms(sum) / static_cast<double>(layers.size()), ms(slowest)));
}

// What did not go as it should.
std::string trouble_rows(const PrintReport& report) {
  std::string rows;
  for (const std::string& interruption : report.interruptions)
    rows += row("Interrupted", interruption);
  if (report.late_steps > 0)
    rows += row("Late steps", fmt::format("{}: the computer was too busy for them", report.late_steps));
  if (report.busiest_lit.busy > kLongestLitTurn) {
    rows += row("Late light", fmt::format("by up to {:.0f} ms: the event loop was busy with {}",
                                          ms(report.busiest_lit.busy), report.busiest_lit.source));
  }
  return rows;
}

std::string finding_rows(const PrintReport& report) {
  std::string rows;
  if (report.findings) rows += row("Analysis", findings_line(*report.findings));
  for (const std::string& warning : report.summary.warnings)
    rows += row("Warning", warning);
  if (report.findings) {
    for (const std::string& warning : warnings_about(*report.findings))
      rows += row("Warning", warning);
  }
  return rows;
}

std::string facts(const PrintReport& report) {
  const JobSummary& summary = report.summary;
  std::string rows = row("Printer", report.printer);
  rows += row("Started", iso_time(report.started));
  rows += row("Print time", readable(report.print_time));
  rows += row("Layers", fmt::format("{} of {} exposed, {}", layers_exposed(report.layers),
                                    summary.layers.count, thickness_of(summary)));
  for (const ModelSummary& model : summary.models)
    rows += model_rows(model);
  rows += settings_rows(summary) + exposure_rows(report.layers) + trouble_rows(report);
  rows += row("First mask", fmt::format("{:.1f} ms after its turn came", ms(report.first_mask_after)));
  return rows + mask_row(report.layers) + finding_rows(report);
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
