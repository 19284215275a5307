#include "core/overhangs/carried_supports.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contract/expects.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {
namespace {

constexpr Nanometers kStep{100'000};
constexpr std::size_t kFewestTips = 3;
// Other programs place contacts farther apart than find_overhangs() does.
constexpr double kContactsForTip = 8;
// A tip holds the model around it up to this distance.
constexpr double kTipReachMm = 10;
constexpr double kWidestTipMm2 = 1;
// A tip ends a stem that is wider a few steps beneath, or has a ball above a neck.
constexpr std::size_t kStemSteps = 30, kBallSteps = 15;
constexpr double kPointed = 1.5;
// A cone beneath a ball widens by this factor within kStemSteps, however long it is.
constexpr double kConeBeneathBall = 1.15;
// A parasol or a chessman has a single stem; what hangs on supports has several tips.
constexpr int kFewestTipsOfPart = 2;
// The least ratio of the area of the held part to that of the tip.
constexpr double kHeldPart = 10;
// A foot begins at most this number of steps above the lowest one.
constexpr int kUnevenSteps = 3;

// A part of a layer, as a stem that comes from below.
struct Stem {
  double pixels = 0;
  std::array<double, kStemSteps> beneath{};  // pixels of the stem's last sections, the nearest first
  std::size_t sections = 0;                  // number of those since the stem branched off
  int branches = 0;                          // parts of the next layer that rest on it
  bool stands = false;                       // comes from the plate
  std::optional<std::uint32_t> held{};       // the number of the held part to which it belongs

  void continue_from(const Stem& lower) {
    beneath[0] = lower.pixels;
    std::copy_n(lower.beneath.begin(), kStemSteps - 1, beneath.begin() + 1);
    sections = std::min(lower.sections + 1, kStemSteps);
  }
  // True if the stem's last sections are alike, as in a column's capital.
  [[nodiscard]] bool ends_in_cylinder() const {
    constexpr std::ptrdiff_t kAlikeSteps = 3;
    constexpr double kAlike = 0.05;
    return std::all_of(beneath.begin(), beneath.begin() + kAlikeSteps,
                       [this](double section) { return std::fabs(section - pixels) <= kAlike * pixels; });
  }
  // True if the stem ends in a point or a ball here.
  [[nodiscard]] bool is_tip() const {
    double neck = pixels, ball = pixels, widest = pixels, ball_at_neck = pixels, beneath_neck = pixels;
    for (std::size_t i = 0; i < sections; ++i) {
      const double section = beneath[i];
      widest = std::max(widest, section);
      if (section < neck && i < kBallSteps) {
        neck = beneath_neck = section;
        ball_at_neck = ball;
      }
      ball = std::max(ball, section);
      beneath_neck = std::max(beneath_neck, section);
    }
    return widest >= kPointed * pixels || (!ends_in_cylinder() && ball_at_neck >= kPointed * neck &&
                                           beneath_neck >= kConeBeneathBall * neck);
  }
};

class TipCounter {
 public:
  TipCounter(const PlateModel& standing, const SweepGrid& grid)
      : engine_({standing}, {.display = grid.display, .anti_aliasing = AntiAliasing::Off}),
        grid_(grid),
        widest_tip_(kWidestTipMm2 / (grid.pixel_mm() * grid.pixel_mm())) {
    lit_.extract(Mask(grid.display.width, grid.display.height));
  }

  void add_layer() {
    std::swap(lit_, beneath_);
    std::swap(stems_, stems_beneath_);
    part_of_run_beneath_.assign(parts_.part_of_run().begin(), parts_.part_of_run().end());
    lit_.extract(engine_.mask_at(kStep * layer_ + kStep / 2));
    parts_.add_layer(lit_, beneath_);
    stems_.clear();
    for (const LayerPart& part : parts_.parts()) {
      const auto pixels = static_cast<double>(part.pixels);
      const bool begins_on_plate = layer_ <= kUnevenSteps && part.carried == 0;
      stems_.push_back({.pixels = pixels, .stands = begins_on_plate});
    }
    find_joints();
    rise();
    ++layer_;
  }
  // Returns the tips of parts that several tips hold.
  [[nodiscard]] std::vector<PlatePoint> tips() {
    std::vector<int> tips_of(held_parents_.size());
    for (const Tip& tip : tips_)
      ++tips_of[held_root(tip.held)];
    std::vector<PlatePoint> places;
    for (const Tip& tip : tips_)
      if (tips_of[held_root(tip.held)] >= kFewestTipsOfPart) places.push_back(tip.place);
    return places;
  }

 private:
  struct Tip {
    PlatePoint place;
    std::uint32_t held;  // the part that it holds
  };
  // A part and a part that rests on it.
  struct Joint {
    std::uint32_t lower, upper;
    SweepPixel at;  // a pixel of both
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> parts() const { return {lower, upper}; }
  };

  void find_joints() {
    joints_.clear();
    for (std::int32_t row = 0; row < lit_.rows(); ++row) {
      for_each_meeting(lit_.in_row(row), beneath_.in_row(row), 0, [&](std::size_t upper, std::size_t lower) {
        const std::int32_t column =
            std::max(lit_.in_row(row)[upper].first, beneath_.in_row(row)[lower].first);
        joints_.push_back({part_of_run_beneath_[beneath_.first_in_row(row) + lower],
                           parts_.part_of_run()[lit_.first_in_row(row) + upper],
                           {column, row}});
      });
    }
    std::ranges::sort(joints_, {}, &Joint::parts);
    const auto are_same = [](const Joint& a, const Joint& b) { return a.parts() == b.parts(); };
    joints_.erase(std::unique(joints_.begin(), joints_.end(), are_same), joints_.end());
    for (const Joint& joint : joints_)
      ++stems_beneath_[joint.lower].branches;
  }

  void rise() {
    for (const Joint& joint : joints_) {
      const Stem& lower = stems_beneath_[joint.lower];
      Stem& upper = stems_[joint.upper];
      upper.stands = upper.stands || lower.stands;
      // Branches start with their own width: a raft is no thick part of the pillars on it.
      if (lower.branches == 1 && lower.pixels > upper.beneath[0]) upper.continue_from(lower);
      if (lower.held) hold(upper, *lower.held);
    }
    for (const Joint& joint : joints_) {
      const Stem& lower = stems_beneath_[joint.lower];
      Stem& upper = stems_[joint.upper];
      if (!lower.stands || lower.pixels > widest_tip_ || upper.pixels < kHeldPart * lower.pixels ||
          !lower.is_tip())
        continue;
      if (!upper.held) {
        upper.held = static_cast<std::uint32_t>(held_parents_.size());
        held_parents_.push_back(*upper.held);
      }
      tips_.push_back({place_of(joint.at), *upper.held});
    }
  }

  // Makes the part belong to the held part, with that to which it belongs already.
  void hold(Stem& part, std::uint32_t held) {
    if (part.held) held_parents_[held_root(*part.held)] = held_root(held);
    part.held = held_root(held);
  }
  [[nodiscard]] std::uint32_t held_root(std::uint32_t held) const {
    while (held_parents_[held] != held)
      held = held_parents_[held];
    return held;
  }

  [[nodiscard]] PlatePoint place_of(SweepPixel pixel) const {
    const Point place = grid_.place_of(pixel);
    return {place.x, place.y, to_millimeters(kStep).count() * layer_};
  }

  ContourEngine engine_;
  SweepGrid grid_;
  double widest_tip_;  // in pixels
  LayerParts parts_;
  MaskRuns lit_, beneath_;
  std::vector<std::uint32_t> part_of_run_beneath_;
  std::vector<Stem> stems_, stems_beneath_;
  std::vector<Joint> joints_;
  int layer_ = 0;
  std::vector<Tip> tips_;
  std::vector<std::uint32_t> held_parents_;  // by number of a held part; a root is its own parent
};

// True if sections near the plate have several slender parts.
bool has_slender_parts(const HeightIndex& model) {
  constexpr double kWidestPillarMm = 3.5;
  const Bounds& bounds = model.bounds();
  Section section;
  ContourLinker linker;
  Contours contours;
  int sections = 0;
  for (const double height_mm : {1.5, 2.5, 4.0, 6.0, 9.0}) {
    slice_at(model, Millimeters{bounds.min_z + height_mm}, section);
    linker.link(section.segments, Millimeters{0.05}, contours);
    const auto slender = std::ranges::count_if(contours.loops, [&contours](const ContourLoop& loop) {
      const auto points = contours.points_of(loop);
      const auto [left, right] = std::ranges::minmax(points, {}, &Point::x);
      const auto [front, back] = std::ranges::minmax(points, {}, &Point::y);
      return std::max(right.x - left.x, back.y - front.y) <= kWidestPillarMm;
    });
    if (slender >= std::ptrdiff_t{kFewestTips}) ++sections;
  }
  return sections >= 2;
}

DisplayGeometry area_around(const Bounds& bounds) {
  constexpr double kPixelMm = 0.05;
  const auto pixels = [](double length_mm) {
    return Pixels{static_cast<std::int32_t>(std::clamp(std::ceil(length_mm / kPixelMm), 1.0, 1e6))};
  };
  DisplayGeometry area;
  area.width = pixels(bounds.size_x());
  area.height = pixels(bounds.size_y());
  area.pixel_pitch = Micrometers{kPixelMm * 1000};
  return area;
}

std::vector<PlatePoint> tips_of(const PlateModel& standing, const DisplayGeometry& area,
                                const std::stop_token& stop) {
  TipCounter tips(standing, sweep_grid(area));
  const double layers = standing.model->bounds().size_z() / to_millimeters(kStep).count();
  for (int layer = 0; layer < layers && !stop.stop_requested(); ++layer)
    tips.add_layer();
  return tips.tips();
}

// True if the tips hold the place: nothing floats there, and one of them is near.
bool is_held(const SupportContact& contact, const std::vector<PlatePoint>& tips) {
  return contact.cause != ContactCause::Island &&
         std::ranges::any_of(tips, [&place = contact.place](const PlatePoint& tip) {
           return std::hypot(tip.x - place.x, tip.y - place.y, tip.z - place.z) <= kTipReachMm;
         });
}

class NoObserver final : public LayerObserver {
 public:
  void begin(const DisplayGeometry&, Nanometers) override {}
  void layer(Nanometers, const MaskRuns&) override {}
};

}  // namespace

bool carries_supports(const std::shared_ptr<const HeightIndex>& model, const SupportSettings& settings,
                      const std::stop_token& stop) {
  expects(model != nullptr && Millimeters{model->bounds().size_z()} <= kHighestSweep,
          "the model is there and no higher than can be swept");
  if (model->bounds().empty() || !has_slender_parts(*model)) return false;
  const DisplayGeometry area = area_around(model->bounds());
  const PlateModel standing{{model}, {PixelMap::true_scale(area, model->bounds().center())}};
  const std::vector<PlatePoint> tips = tips_of(standing, area, stop);
  if (tips.size() < kFewestTips) return false;
  NoObserver none;
  const std::optional<HeldPlaces> places = find_overhangs({{standing}, area, settings}, none, stop);
  return places &&
         static_cast<double>(places->contacts.size()) <= kContactsForTip * static_cast<double>(tips.size()) &&
         std::ranges::all_of(places->contacts,
                             [&](const SupportContact& contact) { return is_held(contact, tips); });
}

}  // namespace contourd
