#include "daemon/report/light_histogram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

struct LightDifference {
  double least_ms, most_ms;
};

LightDifference difference(const LayerRecord& layer) {
  return {milliseconds(layer.exposure_least - layer.exposure_asked),
          milliseconds(layer.exposure_most - layer.exposure_asked)};
}

bool counts(const LayerRecord& layer) {
  return layer.complete && layer.dark_confirmed;
}

std::int64_t bin_of(double ms, double width_ms) {
  return std::llround(ms / width_ms);
}

// Returns the smallest width of 1, 2 or 5 times a power of ten with which kMaxBins bins are enough.
double width_for(const LightDifference& all) {
  for (double power = LightHistogram::kFinest_ms;; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double width = power * factor;
      const std::int64_t bins = bin_of(all.most_ms, width) - bin_of(all.least_ms, width) + 1;
      if (bins <= static_cast<std::int64_t>(LightHistogram::kMaxBins)) return width;
    }
  }
}

constexpr double kChartWidth = 860, kChartHeight = 200, kChartLeft = 84, kChartRight = 10, kTop = 28,
                 kBottom = 40;
constexpr double kLeastBar = 3;  // keeps one layer among thousands visible

std::string bar(const char* name, double x, double width, std::uint64_t layers, std::uint64_t most,
                const std::string& where) {
  if (layers == 0) return "";
  const double full = kChartHeight - kTop - kBottom;
  const double height = std::max(full * static_cast<double>(layers) / static_cast<double>(most), kLeastBar);
  return fmt::format(
      "<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"><title>{} {}: "
      "{}</title></rect>\n",
      name, x, kChartHeight - kBottom - height, width, height, layers, layers == 1 ? "layer" : "layers",
      where);
}

}  // namespace

LightHistogram histogram_of_light(std::span<const LayerRecord> layers) {
  LightHistogram histogram;
  LightDifference all{0, 0};
  for (const LayerRecord& layer : layers) {
    if (!counts(layer)) {
      ++histogram.left_out;
      continue;
    }
    const LightDifference here = difference(layer);
    all = {std::min(all.least_ms, here.least_ms), std::max(all.most_ms, here.most_ms)};
    const double farther = std::abs(here.least_ms) > std::abs(here.most_ms) ? here.least_ms : here.most_ms;
    if (histogram.layers++ == 0 || std::abs(farther) > std::abs(histogram.farthest_ms)) {
      histogram.farthest = layer.layer;
      histogram.farthest_ms = farther;
    }
  }
  if (histogram.layers == 0) return histogram;
  histogram.width_ms = width_for(all);
  const std::int64_t first = bin_of(all.least_ms, histogram.width_ms);
  const std::int64_t last = bin_of(all.most_ms, histogram.width_ms);
  for (std::int64_t bin = first; bin <= last; ++bin)
    histogram.bins.push_back({static_cast<double>(bin) * histogram.width_ms, 0, 0});
  for (const LayerRecord& layer : layers) {
    if (!counts(layer)) continue;
    const LightDifference here = difference(layer);
    const std::int64_t least = bin_of(here.least_ms, histogram.width_ms) - first;
    const std::int64_t most = bin_of(here.most_ms, histogram.width_ms) - first;
    ++histogram.bins[static_cast<std::size_t>(least)].least;
    ++histogram.bins[static_cast<std::size_t>(most)].most;
    histogram.exact = histogram.exact && least == most;
  }
  return histogram;
}

std::string svg_of(const LightHistogram& histogram) {
  expects(!histogram.bins.empty(), "a histogram has bins");
  std::uint64_t highest = 1;
  for (const LightBin& bin : histogram.bins)
    highest = std::max({highest, bin.least, bin.most});
  const double step = (kChartWidth - kChartLeft - kChartRight) / static_cast<double>(histogram.bins.size());
  const double base = kChartHeight - kBottom, width = std::min(step, 90.0);
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"Layers by actual minus requested "
      "exposure, in milliseconds\">\n"
      "<line class=\"grid\" x1=\"{2}\" x2=\"{3}\" y1=\"{4}\" y2=\"{4}\"/>"
      "<text x=\"{5}\" y=\"{6}\" text-anchor=\"end\">{7}</text>\n"
      "<line class=\"grid\" x1=\"{2}\" x2=\"{3}\" y1=\"{8}\" y2=\"{8}\"/>"
      "<text x=\"{5}\" y=\"{9}\" text-anchor=\"end\">0</text>\n",
      kChartWidth, kChartHeight, kChartLeft, kChartWidth - kChartRight, kTop, kChartLeft - 8, kTop + 4,
      highest, base, base + 4);
  // About seven labels, one of them at 0.
  const auto labels = static_cast<std::int64_t>((histogram.bins.size() + 6) / 7);
  for (std::size_t i = 0; i < histogram.bins.size(); ++i) {
    const LightBin& bin = histogram.bins[i];
    const double middle = kChartLeft + (static_cast<double>(i) + 0.5) * step;
    const std::string where = fmt::format("{:+.6g} ms", bin.middle_ms);
    if (histogram.exact) {
      svg += bar("most", middle - width * 0.4, width * 0.8, bin.most, highest, where);
    } else {
      svg += bar("least", middle - width * 0.42, width * 0.4, bin.least, highest, where + " at least");
      svg += bar("most", middle + width * 0.02, width * 0.4, bin.most, highest, where + " at most");
    }
    const std::int64_t from_zero = std::llround(bin.middle_ms / histogram.width_ms);
    if (from_zero % labels != 0) continue;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", middle,
                       base + 26, from_zero == 0 ? "as requested" : where);
  }
  return svg + "</svg>\n";
}

}  // namespace contourd
