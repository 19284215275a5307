#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/print_report.hpp"
#include "daemon/readable.hpp"

namespace contourd {
namespace {

constexpr double kPlotWidth = 860, kPlotHeight = 190;
constexpr double kPlotLeft = 64, kPlotBottom = 34, kPlotTop = 14;
// More points than a plot has room for are drawn as the largest of each group: peaks must not vanish.
constexpr std::size_t kMostPoints = 800;

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --ink: #1d2733; --paper: #fbfbfa; --line: #c9ced6; --accent: #6a3fb5; }
@media (prefers-color-scheme: dark) { :root { --ink: #dfe4ea; --paper: #14181d; --line: #3a4450; --accent: #b99af0; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.05rem; margin: 1.8rem 0 .4rem; }
.outcome { font-weight: 600; } .done { color: #1d8348; } .failed, .cancelled { color: #c0392b; }
.top { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: flex-start; margin-top: 1rem; }
.top img { width: 22rem; max-width: 100%; border-radius: 6px; background: #000; }
table { border-collapse: collapse; } td, th { text-align: left; padding: .15rem 1.2rem .15rem 0; vertical-align: top; }
th { font-weight: 400; opacity: .7; } svg { width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: var(--ink); } svg .grid { stroke: var(--line); stroke-width: 1; }
svg .curve { fill: none; stroke: var(--accent); stroke-width: 1.5; stroke-linejoin: round; }
)";

// Text from a file name or an error message, safe inside HTML.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j)
      group = group << 8 | (i + j < bytes.size() ? bytes[i + j] : 0U);
    const std::size_t digits = std::min<std::size_t>(bytes.size() - i, 3) + 1;
    for (std::size_t j = 0; j < 4; ++j)
      text += j < digits ? kDigits[group >> (18 - 6 * j) & 63U] : '=';
  }
  return text;
}

struct PlotPoint {
  double height_mm, value;
};

std::vector<PlotPoint> thinned(const std::vector<PlotPoint>& points) {
  if (points.size() <= kMostPoints) return points;
  std::vector<PlotPoint> thin;
  const std::size_t group = (points.size() + kMostPoints - 1) / kMostPoints;
  for (std::size_t i = 0; i < points.size(); i += group) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(i);
    const auto end = points.begin() + static_cast<std::ptrdiff_t>(std::min(i + group, points.size()));
    thin.push_back(*std::max_element(
        begin, end, [](const PlotPoint& a, const PlotPoint& b) { return a.value < b.value; }));
  }
  return thin;
}

// The next of 1, 2, 2.5, 5 times a power of ten.
double round_up(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (value <= step * power) return step * power;
  }
  return 10 * power;
}

std::string plot(const std::string& title, const std::vector<PlotPoint>& all) {
  const std::vector<PlotPoint> points = thinned(all);
  double top = 0, right = 0;
  for (const PlotPoint& p : points) {
    top = std::max(top, p.value);
    right = std::max(right, p.height_mm);
  }
  top = round_up(top);
  right = right > 0 ? right : 1;
  const auto x = [&](double height) { return kPlotLeft + height / right * (kPlotWidth - kPlotLeft - 10); };
  const auto y = [&](double value) {
    return kPlotTop + (1 - value / top) * (kPlotHeight - kPlotTop - kPlotBottom);
  };
  std::string svg = fmt::format("<h2>{}</h2>\n<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n",
                                title, kPlotWidth, kPlotHeight, title);
  for (const double part : {0.0, 0.5, 1.0}) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        kPlotLeft, kPlotWidth - 10, y(top * part), kPlotLeft - 8, y(top * part) + 4, top * part);
  }
  // About five round heights.
  const double step = round_up(right / 5);
  for (int i = 0; i * step <= right; ++i) {
    const double height = i * step;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:g}{}</text>\n", x(height),
                       kPlotHeight - kPlotBottom + 18, height, height == 0 ? " mm" : "");
  }
  svg += "<polyline class=\"curve\" points=\"";
  for (const PlotPoint& p : points)
    svg += fmt::format("{:.1f},{:.1f} ", x(p.height_mm), y(p.value));
  return svg + "\"/>\n</svg>\n";
}

template <typename Value>
std::string plot_of(const PrintReport& report, const std::string& title, Value&& value) {
  std::vector<PlotPoint> points;
  for (const LayerRecord& layer : report.layers) {
    points.push_back({to_millimeters(layer.mask_height).count(), static_cast<double>(value(layer))});
  }
  return plot(title, points);
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
}

double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

std::string facts(const PrintReport& report) {
  const JobSummary& s = report.summary;
  std::string rows;
  rows += row("Printer", report.printer);
  rows += row("Started", iso_time(report.started));
  rows += row("Print time", readable(report.print_time));
  rows += row("Layers", fmt::format("{} of {} exposed, {:g} um each", report.layers.size(), s.layers.count,
                                    to_millimeters(s.layers.thickness).count() * 1000));
  rows += row("Size", fmt::format("{:.2f} x {:.2f} x {:.2f} mm", s.size_x_mm, s.size_y_mm, s.size_z_mm));
  rows += row("Model", fmt::format("{} facets, {}, {}", s.mesh.facets, name_of(s.format),
                                   s.mesh.watertight ? "watertight" : "not watertight"));
  if (s.copies != 1) rows += row("Copies", std::to_string(s.copies));
  if (s.scale != 1) rows += row("Scale", fmt::format("{:.4g}", s.scale));
  rows += row("Resin", s.resin.name);
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
    Duration worst{0};
    for (const LayerRecord& layer : report.layers) {
      worst = std::max(worst, std::chrono::abs(layer.exposure_measured - layer.exposure_asked));
    }
    rows += row("Measured against asked", fmt::format("at most {:.2f} ms off", ms(worst)));
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
  for (const std::string& warning : s.warnings)
    rows += row("Warning", warning);
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
      job, outcome, kStyle, report.reason.empty() ? "" : ": " + escaped(report.reason));
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
