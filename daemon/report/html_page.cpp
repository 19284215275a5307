#include "daemon/report/html_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr double kPlotWidth = 860, kPlotHeight = 190;
constexpr double kPlotLeft = 120, kPlotRight = 24, kPlotBottom = 48, kPlotTop = 24;
// The largest number of points in a plot. Of more points, the largest of each group is drawn, so that no peak
// vanishes.
constexpr std::size_t kMaxPoints = 800;

std::vector<PlotPoint> thinned(std::span<const PlotPoint> points) {
  if (points.size() <= kMaxPoints) return {points.begin(), points.end()};
  std::vector<PlotPoint> thin;
  const std::size_t group = (points.size() + kMaxPoints - 1) / kMaxPoints;
  for (std::size_t i = 0; i < points.size(); i += group) {
    const auto some = points.subspan(i, std::min(group, points.size() - i));
    thin.push_back(*std::ranges::max_element(some, {}, &PlotPoint::value));
  }
  return thin;
}

std::string without_tags(const std::string& html) {
  std::string text;
  bool in_tag = false;
  for (const char c : html) {
    in_tag = in_tag || c == '<';
    if (!in_tag) text += c;
    in_tag = in_tag && c != '>';
  }
  return text;
}

// Rounds up to 1, 2, 2.5 or 5 times a power of ten.
double round_up(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 2.5, 5.0}) {
    if (value <= step * power) return step * power;
  }
  return 10 * power;
}

}  // namespace

std::string page_start(const std::string& title, std::string_view style) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}{}</style>\n",
      title, kPageStyle, style);
}

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

std::string table_row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
}

std::string svg_plot(const std::string& title, std::span<const PlotPoint> all) {
  expects_costly([&] { return std::ranges::is_sorted(all, {}, &PlotPoint::height_mm); }, "heights rise");
  const std::vector<PlotPoint> points = thinned(all);
  double top = 0, right = 0;
  for (const PlotPoint& p : points) {
    top = std::max(top, p.value);
    right = std::max(right, p.height_mm);
  }
  top = round_up(top);
  right = right > 0 ? right : 1;
  const auto x = [&](double height) {
    return kPlotLeft + height / right * (kPlotWidth - kPlotLeft - kPlotRight);
  };
  const auto y = [&](double value) {
    return kPlotTop + (1 - value / top) * (kPlotHeight - kPlotTop - kPlotBottom);
  };
  std::string svg = fmt::format("<h2>{}</h2>\n<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n",
                                title, kPlotWidth, kPlotHeight, without_tags(title));
  for (const double part : {0.0, 0.5, 1.0}) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        kPlotLeft, kPlotWidth - kPlotRight, y(top * part), kPlotLeft - 8, y(top * part) + 4, top * part);
  }
  // About five round heights.
  const double step = round_up(right / 5);
  for (int i = 0; i * step <= right; ++i) {
    const double height = i * step;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:g}{}</text>\n", x(height),
                       kPlotHeight - kPlotBottom + 26, height, height == 0 ? " mm" : "");
  }
  svg += "<polyline class=\"curve\" points=\"";
  for (const PlotPoint& p : points)
    svg += fmt::format("{:.1f},{:.1f} ", x(p.height_mm), y(p.value));
  return svg + "\"/>\n</svg>\n";
}

}  // namespace contourd
