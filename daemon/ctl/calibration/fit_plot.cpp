#include "daemon/ctl/calibration/fit_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/contract/expects.hpp"
#include "core/mask/mask.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/base64.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

constexpr double kWidth = 860, kHeight = 420, kLeft = 84, kRight = 16, kTop = 16, kBottom = 64;
constexpr double kBand = 2;       // standard uncertainties
constexpr double kMargin = 0.05;  // around the points, as a share of their range
constexpr double kTicks = 6;      // number on an axis, about
constexpr int kMapSide = 192;     // pixels of the map's longer side
constexpr std::array kColours{"--accent", "--good", "--bad", "--ink"};

// Values from `least` to `most` on an axis of the plot.
class Axis {
 public:
  Axis(double from, double to, Scale scale) : from_(from), to_(to), scale_(scale) {}

  void include(double value) {
    least_ = std::min(least_, scaled(value));
    most_ = std::max(most_, scaled(value));
  }
  void widen() {
    const double range = most_ - least_;
    const double by = range > 0 ? kMargin * range : 1;
    least_ -= by;
    most_ += by;
  }
  [[nodiscard]] double place(double value) const {
    return from_ + (scaled(value) - least_) / (most_ - least_) * (to_ - from_);
  }
  // Returns round values on the axis.
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> ticks;
    if (scale_ == Scale::Logarithmic) {
      for (int power = static_cast<int>(std::floor(least_ / std::log(10.0))); power * std::log(10.0) < most_;
           ++power)
        for (const double factor : {1.0, 2.0, 5.0})
          add(ticks, factor * std::pow(10, power));
      return ticks;
    }
    const double power = std::pow(10, std::floor(std::log10((most_ - least_) / kTicks)));
    double step = power;
    for (const double factor : {2.0, 5.0, 10.0})
      if ((most_ - least_) / step > kTicks) step = factor * power;
    for (double i = std::ceil(least_ / step); i * step <= most_; ++i)
      ticks.push_back(i * step);
    return ticks;
  }

 private:
  [[nodiscard]] double scaled(double value) const {
    return scale_ == Scale::Logarithmic ? std::log(value) : value;
  }
  void add(std::vector<double>& ticks, double value) const {
    if (scaled(value) >= least_ && scaled(value) <= most_) ticks.push_back(value);
  }

  double from_, to_;
  Scale scale_;
  double least_ = std::numeric_limits<double>::infinity(), most_ = -least_;
};

std::string grid_of(const FitPlot& plot, const Axis& x, const Axis& y) {
  std::string svg;
  for (const double value : y.ticks())
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/><text x=\"{3}\" "
        "y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:.6g}</text>\n",
        kLeft, kWidth - kRight, y.place(value), kLeft - 8, y.place(value) + 4, value);
  for (const double value : x.ticks())
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/><text x=\"{0:.1f}\" "
        "y=\"{3}\" "
        "text-anchor=\"middle\">{4:.6g}</text>\n",
        x.place(value), kTop, kHeight - kBottom, kHeight - kBottom + 20, value);
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                     (kLeft + kWidth - kRight) / 2, kHeight - kBottom + 46, escaped(plot.x_heading));
  return svg + fmt::format(
                   "<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                   (kTop + kHeight - kBottom) / 2, escaped(plot.y_heading));
}

std::string drawn(const PlottedFit& fit, const char* colour, const Axis& x, const Axis& y) {
  std::string line, upper, lower;
  for (const PlottedPoint& each : fit.line) {
    const auto point = [&](double of) { return fmt::format("{:.1f},{:.1f} ", x.place(each.x), y.place(of)); };
    line += point(each.y);
    upper += point(each.y + kBand * each.uncertainty);
    lower.insert(0, point(each.y - kBand * each.uncertainty));
  }
  std::string svg = fmt::format(
      "<polygon points=\"{}{}\" fill=\"var({})\" opacity=\".15\"/>\n<polyline class=\"curve\" "
      "style=\"stroke: "
      "var({})\" points=\"{}\"/>\n",
      upper, lower, colour, colour, line);
  for (const PlottedPoint& point : fit.measured)
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"var({})\"><title>{}{:.6g}: "
        "{:.6g}</title></circle>\n",
        x.place(point.x), y.place(point.y), colour, fit.name.empty() ? "" : escaped(fit.name) + " ", point.x,
        point.y);
  return svg;
}

