#include "core/analysis/unmet_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostPairs = 16;

// A facet between two cuts, seen from above.
struct LevelFacet {
  std::uint32_t gap;  // number of cuts below it
  float z;
  float area_mm2;  // positive for a facet that faces up
};

// A place between two cuts where facets that face down are followed by facets that face up.
struct ThinPlace {
  std::uint32_t gap = 0;
  float bottom = 0, top = 0;
  double area_mm2 = 0;  // the lesser of both kinds of facets
};

// Returns the facet's area seen from above if it slopes less than 45 degrees, else 0.
double level_area(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, vx = double{c.x} - a.x, vy = double{c.y} - a.y;
  const double area = (ux * vy - uy * vx) / 2;
  return 2 * std::fabs(area) > twice_area(facet) * std::sqrt(0.5) ? area : 0.0;
}

std::vector<LevelFacet> level_facets(const HeightIndex& model, std::span<const double> cuts) {
  std::vector<LevelFacet> level;
  for (const Facet& facet : model.facets()) {
    const auto [low, high] = heights_of(facet);
    const auto next = std::ranges::lower_bound(cuts, double{low});
    // A cut at a facet's lowest vertex crosses the facet, one at its highest vertex does not.
    if (next != cuts.end() && *next < high) continue;
    const double area = level_area(facet);
    if (area == 0) continue;
    level.push_back(
        {static_cast<std::uint32_t>(next - cuts.begin()), (low + high) / 2, static_cast<float>(area)});
  }
  std::ranges::sort(level, {}, [](const LevelFacet& each) { return std::pair(each.gap, each.z); });
  return level;
}

// Returns the place with the most facets facing down beneath it and facing up above it, of the facets of
// one gap, which are sorted by z.
ThinPlace thinnest_place(std::span<const LevelFacet> facets) {
  double up_above = 0, down_below = 0;
  for (const LevelFacet& facet : facets)
    up_above += std::max(facet.area_mm2, 0.0F);
  ThinPlace best{facets.front().gap};
  for (std::size_t i = 0; i + 1 < facets.size(); ++i) {
    const LevelFacet &facet = facets[i], &next = facets[i + 1];
    (facet.area_mm2 > 0 ? up_above : down_below) -= facet.area_mm2;
    const double area = std::min(up_above, down_below);
    if (facet.z < next.z && facet.area_mm2 < 0 && next.area_mm2 > 0 && area > best.area_mm2)
      best = {facet.gap, facet.z, next.z, area};
  }
  return best;
}

std::vector<ThinPlace> thin_places(std::span<const LevelFacet> level, double least_mm2) {
  std::vector<ThinPlace> places;
  while (!level.empty()) {
    const auto end = std::ranges::find_if(
        level, [gap = level.front().gap](const LevelFacet& each) { return each.gap != gap; });
    const auto count = static_cast<std::size_t>(end - level.begin());
    const ThinPlace place = thinnest_place(level.first(count));
    if (place.area_mm2 >= least_mm2) places.push_back(place);
    level = level.subspan(count);
  }
  return places;
}

// Shows the model's first copy alone.
class PartFinder {
 public:
  PartFinder(const PlateModel& model, const DisplayGeometry& display, std::chrono::nanoseconds mask_budget)
      : display_(display),
        mask_budget_(mask_budget),
        engine_({first_copy(model)}, {display, AntiAliasing::Off}) {}

  // Returns the part that is lit at `height` and dark at the cuts beneath and above.
  std::optional<UnmetPart> find(Nanometers height, std::span<const Nanometers> neighbours) {
    const Mask* const lit = mask_at(height);
    if (lit == nullptr) return std::nullopt;
    Mask part = *lit;
    for (const Nanometers cut : neighbours) {
      const Mask* const layer = mask_at(cut);
      if (layer == nullptr) return std::nullopt;
      for (std::int32_t y = 0; y < part.height().count(); ++y)
        std::ranges::transform(part.row(y), layer->row(y), part.row(y).begin(), without);
    }
    return part_of(part, height);
  }

 private:
  static std::uint8_t without(std::uint8_t grey, std::uint8_t other) { return other == 0 ? grey : 0; }
  static PlateModel first_copy(PlateModel model) {
    model.copies.resize(1, model.copies.front());
    return model;
  }

  const Mask* mask_at(Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + mask_budget_);
    return engine_.mask_within(height, budget);
  }

  [[nodiscard]] std::optional<UnmetPart> part_of(const Mask& mask, Nanometers height) const {
    const auto pixels = mask.pixels();
    const auto first = std::ranges::find_if(pixels, [](std::uint8_t grey) { return grey > 0; });
    if (first == pixels.end()) return std::nullopt;
    const auto at = static_cast<std::int64_t>(first - pixels.begin());
    const std::int64_t width = mask.width().count(), row = at / width, column = at % width;
    const double pitch_mm = to_millimeters(display_.pixel_pitch).count();
    const PixelPoint pixel{static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5};
    return UnmetPart{height, {}, mask.lit_area() * pitch_mm * pitch_mm, on_plate(display_, pixel)};
  }

  DisplayGeometry display_;
  std::chrono::nanoseconds mask_budget_;
  ContourEngine engine_;
};

}  // namespace

std::vector<UnmetPart> find_unmet_parts(const PlateModel& model, const DisplayGeometry& display,
                                        std::span<const Nanometers> cuts, double least_mm2,
                                        std::chrono::nanoseconds mask_budget) {
  expects(!model.copies.empty(), "the model has a copy");
  if (cuts.empty()) return {};
  std::vector<double> zs;
  for (const Nanometers cut : cuts)
    zs.push_back(model.z_at(cut).count());
  std::vector<ThinPlace> places = thin_places(level_facets(*model.model, zs), least_mm2);
  std::ranges::stable_sort(places, std::ranges::greater{}, &ThinPlace::area_mm2);
  places.resize(std::min(places.size(), kMostPairs));
  std::ranges::sort(places, {}, &ThinPlace::gap);
  std::vector<UnmetPart> parts;
  if (places.empty()) return parts;
  PartFinder finder(model, display, mask_budget);
  for (const ThinPlace& place : places) {
    const Millimeters middle{(double{place.bottom} + place.top) / 2};
    const auto height = model.elevation.height_at(middle, model.model->bounds());
    if (!height) continue;
    const std::size_t first = place.gap > 0 ? place.gap - 1 : 0;
    const std::size_t end = std::min<std::size_t>(place.gap + 1, cuts.size());
    std::optional<UnmetPart> part = finder.find(*height, cuts.subspan(first, end - first));
    if (!part || part->area_mm2 < least_mm2) continue;
    part->thickness = Millimeters{double{place.top} - place.bottom};
    parts.push_back(*part);
  }
  return parts;
}

}  // namespace contourd
