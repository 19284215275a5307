// Fuzz target: any facets, cut and filled. The mask is the same every time, stays within the model's outline
// and is dark above and below the model; facets together with their reversed copies stay within the outline
// too.
#include <algorithm>
#include <utility>

#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/mask_input.hpp"

namespace contourd::fuzz {
namespace {

std::vector<PixelMap> maps_of(const MaskSettings& settings, const Bounds& bounds) {
  const DisplayGeometry display = display_of(settings);
  if ((settings.flags & kFit) != 0) return {PixelMap::fit(display, bounds)};
  const Point center = bounds.center();
  std::vector<PixelMap> maps{PixelMap::true_scale(display, center)};
  if ((settings.flags & kCopies) != 0)
    maps.push_back(PixelMap::true_scale(display, {center.x + 1, center.y - 2}));
  return maps;
}

ContourEngine engine_for(const MaskInput& input, models::Facets facets, const Bounds& bounds) {
  const bool grey = (input.settings.flags & kGrey) != 0;
  return ContourEngine(HeightIndex(std::move(facets)),
                       {.display = display_of(input.settings),
                        .anti_aliasing = grey ? AntiAliasing::On : AntiAliasing::Off,
                        .compensation = compensation_of(input.settings)},
                       maps_of(input.settings, bounds));
}

// The pixels that a model's outline may touch, on one axis.
struct Extent {
  double low, high;
  Extent(double a, double b) {
    // Rounding error of a mapped coordinate, whose offset may be as large as the coordinate itself.
    const double rounding = 1 + (std::fabs(a) + std::fabs(b)) * 1e-9;
    low = std::min(a, b) - rounding;
    high = std::max(a, b) + rounding;
  }
  [[nodiscard]] bool has(int pixel) const { return pixel + 1 >= low && pixel <= high; }
};

struct Outline {
  Extent columns, rows;
};

std::vector<Outline> outlines_of(const MaskSettings& settings, const Bounds& bounds) {
  std::vector<Outline> outlines;
  const double growth = std::max(to_millimeters(compensation_of(settings).growth).count(), 0.0);
  for (const PixelMap& map : maps_of(settings, bounds)) {
    const PixelPoint a = map.to_pixels({bounds.min_x - growth, bounds.min_y - growth});
    const PixelPoint b = map.to_pixels({bounds.max_x + growth, bounds.max_y + growth});
    outlines.push_back({Extent(a.x, b.x), Extent(a.y, b.y)});
  }
  return outlines;
}

void demand_no_spill(const Mask& mask, const std::vector<Outline>& outlines) {
  for (int row = 0; row < mask.height().count(); ++row) {
    const auto pixels = mask.row(row);
    for (auto lit = pixels.begin(); lit != pixels.end(); ++lit) {
      lit = std::find_if(lit, pixels.end(), [](std::uint8_t grey) { return grey != 0; });
      if (lit == pixels.end()) break;
      const auto column = static_cast<int>(lit - pixels.begin());
      const bool inside = std::any_of(outlines.begin(), outlines.end(), [&](const Outline& outline) {
        return outline.columns.has(column) && outline.rows.has(row);
      });
      demand(inside, "a pixel outside the model's outline is lit");
    }
  }
}

void check(const MaskInput& input) {
  const Bounds bounds = bounds_of(input.facets);
  ContourEngine engine = engine_for(input, input.facets, bounds);
  const double part = input.settings.height_part / 65536.0;
  const float extra_z = input.settings.z;
  std::vector<double> heights{bounds.min_z + part * bounds.size_z(), bounds.min_z};
  if (std::isfinite(extra_z)) heights.push_back(extra_z);
  models::Facets double_sided = input.facets;
  models::invert(double_sided);
  double_sided.insert(double_sided.end(), input.facets.begin(), input.facets.end());
  ContourEngine cancelled = engine_for(input, double_sided, bounds);
  const std::vector<Outline> outlines = outlines_of(input.settings, bounds);
  for (const double z : heights) {
    const Mask mask = engine.mask_at_z(Millimeters{z});
    demand_no_spill(mask, outlines);
    (void)engine.mask_at_z(Millimeters{bounds.min_z + bounds.size_z() / 3});
    demand(engine.mask_at_z(Millimeters{z}) == mask, "the same height has a different mask");
    demand_no_spill(cancelled.mask_at_z(Millimeters{z}), outlines);
  }
  demand(engine.mask_at_z(Millimeters{bounds.max_z}).lit_pixels() == 0, "there is light above the model");
  const double below = std::nextafter(bounds.min_z, -1e300);
  demand(engine.mask_at_z(Millimeters{below}).lit_pixels() == 0, "there is light below the model");
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace contourd::fuzz;
  if (size < sizeof(MaskSettings)) return 0;
  const MaskInput input = from_bytes(std::as_bytes(std::span(data, size)));
  if (!input.facets.empty()) check(input);
  return 0;
}