// Returns colours from dark violet through red to light yellow.
Palette palette_of_light() {
  Palette palette{};
  for (std::size_t i = 0; i < palette.size(); ++i) {
    const double share = static_cast<double>(i) / 255;
    const auto part = [](double value) {
      return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
    };
    palette[i] = {part(0.2 + 1.4 * share), part(1.6 * share - 0.6),
                  part(0.4 + 0.5 * share * (2 * share - 1))};
  }
  return palette;
}

}  // namespace

std::string svg_of_fit(const FitPlot& plot) {
  expects(!plot.fits.empty() && !plot.fits.front().measured.empty(), "a plot shows a measurement");
  Axis x(kLeft, kWidth - kRight, plot.x_scale), y(kHeight - kBottom, kTop, Scale::Linear);
  for (const PlottedFit& fit : plot.fits)
    for (const auto* points : {&fit.measured, &fit.line})
      for (const PlottedPoint& point : *points) {
        expects(plot.x_scale == Scale::Linear || point.x > 0, "a logarithmic scale shows positive values");
        x.include(point.x);
        y.include(point.y - kBand * point.uncertainty);
        y.include(point.y + kBand * point.uncertainty);
      }
  x.widen();
  y.widen();
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{} by {}\">\n", kWidth,
                                kHeight, escaped(plot.y_heading), escaped(plot.x_heading));
  svg += grid_of(plot, x, y);
  std::string legend;
  for (std::size_t i = 0; i < plot.fits.size(); ++i) {
    const char* const colour = kColours[i % kColours.size()];
    svg += drawn(plot.fits[i], colour, x, y);
    if (!plot.fits[i].name.empty())
      legend += fmt::format("<span class=\"swatch\" style=\"background: var({})\"></span>{} &ensp;", colour,
                            escaped(plot.fits[i].name));
  }
  return svg + "</svg>\n<p>" + legend +
         "Dots are measurements, the line is the fit, the band around it two standard deviations wide to "
         "each side.</p>\n";
}

std::string map_of_lamp(const LampFit& lamp, std::span<const LampReading> readings, double aspect) {
  expects(aspect > 0, "a display has an aspect");
  const auto side = [](double share) {
    return Pixels{std::max(1, static_cast<std::int32_t>(std::lround(kMapSide * std::min(1.0, share))))};
  };
  Mask map(side(aspect), side(1 / aspect));
  const double width = map.width().count(), height = map.height().count();
  const double range = lamp.brightest.light - lamp.darkest.light;
  for (std::int32_t y = 0; y < map.height().count(); ++y)
    for (std::int32_t x = 0; x < map.width().count(); ++x) {
      const double light = lamp.surface.at({(2 * x + 1) / width - 1, (2 * y + 1) / height - 1}).value;
      const double share = std::clamp((light - lamp.darkest.light) / range, 0.0, 1.0);
      map.row(y)[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(std::lround(255 * share));
    }
  const Palette palette = palette_of_light();
  std::string html = fmt::format(
      "<div class=\"shot\"><img alt=\"Map of the light\" src=\"data:image/png;base64,{}\">\n<svg viewBox=\"0 "
      "0 {} {}\" "
      "preserveAspectRatio=\"none\">\n",
      base64(encode_png(map, &palette)), width, height);
  for (const auto& [place, light] : readings)
    html += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2\"><title>measured {:.4g}, fitted "
        "{:.4g}</title></circle>\n",
        (place.x + 1) / 2 * width, (place.y + 1) / 2 * height, light, lamp.surface.at(place).value);
  return html +
         fmt::format(
             "</svg></div>\n<p>The light from {:.4g} (dark) to {:.4g} (bright), as pictures are sent to "
             "the display. Circles are readings.</p>\n",
             lamp.darkest.light, lamp.brightest.light);
}

}  // namespace contourd::ctl
