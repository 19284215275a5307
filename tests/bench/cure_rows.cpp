#include <fmt/format.h>

#include <memory>
#include <utility>

#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/models/models.hpp"

namespace contourd::bench {
namespace {

constexpr Nanometers kCuredLayer{50'000};
constexpr double kMostCureS = 4;

}  // namespace

std::vector<Row> cure_rows(const Bench& bench) {
  const DisplayGeometry display{Pixels{1920}, Pixels{1080}, Micrometers{50}};
  const auto ball = std::make_shared<const HeightIndex>(bench.quick ? models::gyroid_sphere(2, 5, 12)
                                                                    : models::gyroid_sphere(20, 10, 64));
  const Bounds& bounds = ball->bounds();
  std::vector<PlateModel> models;
  models.push_back({{ball}, {PixelMap::true_scale(display, bounds.center())}});
  ContourEngine engine(std::move(models), {.display = display});
  const WorkingCurve resin{Micrometers{150}, MillijoulesPerCm2{8}};
  const LayerStack stack = layers_for(Millimeters{bounds.size_z()}, kCuredLayer);
  std::vector<LayerDose> layers;
  for (std::int32_t layer = 0; layer < stack.count; ++layer)
    layers.push_back({kCuredLayer * (layer + 1), kCuredLayer, resin.dose_for(Micrometers{100})});
  std::vector<Row> rows;
  for (const double memory : {1.0, 0.9}) {
    // One after the other, so that other programs disturb both alike.
    Times cured, masks;
    for (int run = 0; run < bench.runs(3); ++run) {
      time_once(masks, [&] {
        for (const LayerDose& layer : layers)
          (void)engine.mask_at(layer.top - kCuredLayer / 2);
      });
      time_once(cured, [&] {
        (void)cure_part(engine, display, {.layers = layers, .cure = {.curve = resin, .peel_memory = memory}},
                        nullptr);
      });
    }
    Row row{fmt::format("cure-ball-memory-{}", memory),
            fmt::format("gyroid in a ball, the part that {} layers 1920x1080 cure, memory {}", layers.size(),
                        memory),
            "s"};
    row.figure = percentile(cured.wall_s, 0);
    row.cpu = percentile(cured.cpu_s, 0);
    row.target = Target{Target::Kind::AtMost, kMostCureS};
    row.peers.push_back(
        {"their masks alone", percentile(masks.wall_s, 0), false, percentile(masks.cpu_s, 0)});
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace contourd::bench
