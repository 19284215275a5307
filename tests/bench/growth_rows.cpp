#include <fmt/format.h>

#include "tests/bench/bench.hpp"
#include "tests/bench/shapes.hpp"
#include "tests/bench/stopwatch.hpp"

namespace contourd::bench {
namespace {

const DisplayGeometry kDisplay{Pixels{1920}, Pixels{1080}, Micrometers{25}};

ContourEngine engine_for(models::Facets facets, Point center) {
  return ContourEngine(HeightIndex(std::move(facets)), kDisplay, AntiAliasing::On,
                       {PixelMap::true_scale(kDisplay, center)});
}

// Medians at random heights.
struct Medians {
  double wall_us, cpu_us;
};

template <typename Function>
Medians medians_of(const Bench& bench, const ContourEngine& engine, Function&& at_height) {
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(400));
  for (const Millimeters z : heights)
    at_height(z);
  Times times;
  for (const Millimeters z : heights)
    time_once(times, [&] { at_height(z); });
  return {median(times.wall_s) * 1e6, median(times.cpu_s) * 1e6};
}

// A column whose walls are divided ever finer: every plane crosses 1000 facets.
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

// The slope from 10,000 to 30,000 segments over that from 1,000 to 10,000.
double bend(const std::vector<double>& x, const std::vector<double>& y) {
  return (y[3] - y[2]) / (x[3] - x[2]) / ((y[2] - y[0]) / (x[2] - x[0]));
}

Row segments_row(const std::string& id, const std::string& what, const SegmentCosts& costs) {
  Row row{id, what + ": slope at 10k-30k segments over that at 1k-10k", "x"};
  row.figure = bend(costs.segments, costs.wall_us);
  row.cpu = bend(costs.segments, costs.cpu_us);
  const Line line = fit_line(costs.segments, costs.cpu_us);
  for (std::size_t i = 0; i < costs.segments.size(); ++i)
    row.note += fmt::format("{:.0f} segments {:.0f} us; ", costs.segments[i], costs.cpu_us[i]);
  row.note += fmt::format("CPU; {:.0f} us + {:.1f} ns a segment, off by {:.0f} % at most; linear is 1",
                          line.at_zero, line.slope * 1e3, line.worst_deviation * 100);
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
  return {segments_row("growth-segments-mask", "time a mask", masks),
          segments_row("growth-segments-contours", "time of linked contours", contours)};
}

}  // namespace

std::vector<Row> growth_rows(const Bench& bench) {
  std::vector<Row> rows = segments_rows(bench);
  rows.insert(rows.begin(), facets_row(bench));
  return rows;
}

}  // namespace contourd::bench
