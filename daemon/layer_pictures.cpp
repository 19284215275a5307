#include "daemon/layer_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <string_view>

#include "daemon/print_findings.hpp"
#include "hw/png_file.hpp"

namespace contourd {
namespace {

// How many of the islands of a layer are marked; the largest.
constexpr std::size_t kMaxIslands = 20;
// A circle is so much larger than the disc of an island's area, and has so many pixels at least.
constexpr double kAround = 1.6, kSmallestMark = 7, kPi = std::numbers::pi;
// How many interruptions are looked at for a picture of their layer.
constexpr std::size_t kMaxInterruptions = 3;

// Layers that have something in common, the most important first. They count from 0.
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

  // A layer that was not exposed is none to choose.
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

  // Between layers that are chosen; the first and the last are.
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

// How many of a picture's pixels are one of the mask's, and a millimetre.
struct PictureScale {
  double per_pixel, per_mm;
};

// In the picture of the box.
std::vector<IslandMark> islands_in(const PrintReport& report, std::int32_t layer, const PixelBox& box,
                                   const PictureScale& scale) {
  if (!report.findings) return {};
  std::vector<Island> islands;
  std::ranges::copy_if(report.findings->islands, std::back_inserter(islands),
                       [layer](const Island& island) { return island.layer == layer; });
  std::ranges::stable_sort(islands, [](const Island& a, const Island& b) { return a.area_mm2 > b.area_mm2; });
  islands.resize(std::min(islands.size(), kMaxIslands));
  std::vector<IslandMark> marks;
  for (const Island& island : islands) {
    const double radius = std::sqrt(island.area_mm2 / kPi) * scale.per_mm;
    marks.push_back(
        {{(island.pixel.x - box.left) * scale.per_pixel, (island.pixel.y - box.top) * scale.per_pixel},
         std::max(radius * kAround, kSmallestMark)});
  }
  return marks;
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

PixelBox box_around(std::span<const PlateModel> models, Pixels width, Pixels height) {
  double left = HUGE_VAL, right = -HUGE_VAL, top = HUGE_VAL, bottom = -HUGE_VAL;
  for (const PlateModel& model : models) {
    const Bounds& bounds = model.model->bounds();
    for (const PixelMap& map : model.copies) {
      for (const Point corner : {Point{bounds.min_x, bounds.min_y}, Point{bounds.max_x, bounds.max_y}}) {
        const PixelPoint pixel = map.to_pixels(corner);
        left = std::min(left, pixel.x);
        right = std::max(right, pixel.x);
        top = std::min(top, pixel.y);
        bottom = std::max(bottom, pixel.y);
      }
    }
  }
  // Contours may be moved outwards.
  const double margin = 4 + std::max({right - left, bottom - top, 0.0}) / 20;
  const auto inside = [](double at, Pixels side) {
    return static_cast<std::int32_t>(std::clamp(at, 0.0, static_cast<double>(side.count())));
  };
  const PixelBox box{inside(std::floor(left - margin), width), inside(std::floor(top - margin), height),
                     inside(std::ceil(right + margin), width), inside(std::ceil(bottom + margin), height)};
  const bool none = box.left >= box.right || box.top >= box.bottom;
  return none ? PixelBox{0, 0, width.count(), height.count()} : box;
}

std::vector<LayerPicture> draw_layer_pictures(const PrintReport& report, ContourEngine& engine,
                                              MaskBudget::Clock::time_point deadline) {
  const PixelBox box = box_around(engine.models(), engine.coverage().width(), engine.coverage().height());
  std::vector<LayerPicture> pictures;
  for (const ChosenLayer& chosen : choose_layers(report)) {
    const LayerRecord& layer = report.layers[chosen.record];
    MaskBudget budget(deadline);
    if (!budget.look_at_the_clock()) break;
    const Mask* const mask = engine.mask_within(layer.mask_height, budget);
    if (mask == nullptr) continue;
    const Mask small = make_thumbnail(*mask, box, kLayerPictureSide);
    const double per_pixel = static_cast<double>(small.width().count()) / (box.right - box.left);
    const PictureScale scale{per_pixel, per_pixel * engine.models().front().copies.front().pixels_per_mm()};
    pictures.push_back({layer.layer, chosen.why, small.width(), small.height(), encode_png(small),
                        islands_in(report, layer.layer, box, scale)});
  }
  std::ranges::sort(pictures, {}, &LayerPicture::layer);
  return pictures;
}

}  // namespace contourd
