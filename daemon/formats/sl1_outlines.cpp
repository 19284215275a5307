#include "daemon/formats/sl1_outlines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/contour/contour_union.hpp"
#include "core/contract/expects.hpp"
#include "core/model/model.hpp"
#include "daemon/formats/input_limits.hpp"
#include "daemon/formats/svg_layer.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

// A layer of kMostSvgPoints points takes 20 MB.
constexpr std::uint64_t kMostSvgBytes = std::uint64_t{1} << 26U;
constexpr std::chrono::minutes kLongestOutlineReading{20};
// The sides of a slicer's display may differ by this much from those that the outlines name.
constexpr double kSizeTolerance = 0.005;

std::string text_of(const SvgSize& size) {
  return fmt::format("{:.2f} x {:.2f} mm", size.width.count(), size.height.count());
}

// The way of outlines from their picture to the plate: they are mirrored, then turned by a quarter.
struct OutlineTurn {
  bool mirror_x = false, mirror_y = false;
  enum class Rotation { None, Clockwise, CounterClockwise } rotation = Rotation::None;

  [[nodiscard]] Point apply(Point at) const {
    if (mirror_x) at.x = -at.x;
    if (mirror_y) at.y = -at.y;
    if (rotation == Rotation::Clockwise) return {at.y, -at.x};
    return rotation == Rotation::None ? at : Point{-at.y, at.x};
  }
};

void check_sliced_size(const SlicedDisplay& sliced, const SvgSize& size) {
  const auto side = [&sliced](std::size_t axis) {
    return Millimeters{static_cast<double>(sliced.pixels[axis]) * sliced.pitch_um[axis] / 1000};
  };
  const SvgSize named = sliced.on_end ? SvgSize{side(1), side(0)} : SvgSize{side(0), side(1)};
  const auto agree = [](Millimeters a, Millimeters b) {
    return std::fabs(a.count() / b.count() - 1) <= kSizeTolerance;
  };
  if (agree(named.width, size.width) && agree(named.height, size.height)) return;
  throw ModelError(fmt::format(
      "prusaslicer.ini names a display of {}, and the outlines are for one of {}: slice the model "
      "again",
      text_of(named), text_of(size)));
}

OutlineTurn turn_for_outlines(const std::optional<SlicedDisplay>& sliced, const SvgSize& size,
                              const DisplayGeometry& display) {
  // Outlines without a slicer's display come out as they are, whatever mirrors this display has.
  if (!sliced) return {display.mirror_x, display.mirror_y};
  check_sliced_size(*sliced, size);
  const bool is_square = size.width == size.height;
  const bool is_wide = size.width > size.height, display_is_wide = display.width > display.height;
  const bool is_turned = is_square ? sliced->on_end : is_wide != display_is_wide;
  using Rotation = OutlineTurn::Rotation;
  return {sliced->mirror_columns, sliced->mirror_rows,
          !is_turned       ? Rotation::None
          : sliced->on_end ? Rotation::Clockwise
                           : Rotation::CounterClockwise};
}

bool same_rings(const Contours& a, const Contours& b) {
  return std::ranges::equal(a.loops, b.loops, {}, &ContourLoop::point_count, &ContourLoop::point_count) &&
         a.points == b.points;
}

// Reads the layers of an archive one after another.
class OutlineReading {
 public:
  OutlineReading(const SlicedArchive& archive, const DisplayGeometry& display)
      : archive_(archive),
        display_(display),
        stack_(std::make_shared<OutlineStack>(archive.settings().layer_height)) {}

  [[nodiscard]] const OutlineStack& stack() const { return *stack_; }
  [[nodiscard]] std::shared_ptr<const OutlineStack> take() { return std::move(stack_); }

  void add(const ZipEntry& entry) {
    const std::string name = in_quotes(entry.name);
    count_bytes(entry, name);
    read_svg_layer(*archive_.open(entry), name, layer_);
    if (!turn_) {
      turn_ = turn_for_outlines(archive_.settings().display, layer_.size, display_);
      size_ = layer_.size;
    }
    if (layer_.size != size_)
      throw ModelError(fmt::format("{} is {} large, and the first layer {}: slice the model again", name,
                                   text_of(layer_.size), text_of(size_)));
    // Layers of upright walls are equal.
    if (stack_->layers() == 0 || !same_rings(layer_.rings, beneath_)) unite(name);
    stack_->add(united_);
    std::swap(layer_.rings, beneath_);
  }

 private:
  void count_bytes(const ZipEntry& entry, const std::string& name) {
    if (entry.inflated > kMostSvgBytes)
      throw ModelError(fmt::format("{} has {} bytes, and the limit is {}: print the model itself", name,
                                   entry.inflated, kMostSvgBytes));
    inflated_ += entry.inflated;
    if (inflated_ > kMostInflatedBytes)
      throw ModelError(fmt::format(
          "the outlines of its first {} layers become {} bytes when they are unpacked, and the limit is {}: "
          "print the model itself",
          stack_->layers() + 1, inflated_, kMostInflatedBytes));
  }

  void unite(const std::string& name) {
    turned_.points.clear();
    turned_.loops = layer_.rings.loops;
    for (const Point& point : layer_.rings.points)
      turned_.points.push_back(turn_->apply(point));
    constexpr std::chrono::seconds kLongestLayer{60};
    MaskBudget budget(MaskBudget::Clock::now() + kLongestLayer);
    if (!union_.unite(turned_, FillRule::NonZero, ContourUnion::kDoubleRounding, united_, budget))
      throw ModelError(
          fmt::format("{}: its outlines cross each other too often: print the model itself", name));
  }

  const SlicedArchive& archive_;
  const DisplayGeometry& display_;
  std::shared_ptr<OutlineStack> stack_;
  std::optional<OutlineTurn> turn_;
  SvgSize size_;
  std::uint64_t inflated_ = 0;
  SvgLayer layer_;
  Contours beneath_, turned_, united_;
  ContourUnion union_;
};

}  // namespace

std::shared_ptr<const OutlineStack> read_outlines(const SlicedArchive& archive,
                                                  const DisplayGeometry& display, std::uint64_t most_bytes,
                                                  const std::stop_token& stop) {
  expects(archive.has_outlines(), "the archive has outlines");
  const auto end = std::chrono::steady_clock::now() + kLongestOutlineReading;
  OutlineReading reading(archive, display);
  for (const ZipEntry* const entry : archive.layer_files()) {
    if (stop.stop_requested()) return reading.take();
    reading.add(*entry);
    const OutlineStack& stack = reading.stack();
    if (stack.bytes() > most_bytes)
      throw ModelError(fmt::format(
          "the outlines of its first {} layers take {} MB of memory, and {} MB are free for them: print the "
          "model itself",
          stack.layers(), stack.bytes() >> 20U, most_bytes >> 20U));
    if (std::chrono::steady_clock::now() > end)
      throw ModelError(
          fmt::format("reading its outlines takes longer than {} minutes: print the model itself",
                      kLongestOutlineReading.count()));
  }
  if (!reading.stack().box()) throw ModelError("none of its layers has an outline: slice the model again");
  return reading.take();
}

}  // namespace contourd
