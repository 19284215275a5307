#include "daemon/ctl/models/layer_measurements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::pair<const char*, MeanAndDeviation LayerStatistics::*> kRows[] = {
    {"slicing_ms", &LayerStatistics::slicing_ms},
    {"contour_ms", &LayerStatistics::contour_ms},
    {"total_ms", &LayerStatistics::total_ms},
    {"intersecting_facets", &LayerStatistics::intersecting_facets},
    {"loop_count", &LayerStatistics::loop_count}};

}  // namespace

LayerMeasurement LayerStopwatch::measure(const HeightIndex& model, Millimeters z, Millimeters tolerance) {
  using Clock = std::chrono::steady_clock;
  const auto ms = [](Clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
  };
  const auto start = Clock::now();
  slice_at(model, z, section_);
  const auto sliced = Clock::now();
  linker_.link(section_.segments, tolerance, contours_);
  const auto joined = Clock::now();
  return {z, ms(sliced - start), ms(joined - sliced), section_.intersecting_facets,
          static_cast<std::uint32_t>(contours_.loops.size())};
}

void print_statistics(const LayerStatistics& s) {
  fmt::print("{:<20} {:>12} {:>12}\n", "", "mean", "SD");
  for (const auto& [name, values] : kRows) {
    std::string words = name;
    std::ranges::replace(words, '_', ' ');
    fmt::print("{:<20} {:>12.4f} {:>12.4f}\n", words, (s.*values).mean, (s.*values).deviation);
  }
  fmt::print(
      "\nnormalized correlation of the contour time with the loop count {:.2f}, with the intersecting facets "
      "{:.2f}\n",
      s.contour_time_vs_loop_count, s.contour_time_vs_intersecting_facets);
}

Json statistics_json(const LayerStatistics& s) {
  Json json;
  for (const auto& [name, values] : kRows)
    json[name] = {{"mean", (s.*values).mean}, {"sd", (s.*values).deviation}};
  json["correlation_contour_time_loop_count"] = s.contour_time_vs_loop_count;
  json["correlation_contour_time_intersecting_facets"] = s.contour_time_vs_intersecting_facets;
  return json;
}

std::string statistics_csv(const LayerStatistics& s) {
  std::string csv = "measurement,mean,standard_deviation\n";
  for (const auto& [name, values] : kRows)
    csv += fmt::format("{},{:.6f},{:.6f}\n", name, (s.*values).mean, (s.*values).deviation);
  return csv + fmt::format(
                   "normalized_correlation_contour_time_vs_loop_count,{:.6f},\n"
                   "normalized_correlation_contour_time_vs_intersecting_facets,{:.6f},\n",
                   s.contour_time_vs_loop_count, s.contour_time_vs_intersecting_facets);
}

std::string measurements_csv(std::span<const LayerMeasurement> layers) {
  std::string csv = "layer,z_mm,slicing_ms,contour_ms,total_ms,intersecting_facets,loop_count\n";
  std::size_t number = 0;
  for (const LayerMeasurement& l : layers)
    csv += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{},{}\n", ++number, l.z.count(), l.slicing_ms,
                       l.contour_ms, l.total_ms(), l.intersecting_facets, l.loop_count);
  return csv;
}

std::string layers_text(std::span<const Nanometers> thicknesses) {
  if (thicknesses.empty()) return "0";
  const auto [thinnest, thickest] = std::ranges::minmax(thicknesses);
  const auto um = [](Nanometers thickness) { return to_millimeters(thickness).count() * 1000; };
  return fmt::format("{} of {:g}{} um", thicknesses.size(), um(thinnest),
                     thinnest == thickest ? "" : fmt::format(" to {:g}", um(thickest)));
}

}  // namespace contourd::ctl
