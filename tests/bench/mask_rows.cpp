#include <fmt/format.h>

#include "core/formats/model_reader.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/shapes.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/bench/thesis_baseline.hpp"

namespace contourd::bench {
namespace {

constexpr Nanometers kRise{10'000};
constexpr int kWarmUp = 50, kPasses = 3, kBaselinePlanes = 15;

struct MaskSubject {
  std::string id, name;
  std::filesystem::path file;
};

std::vector<std::string> ids_of(const std::string& model) {
  return {"mask-random-" + model + "-p50", "mask-random-" + model + "-p99", "mask-rising-" + model + "-p99",
          "mask-4k-" + model + "-p99"};
}

Row row_of(std::string id, std::string what, const Times& times, double percent, double target_ms) {
  Row row{std::move(id), std::move(what), "ms"};
  row.figure = percentile(times.wall_s, percent) * 1e3;
  row.cpu = percentile(times.cpu_s, percent) * 1e3;
  row.target = Target{Target::Kind::AtMost, target_ms};
  return row;
}

Times at_random_heights(const Bench& bench, ContourEngine& engine) {
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(2000));
  for (int i = 0; i < bench.runs(kWarmUp); ++i)
    (void)engine.mask_at_z(heights[static_cast<std::size_t>(i)]);
  return best_of_passes(kPasses, heights, [&](Millimeters z) { (void)engine.mask_at_z(z); });
}

Times at_rising_heights(const Bench& bench, ContourEngine& engine) {
  const Nanometers top = to_nanometers(Millimeters{engine.model().bounds().size_z()}).value();
  const Nanometers rise = bench.quick ? Nanometers{10'000'000} : kRise;
  std::vector<Nanometers> heights;
  for (Nanometers height{0}; height < top; height += rise)
    heights.push_back(height);
  return best_of_passes(kPasses, heights, [&](Nanometers height) { (void)engine.mask_at(height); });
}

// Returns the number of segments in the random planes: mean and percentiles.
std::string segments_of(const Bench& bench, const ContourEngine& engine) {
  Section section;
  std::vector<double> counts;
  double sum = 0;
  for (const Millimeters z : random_heights(engine.model().bounds(), bench.runs(500))) {
    slice_at(engine.model(), z, section);
    counts.push_back(static_cast<double>(section.segments.size()));
    sum += counts.back();
  }
  return fmt::format("{} facets; segments a plane: mean {:.0f}, p50 {:.0f}, p99 {:.0f}",
                     engine.model().facets().size(), sum / static_cast<double>(counts.size()), median(counts),
                     percentile(counts, 99));
}

Peer run_baseline(const Bench& bench, const HeightIndex& model) {
  ThesisSlicer slicer(model.facets(), 1920, 1080);
  Times times;
  for (const Millimeters z : random_heights(model.bounds(), bench.runs(kBaselinePlanes)))
    time_once(times, [&] { (void)slicer.contours_at(static_cast<float>(z.count())); });
  return {"thesis's algorithms, contours alone", median(times.wall_s) * 1e3, false,
          median(times.cpu_s) * 1e3};
}

std::vector<Row> mask_rows_of(const Bench& bench, const MaskSubject& subject) {
  const std::vector<std::string> ids = ids_of(subject.id);
  ContourEngine engine = fitted_engine(subject.file, Pixels{1920}, Pixels{1080});
  const Times random = at_random_heights(bench, engine);
  const Times rising = at_rising_heights(bench, engine);
  ContourEngine large = fitted_engine(subject.file, Pixels{3840}, Pixels{2160});
  const Times at_4k = at_random_heights(bench, large);
  const std::string name = subject.name + ", one grey mask ";
  std::vector<Row> rows{row_of(ids[0], name + "1920x1080 at random heights, p50", random, 50, 0.4),
                        row_of(ids[1], name + "1920x1080 at random heights, p99", random, 99, 0.8),
                        row_of(ids[2], name + "1920x1080 rising by 10 um, p99", rising, 99, 0.5),
                        row_of(ids[3], name + "3840x2160 at random heights, p99", at_4k, 99, 1.5)};
  rows[0].peers.push_back(run_baseline(bench, engine.model()));
  rows[0].note = segments_of(bench, engine);
  return rows;
}

// Measures masks of prisms that all overlap their neighbours.
Row crossing_row(const Bench& bench) {
  constexpr int kSides = 36;
  models::Facets facets;
  for (int i = 0; i < kFieldColumns * kFieldRows; ++i) {
    const models::Facets one = prism({kSides, 1, 0.6, 1}, i % kFieldColumns + 0.5, i / kFieldColumns + 0.5);
    facets.insert(facets.end(), one.begin(), one.end());
  }
  const DisplayGeometry display{Pixels{1920}, Pixels{1080}, Micrometers{25}};
  ContourEngine engine(HeightIndex(std::move(facets)), EngineSettings{display, AntiAliasing::On},
                       {PixelMap::true_scale(display, {kFieldColumns / 2.0, kFieldRows / 2.0})});
  const std::vector<Millimeters> heights = random_heights(engine.model().bounds(), bench.runs(50));
  const Times times = best_of_passes(kPasses, heights, [&](Millimeters z) { (void)engine.mask_at_z(z); });
  Row row = row_of("mask-crossing", "1,296 bodies that overlap, one grey mask 1920x1080, p50", times, 50, 16);
  row.note = fmt::format("{} segments", engine.intersecting_facets());
  return row;
}

}  // namespace

std::vector<Row> mask_rows(const Bench& bench) {
  const auto plate = bench.models.shared(kPlate);
  std::vector<Row> rows =
      plate ? mask_rows_of(bench, {"plate", "plate", *plate}) : skipped_rows(ids_of("plate"), kPlate);
  for (Row& row : mask_rows_of(bench, {"gyroid", "gyroid", bench.models.gyroid()}))
    rows.push_back(std::move(row));
  rows.push_back(crossing_row(bench));
  return rows;
}

}  // namespace contourd::bench
