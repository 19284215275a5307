#include "daemon/ctl/models/statistics_text.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace contourd::ctl {

using Json = nlohmann::ordered_json;

void print_statistics(const LayerStatistics& s) {
  fmt::print("{:<20} {:>12} {:>12}\n", "", "mean", "SD");
  const auto row = [](const char* name, const MeanAndDeviation& v) {
    fmt::print("{:<20} {:>12.4f} {:>12.4f}\n", name, v.mean, v.deviation);
  };
  row("slicing ms", s.slicing_ms);
  row("contour ms", s.contour_ms);
  row("total ms", s.total_ms);
  row("intersecting facets", s.intersecting_facets);
  row("loop count", s.loop_count);
  fmt::print(
      "\nnormalized correlation of the contour time with the loop count {:.2f}, with the intersecting facets "
      "{:.2f}\n",
      s.contour_time_vs_loop_count, s.contour_time_vs_intersecting_facets);
}

Json statistics_json(const LayerStatistics& statistics) {
  const auto both = [](const MeanAndDeviation& v) { return Json{{"mean", v.mean}, {"sd", v.deviation}}; };
  return {{"slicing_ms", both(statistics.slicing_ms)},
          {"contour_ms", both(statistics.contour_ms)},
          {"total_ms", both(statistics.total_ms)},
          {"intersecting_facets", both(statistics.intersecting_facets)},
          {"loop_count", both(statistics.loop_count)},
          {"correlation_contour_time_loop_count", statistics.contour_time_vs_loop_count},
          {"correlation_contour_time_intersecting_facets", statistics.contour_time_vs_intersecting_facets}};
}

std::string layers_text(std::span<const Nanometers> thicknesses) {
  if (thicknesses.empty()) return "0";
  const auto [thinnest, thickest] = std::minmax_element(thicknesses.begin(), thicknesses.end());
  const auto um = [](Nanometers thickness) { return to_millimeters(thickness).count() * 1000; };
  return *thinnest == *thickest
             ? fmt::format("{} of {:g} um", thicknesses.size(), um(*thinnest))
             : fmt::format("{} of {:g} to {:g} um", thicknesses.size(), um(*thinnest), um(*thickest));
}

}  // namespace contourd::ctl
