#include "daemon/report/layer_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <string_view>

#include "daemon/prepare/print_findings.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// The largest number of marked islands in a layer, and of marked hollows; the largest ones are marked.
constexpr std::size_t kMaxLayerMarks = 20;
// The radius of a mark: this many times the radius of a disc with the island's area, and at least this many
// pixels.
constexpr double kAround = 1.6, kSmallestMark = 7, kPi = std::numbers::pi;
// The largest number of interruptions whose layers may be chosen.
constexpr std::size_t kMaxInterruptions = 3;

// Layers that were chosen for the same reason, the most important first. Layers count from 0.
struct Group {
  std::string_view why;
  std::vector<std::int32_t> layers;
};

std::vector<Group> groups_of(const PrintReport& report) {
  const LayerRecord& largest = *std::ranges::max_element(report.layers, {}, &LayerRecord::area_mm2);
  std::vector<Group> groups{{"first", {report.layers.front().layer}},
                            {"largest", {largest.layer}},
                            {"last", {report.layers.back().layer}}};
  if (report.findings) {
    for (FindingWarning& warning : findings_warnings(*report.findings))
      groups.push_back({warning.mark, std::move(warning.layers)});
  }
  Group interrupted{"interrupted", {}};
  for (const PrintInterruption& each : report.stops.interruptions) {
    if (interrupted.layers.size() < kMaxInterruptions) interrupted.layers.push_back(each.layer);
  }
  groups.push_back(std::move(interrupted));
  return groups;
}

class Choice {
 public:
  explicit Choice(std::span<const LayerRecord> layers) : layers_(layers) {}

  // Adds a layer, or another reason to a layer added before. Ignores a layer that was not exposed.
  void add(std::int32_t layer, std::string_view why) {
    const auto found = std::ranges::lower_bound(layers_, layer, {}, &LayerRecord::layer);
    if (found == layers_.end() || found->layer != layer) return;
    const auto record = static_cast<std::size_t>(found - layers_.begin());
    const auto known = std::ranges::find(chosen_, record, &ChosenLayer::record);
    if (known == chosen_.end()) {
      if (chosen_.size() < kMaxLayerPictures) chosen_.push_back({record, std::string(why)});
    } else if (known->why.find(why) == std::string::npos) {
      known->why += ", " + std::string(why);
    }
  }

  // Adds layers in the middle of the widest gaps. The first and the last layer have been added already.
  void fill_gaps() {
    while (chosen_.size() < std::min(kMaxLayerPictures, layers_.size())) {
      std::vector<std::size_t> records;
      for (const ChosenLayer& each : chosen_)
        records.push_back(each.record);
      std::ranges::sort(records);
      std::size_t from = 0, gap = 0;
      for (std::size_t i = 0; i + 1 < records.size(); ++i) {
        if (records[i + 1] - records[i] <= gap) continue;
        from = records[i];
        gap = records[i + 1] - from;
      }
      chosen_.push_back({from + gap / 2, ""});
    }
  }

  std::vector<ChosenLayer> take() { return std::move(chosen_); }

 private:
  std::span<const LayerRecord> layers_;
  std::vector<ChosenLayer> chosen_;
};

// The size in a picture's pixels of one pixel of the mask, and of one millimetre.
struct PictureScale {
  double per_pixel, per_mm;
};

// A place to be marked in a layer.
struct MarkedPlace {
  PixelPoint pixel;
  double area_mm2;
};

// Returns marks for the largest places, in the pixels of a picture of the box.
std::vector<LayerMark> marks_of(std::vector<MarkedPlace> places, const PixelBox& box,
                                const PictureScale& scale) {
  std::ranges::stable_sort(places, std::ranges::greater{}, &MarkedPlace::area_mm2);
  places.resize(std::min(places.size(), kMaxLayerMarks));
  std::vector<LayerMark> marks;
  for (const MarkedPlace& place : places) {
    const double radius = std::sqrt(place.area_mm2 / kPi) * scale.per_mm;
    marks.push_back(
        {{(place.pixel.x - box.left) * scale.per_pixel, (place.pixel.y - box.top) * scale.per_pixel},
         std::max(radius * kAround, kSmallestMark)});
  }
  return marks;
}

// Returns the bounds of the supports in the plane of the plate; their heights are not used.
Bounds bounds_of(std::span<const SupportPrimitive> supports) {
  Bounds all;
  const auto include = [&all](const PlatePoint& middle, double radius) {
    all.min_x = std::min(all.min_x, middle.x - radius);
    all.max_x = std::max(all.max_x, middle.x + radius);
    all.min_y = std::min(all.min_y, middle.y - radius);
    all.max_y = std::max(all.max_y, middle.y + radius);
  };
  for (const SupportPrimitive& each : supports) {
    if (const auto* const frustum = std::get_if<Frustum>(&each)) {
      include(frustum->lower, frustum->lower_radius_mm);
      include(frustum->upper, frustum->upper_radius_mm);
    } else if (const auto* const ball = std::get_if<Ball>(&each)) {
      include(ball->center, ball->radius_mm);
    }
  }
  return all;
}

