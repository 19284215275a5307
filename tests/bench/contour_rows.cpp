#include <fmt/format.h>

#include "core/formats/model_reader.hpp"
#include "core/layers/layers.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/peers.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/bench/thesis_baseline.hpp"

namespace contourd::bench {
namespace {

constexpr Millimeters kTolerance{0.05};
constexpr int kQuickLayers = 20;

struct ContourSubject {
  std::string id, name, file;
  double target_s;
  std::vector<Peer> cited;
};

std::vector<double> layer_heights(const Bounds& bounds, bool quick) {
  const LayerStack layers = layers_for(Millimeters{bounds.size_z()}, kThinLayer);
  const std::int32_t step = quick ? std::max(layers.count / kQuickLayers, 1) : 1;
  std::vector<double> heights;
  for (std::int32_t layer = 0; layer < layers.count; layer += step)
    heights.push_back(bounds.min_z + to_millimeters(layers.middle_of(layer)).count());
  return heights;
}

struct Totals {
  std::size_t layers = 0, segments = 0, loops = 0;
};

// Keeps one layer's contours in memory at a time, as in printing.
Totals link_all(const HeightIndex& model, bool quick) {
  Section section;
  ContourLinker linker;
  Contours contours;
  Totals totals;
  for (const double z : layer_heights(model.bounds(), quick)) {
    slice_at(model, Millimeters{z}, section);
    linker.link(section.segments, kTolerance, contours);
    ++totals.layers;
    totals.segments += section.segments.size();
    totals.loops += contours.loops.size();
  }
  return totals;
}

Peer run_baseline(const std::filesystem::path& file, bool quick) {
  Times times;
  time_once(times, [&] {
    const Model model = read_model_file(file);
    ThesisSlicer slicer(model.facets, 1920, 1080);
    for (const double z : layer_heights(bounds_of(model.facets), quick))
      (void)slicer.contours_at(static_cast<float>(z));
  });
  return {"thesis's algorithms", times.wall_s[0], false, times.cpu_s[0]};
}

std::vector<Row> contour_rows_of(const Bench& bench, const ContourSubject& subject) {
  const std::vector<std::string> ids{subject.id, subject.id + "-without-reading"};
  const auto file = bench.models.shared(subject.file);
  if (!file) return skipped_rows(ids, subject.file);
  Totals totals;
  const Times whole = time_runs(bench.runs(9), [&] {
    const HeightIndex model(read_model_file(*file).facets);
    totals = link_all(model, bench.quick);
  });
  const HeightIndex model(read_model_file(*file).facets);
  const Times linking = time_runs(bench.runs(9), [&] { totals = link_all(model, bench.quick); });

  Row row{ids[0], fmt::format("{}, file to linked contours of {} layers", subject.name, totals.layers), "s"};
  row.figure = best(whole.wall_s);
  row.cpu = best(whole.cpu_s);
  row.target = Target{Target::Kind::AtMost, subject.target_s};
  row.peers.push_back(run_baseline(*file, bench.quick));
  if (bench.peers) {
    if (const auto peer = run_slic3r(*file, kThinLayer)) row.peers.push_back(*peer);
  }
  row.peers.insert(row.peers.end(), subject.cited.begin(), subject.cited.end());
  row.note = fmt::format("{} segments, {} loops", totals.segments, totals.loops);

  Row without{ids[1], fmt::format("{}, the same without reading", subject.name), "s"};
  without.figure = best(linking.wall_s);
  without.cpu = best(linking.cpu_s);
  without.note =
      fmt::format("{:.0f} ns of CPU a segment", *without.cpu * 1e9 / static_cast<double>(totals.segments));
  return {row, without};
}

}  // namespace

std::vector<Row> contour_rows(const Bench& bench) {
  const std::vector<ContourSubject> subjects{
      {"contours-liver", "liver", kLiver, 0.10, {{"thesis", 1.483, true}, {"Minetto et al.", 1.04, true}}},
      {"contours-femur", "femur", kFemur, 0.07, {{"thesis", 2.532, true}, {"Minetto et al.", 0.52, true}}},
      {"contours-bunny", "bunny of 278k facets", kBunny, 0.15, {{"Minetto et al.", 1.08, true}}}};
  std::vector<Row> rows;
  for (const ContourSubject& subject : subjects) {
    for (Row& row : contour_rows_of(bench, subject))
      rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace contourd::bench
