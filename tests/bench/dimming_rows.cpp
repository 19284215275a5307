#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "core/cure/underside_dimming.hpp"
#include "core/layers/layers.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/stopwatch.hpp"

namespace contourd::bench {
namespace {

constexpr Nanometers kLayer{50'000};
constexpr int kDimmingPasses = 3;
constexpr double kMostMs = 8, kMostMb = 100;

// Light that goes 150 um deep: an underside has 15 layers ahead of it.
UndersideCure cure_of(const HeightIndex& model) {
  const WorkingCurve resin{Micrometers{150}, MillijoulesPerCm2{8}};
  UndersideCure cure{
      .layers = {}, .resin = {.curve = resin, .peel_memory = 0.9}, .mask_budget = std::chrono::seconds{60}};
  const LayerStack stack = layers_for(Millimeters{model.bounds().size_z()}, kLayer);
  for (std::int32_t layer = 0; layer < stack.count; ++layer)
    cure.layers.push_back({kLayer * (layer + 1), kLayer, resin.dose_for(Micrometers{100})});
  return cure;
}

double heap_bytes() {
  const struct mallinfo2 heap = ::mallinfo2();
  return static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd);
}

std::vector<std::string> dimming_ids(const std::string& model) {
  return {"dimming-ahead-" + model + "-p50", "dimming-ahead-" + model + "-p99",
          "dimming-mask-" + model + "-p99", "dimming-memory-" + model};
}

Row time_row(std::string id, std::string what, const Times& times, int percent) {
  Row row{std::move(id), fmt::format("{}, p{}", what, percent), "ms"};
  row.figure = percentile(times.wall_s, percent) * 1e3;
  row.cpu = percentile(times.cpu_s, percent) * 1e3;
  row.target = Target{Target::Kind::AtMost, kMostMs};
  return row;
}

// Measures the look ahead and the masks of all layers, one after the other from the third one up.
std::vector<Row> dimming_rows_of(const Bench& bench, const std::string& model,
                                 const std::filesystem::path& file) {
  ContourEngine engine = fitted_engine(file, Pixels{1920}, Pixels{1080});
  const EngineSettings settings{DisplayGeometry{Pixels{1920}, Pixels{1080}}, AntiAliasing::On};
  const UndersideCure cure = cure_of(engine.model());
  std::vector<std::size_t> layers(static_cast<std::size_t>(
      bench.runs(static_cast<int>(std::min<std::size_t>(cure.layers.size(), 4000)) - 2)));
  std::iota(layers.begin(), layers.end(), std::size_t{2});
  const double before = heap_bytes();
  DimmedMasks masks(std::make_unique<UndersideDimming>(engine.models(), nullptr, settings, cure), ToneCurve{},
                    std::nullopt);
  double most = 0;
  const auto look_ahead = [&](std::size_t layer) {
    masks.look_ahead(layer);
    most = std::max(most, heap_bytes() - before);
  };
  const Times ahead = best_of_passes(kDimmingPasses, layers, look_ahead);
  Times dimmed, plain;
  for (const std::size_t layer : layers) {
    const Nanometers middle = cure.layers[layer].top - kLayer / 2;
    time_once(plain, [&] { (void)engine.mask_at(middle); });
    masks.look_ahead(layer);
    time_once(dimmed, [&] {
      (void)engine.mask_at(middle);
      (void)masks.mask(layer, engine.coverage());
    });
  }
  const std::vector<std::string> ids = dimming_ids(model);
  const std::string looked = model + ", look ahead for the undersides of a layer 1920x1080";
  Row memory{ids[3], model + ", additional memory to dim undersides 1920x1080", "MB"};
  memory.figure = most / 1e6;
  memory.target = Target{Target::Kind::AtMost, kMostMb};
  std::vector<Row> rows{time_row(ids[0], looked, ahead, 50), time_row(ids[1], looked, ahead, 99),
                        time_row(ids[2], model + ", then its mask with dimmed undersides", dimmed, 99),
                        std::move(memory)};
  rows[2].note = fmt::format("a plain mask {:.2f} ms of CPU", percentile(plain.cpu_s, 99) * 1e3);
  return rows;
}

}  // namespace

std::vector<Row> dimming_rows(const Bench& bench) {
  const auto plate = bench.models.shared(kPlate);
  std::vector<Row> rows =
      plate ? dimming_rows_of(bench, "plate", *plate) : skipped_rows(dimming_ids("plate"), kPlate);
  for (Row& row : dimming_rows_of(bench, "gyroid", bench.models.gyroid()))
    rows.push_back(std::move(row));
  return rows;
}

}  // namespace contourd::bench
