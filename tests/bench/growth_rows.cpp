#include <fmt/format.h>

#include "tests/bench/bench.hpp"
#include "tests/bench/shapes.hpp"
#include "tests/bench/stopwatch.hpp"

namespace contourd::bench {
namespace {

const DisplayGeometry kGrowthDisplay{Pixels{1920}, Pixels{1080}, Micrometers{25}};

ContourEngine engine_for(models::Facets facets, Point center) {
  return ContourEngine(HeightIndex(std::move(facets)), EngineSettings{kGrowthDisplay, AntiAliasing::On},
                       {PixelMap::true_scale(kGrowthDisplay, center)});
}

// Returns the medians at random heights.
struct Medians {
  double wall_us, cpu_us;
};

template <typename Function>
Medians medians_of(const Bench& bench, const ContourEngine& engine, Function&& at_height) {
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(200));
  for (const Millimeters z : heights)
    at_height(z);  // warm-up
  const Times times = best_of_passes(3, heights, at_height);
  return {median(times.wall_s) * 1e6, median(times.cpu_s) * 1e6};
}

// Measures a column whose walls are divided ever more finely: every plane crosses 1000 facets.
Row facets_row(const Bench& bench) {
  std::vector<Medians> medians;
  Row row{"growth-facets", "", "x"};
  for (const int bands : {10, 100, bench.quick ? 200 : 1300}) {
    ContourEngine engine = engine_for(prism({500, bands, 12, 40}, 0, 0), {0, 0});
    const Medians m = medians_of(bench, engine, [&](Millimeters z) { (void)engine.mask_at_z(z); });
    row.note += fmt::format("{}{} facets {:.1f} us", medians.empty() ? "" : "; ",
                            engine.model().facets().size(), m.cpu_us);
    medians.push_back(m);
  }
  row.what = "time a mask (1000 segments): of 1.3 million facets over 11,000";
  row.figure = medians.back().wall_us / medians.front().wall_us;
  row.cpu = medians.back().cpu_us / medians.front().cpu_us;
  row.note += " of CPU a mask; flat is 1";
  return row;
}

struct SegmentCosts {
  std::vector<double> segments, wall_us, cpu_us;
};

// Returns the time per segment at 30,000 segments, divided by that at 1,000.
double per_segment(const std::vector<double>& segments, const std::vector<double>& times) {
  return times.back() / segments.back() / (times.front() / segments.front());
}

Row segments_row(const std::string& id, const std::string& what, const SegmentCosts& costs) {
  Row row{id, what + " per segment: at 30,000 over at 1,000", "x"};
  row.figure = per_segment(costs.segments, costs.wall_us);
  row.cpu = per_segment(costs.segments, costs.cpu_us);
  const Line line = fit_line(costs.segments, costs.cpu_us);
  for (std::size_t i = 0; i < costs.segments.size(); ++i)
    row.note += fmt::format("{:.0f} segments {:.0f} us; ", costs.segments[i], costs.cpu_us[i]);
  row.note += fmt::format("CPU; {:.0f} us + {:.1f} ns a segment, off by {:.0f} % at most", line.at_zero,
                          line.slope * 1e3, line.worst_deviation * 100);
  return row;
}

std::vector<Row> segments_rows(const Bench& bench) {
  SegmentCosts masks, contours;
  const auto add = [](SegmentCosts& costs, double segments, const Medians& medians) {
    costs.segments.push_back(segments);
    costs.wall_us.push_back(medians.wall_us);
    costs.cpu_us.push_back(medians.cpu_us);
  };
  constexpr int kSegmentsEach = 32;
  for (const int prisms : {31, 94, 313, 938}) {
    ContourEngine engine = engine_for(field_of_prisms(prisms), {kFieldColumns / 2.0, kFieldRows / 2.0});
    const double segments = prisms * kSegmentsEach;
    add(masks, segments, medians_of(bench, engine, [&](Millimeters z) { (void)engine.mask_at_z(z); }));
    add(contours, segments, medians_of(bench, engine, [&](Millimeters z) {
          (void)engine.contours_at(to_nanometers(z).value());
        }));
  }
  return {segments_row("growth-segments-mask", "a mask's time", masks),
          segments_row("growth-segments-contours", "linked contours' time", contours)};
}

}  // namespace

std::vector<Row> growth_rows(const Bench& bench) {
  std::vector<Row> rows = segments_rows(bench);
  rows.insert(rows.begin(), facets_row(bench));
  return rows;
}

}  // namespace contourd::bench
