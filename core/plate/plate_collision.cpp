#include "core/plate/plate_collision.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/contract/expects.hpp"
#include "core/engine/contour_engine.hpp"

namespace contourd {
namespace {

struct Rectangle {
  double left, right, front, back;  // millimetres from the plate's centre
};

Rectangle rectangle_of(const PlacedModel& placed) {
  const Bounds& bounds = placed.model->bounds();
  const double half_x = bounds.size_x() / 2, half_y = bounds.size_y() / 2;
  return {placed.center.x - half_x, placed.center.x + half_x, placed.center.y - half_y,
          placed.center.y + half_y};
}

Rectangle overlap_of(const PlacedModel& one, const PlacedModel& other) {
  const Rectangle a = rectangle_of(one), b = rectangle_of(other);
  return {std::max(a.left, b.left), std::min(a.right, b.right), std::max(a.front, b.front),
          std::min(a.back, b.back)};
}

// A part of the display, treated as a separate display on the same pixel grid.
class Window {
 public:
  Window(const DisplayGeometry& display, const Rectangle& part)
      : pixels_per_mm_(1000.0 / display.pixel_pitch.count()),
        middle_x_(display.width.count() / 2.0),
        middle_y_(display.height.count() / 2.0) {
    const auto within = [](double value, Pixels limit) {
      return std::clamp(value, 0.0, static_cast<double>(limit.count()));
    };
    left_ = within(std::floor(middle_x_ + part.left * pixels_per_mm_), display.width);
    right_ = within(std::ceil(middle_x_ + part.right * pixels_per_mm_), display.width);
    top_ = within(std::floor(middle_y_ - part.back * pixels_per_mm_), display.height);
    bottom_ = within(std::ceil(middle_y_ - part.front * pixels_per_mm_), display.height);
    geometry_.width = Pixels{static_cast<std::int32_t>(right_ - left_)};
    geometry_.height = Pixels{static_cast<std::int32_t>(bottom_ - top_)};
    geometry_.pixel_pitch = display.pixel_pitch;
  }

  [[nodiscard]] bool empty() const { return !(right_ > left_ && bottom_ > top_); }

  [[nodiscard]] ContourEngine engine_for(const PlacedModel& placed) const {
    // The point of the model that lies on the window's centre.
    const Point middle = placed.model->bounds().center(), center = center_mm();
    const Point on_center{middle.x - placed.center.x + center.x, middle.y - placed.center.y + center.y};
    return ContourEngine({PlateModel{placed, {PixelMap::true_scale(geometry_, on_center)}}},
                         {geometry_, AntiAliasing::On});
  }

  // Returns a pixel's middle, from the plate's centre.
  [[nodiscard]] Point place_of(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(geometry_.width.count());
    const std::size_t column = pixel % width, row = pixel / width;
    return {(left_ + static_cast<double>(column) + 0.5 - middle_x_) / pixels_per_mm_,
            (middle_y_ - top_ - static_cast<double>(row) - 0.5) / pixels_per_mm_};
  }

 private:
  [[nodiscard]] Point center_mm() const {
    return {((left_ + right_) / 2 - middle_x_) / pixels_per_mm_,
            (middle_y_ - (top_ + bottom_) / 2) / pixels_per_mm_};
  }

  double pixels_per_mm_, middle_x_, middle_y_;
  double left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // pixels of the whole display
  DisplayGeometry geometry_;
};

}  // namespace

bool bounds_overlap(const PlacedModel& a, const PlacedModel& b) {
  const Rectangle overlap = overlap_of(a, b);
  return overlap.left < overlap.right && overlap.front < overlap.back;
}

std::optional<Collision> find_collision(const PlacedModel& a, const PlacedModel& b,
                                        const DisplayGeometry& display, Nanometers layer) {
  expects(layer > Nanometers{}, "a layer has a thickness");
  if (!bounds_overlap(a, b)) return std::nullopt;
  const Window window(display, overlap_of(a, b));
  if (window.empty()) return std::nullopt;
  ContourEngine one = window.engine_for(a), other = window.engine_for(b);
  const Millimeters top = std::min(a.top(), b.top());
  for (Nanometers height = layer / 2; to_millimeters(height) < top; height += layer) {
    const auto lit = one.mask_at(height).pixels(), lit_too = other.mask_at(height).pixels();
    for (std::size_t pixel = 0; pixel < lit.size(); ++pixel) {
      if (lit[pixel] != 0 && lit_too[pixel] != 0) return Collision{height, window.place_of(pixel)};
    }
  }
  return std::nullopt;
}

}  // namespace contourd