std::vector<MarkedPlace> islands_in(const PrintReport& report, std::int32_t layer) {
  std::vector<MarkedPlace> places;
  if (!report.findings) return places;
  for (const Island& island : report.findings->islands) {
    if (island.layer == layer) places.push_back({island.pixel, island.area_mm2});
  }
  return places;
}

std::vector<MarkedPlace> voids_in(const PrintReport& report, std::int32_t layer) {
  std::vector<MarkedPlace> places;
  if (!report.findings) return places;
  for (const auto* voids : {&report.findings->suction_cups, &report.findings->resin_traps}) {
    for (const PrintVoid& each : *voids) {
      if (each.widest_layer == layer) places.push_back({each.pixel, each.area_mm2});
    }
  }
  return places;
}

}  // namespace

std::vector<ChosenLayer> choose_layers(const PrintReport& report) {
  if (report.layers.empty()) return {};
  const std::vector<Group> groups = groups_of(report);
  std::size_t most = 0;
  for (const Group& group : groups)
    most = std::max(most, group.layers.size());
  Choice choice(report.layers);
  for (std::size_t turn = 0; turn < most; ++turn) {
    for (const Group& group : groups) {
      if (turn < group.layers.size()) choice.add(group.layers[turn], group.why);
    }
  }
  choice.fill_gaps();
  return choice.take();
}

std::span<const SupportPrimitive> supports_of(const JobSummary& job) {
  if (!job.supports || !job.supports->structure) return {};
  return job.supports->structure->primitives();
}

PixelBox box_around(std::span<const PlateModel> models, Pixels width, Pixels height,
                    std::span<const SupportPrimitive> supports) {
  double left = HUGE_VAL, right = -HUGE_VAL, top = HUGE_VAL, bottom = -HUGE_VAL;
  const auto include = [&](const Bounds& bounds, const PixelMap& map) {
    for (const Point corner : {Point{bounds.min_x, bounds.min_y}, Point{bounds.max_x, bounds.max_y}}) {
      const PixelPoint pixel = map.to_pixels(corner);
      left = std::min(left, pixel.x);
      right = std::max(right, pixel.x);
      top = std::min(top, pixel.y);
      bottom = std::max(bottom, pixel.y);
    }
  };
  for (const PlateModel& model : models) {
    for (const PixelMap& map : model.copies)
      include(model.model->bounds(), map);
  }
  if (!supports.empty() && !models.empty())
    include(bounds_of(supports), PixelMap::true_scale(display_of(models, width, height), {0, 0}));
  // The margin leaves room for contours that are offset outwards.
  const double margin = 4 + std::max({right - left, bottom - top, 0.0}) / 20;
  const auto inside = [](double at, Pixels side) {
    return static_cast<std::int32_t>(std::clamp(at, 0.0, static_cast<double>(side.count())));
  };
  const PixelBox box{inside(std::floor(left - margin), width), inside(std::floor(top - margin), height),
                     inside(std::ceil(right + margin), width), inside(std::ceil(bottom + margin), height)};
  const bool none = box.left >= box.right || box.top >= box.bottom;
  return none ? PixelBox{0, 0, width.count(), height.count()} : box;
}

std::vector<LayerPicture> draw_layer_pictures(const PrintReport& report, const PrintedMasks& masks,
                                              MaskBudget::Clock::time_point deadline) {
  ContourEngine& engine = masks.engine;
  const PixelBox box = box_around(engine.models(), engine.coverage().width(), engine.coverage().height(),
                                  supports_of(report.summary));
  std::vector<LayerPicture> pictures;
  for (const ChosenLayer& chosen : choose_layers(report)) {
    const LayerRecord& layer = report.layers[chosen.record];
    MaskBudget budget(deadline);
    if (!budget.look_at_the_clock()) break;
    const Mask* mask = engine.mask_within(layer.mask_height, budget);
    if (mask == nullptr) continue;
    if (masks.undersides != nullptr)
      mask = &masks.undersides->mask(static_cast<std::size_t>(layer.layer), engine.coverage());
    const Mask small = make_thumbnail(*mask, box, kLayerPictureSide);
    const double per_pixel = static_cast<double>(small.width().count()) / (box.right - box.left);
    const PictureScale scale{per_pixel, per_pixel * engine.models().front().copies.front().pixels_per_mm()};
    pictures.push_back({layer.layer, chosen.why, small.width(), small.height(), encode_png(small),
                        marks_of(islands_in(report, layer.layer), box, scale),
                        marks_of(voids_in(report, layer.layer), box, scale)});
  }
  std::ranges::sort(pictures, {}, &LayerPicture::layer);
  return pictures;
}

}  // namespace contourd
