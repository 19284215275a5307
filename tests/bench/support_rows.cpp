#include <fmt/format.h>

#include <memory>

#include "core/hollow/hollow_model.hpp"
#include "core/support/support_structure.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/models/models.hpp"

namespace contourd::bench {
namespace {

constexpr int kColumns = 25, kRows = 20, kSupportPasses = 5, kHeights = 400;
constexpr double kSpacing = 2.6;

// 500 supports all over a plate of 96 by 54 mm: a foot, a pillar, a branch and a tip each.
std::vector<SupportPrimitive> supports() {
  std::vector<SupportPrimitive> primitives;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const double x = kSpacing * (i % kColumns - (kColumns - 1) / 2.0);
    const double y = kSpacing * (i / kColumns - (kRows - 1) / 2.0);
    primitives.push_back(Frustum{{x, y, 0}, {x, y, 1}, 2, 0.5});
    primitives.push_back(Frustum{{x, y, 1}, {x, y, 20}, 0.5, 0.5});
    primitives.push_back(Frustum{{x, y, 20}, {x + 1, y + 1, 22}, 0.5, 0.5});
    primitives.push_back(Frustum{{x + 1, y + 1, 22}, {x + 1, y + 1, 23}, 0.5, 0.2});
  }
  return primitives;
}

Times masks_of(const std::vector<PlateModel>& models, const DisplayGeometry& display,
               std::shared_ptr<const SectionSource> beside, int count) {
  ContourEngine engine(models, {display}, std::move(beside));
  std::vector<Nanometers> heights;
  for (int i = 0; i < count; ++i)
    heights.push_back(Nanometers{1'100'000} + Nanometers{50'000} * (i * 37 % kHeights));
  return best_of_passes(kSupportPasses, heights, [&](Nanometers height) { (void)engine.mask_at(height); });
}

// The time that hollowing adds to a mask of a ball of 25 mm, as the demo prints it.
Row hollow_row(const Bench& bench, const DisplayGeometry& display) {
  const auto ball = std::make_shared<const HeightIndex>(models::sphere(12.5, bench.quick ? 20 : 80));
  const auto hollowed = hollow_model({{ball}, {}, {}, to_millimeters(display.pixel_pitch)}).value();
  PlateModel solid{{ball}, {PixelMap::true_scale(display, {0, 0})}}, hollow = solid;
  hollow.holes = hollowed.removed;
  const Times bare = masks_of({solid}, display, nullptr, bench.runs(kHeights));
  const Times less = masks_of({hollow}, display, nullptr, bench.runs(kHeights));
  Row row{"hollow-mask", "ball of 25 mm with walls of 2 mm, added time of a mask 1920x1080, p50", "ms"};
  row.figure = (percentile(less.wall_s, 50) - percentile(bare.wall_s, 50)) * 1e3;
  row.cpu = (percentile(less.cpu_s, 50) - percentile(bare.cpu_s, 50)) * 1e3;
  row.target = Target{Target::Kind::AtMost, 1};
  row.note = fmt::format("without {:.2f} ms; {:.1f} ml of cavity", percentile(bare.wall_s, 50) * 1e3,
                         hollowed.volume_mm3 / 1000);
  return row;
}

}  // namespace

std::vector<Row> support_rows(const Bench& bench) {
  const DisplayGeometry display{Pixels{1920}, Pixels{1080}, Micrometers{50.0}};
  const auto model =
      std::make_shared<const HeightIndex>(models::gyroid_sphere(26, 8, bench.quick ? 10 : 100));
  std::vector<PlateModel> models(1);
  models.front().model = model;
  models.front().copies.push_back(PixelMap::true_scale(display, {0, 0}));
  const auto structure = std::make_shared<const SupportStructure>(supports());
  const Times bare = masks_of(models, display, nullptr, bench.runs(kHeights));
  const Times supported = masks_of(models, display, structure, bench.runs(kHeights));
  Row row{"supports-mask", "supports of 2,000 primitives, 500 cut, added time of a mask 1920x1080, p50",
          "ms"};
  row.figure = (percentile(supported.wall_s, 50) - percentile(bare.wall_s, 50)) * 1e3;
  row.cpu = (percentile(supported.cpu_s, 50) - percentile(bare.cpu_s, 50)) * 1e3;
  row.target = Target{Target::Kind::AtMost, 0.1};
  row.note = fmt::format("{} primitives; without them {:.2f} ms", structure->primitives().size(),
                         percentile(bare.wall_s, 50) * 1e3);
  return {row, hollow_row(bench, display)};
}

}  // namespace contourd::bench
