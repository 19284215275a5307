#include "core/mask/pixel_map.hpp"

#include "core/contract/expects.hpp"

namespace contourd {

Point on_plate(const DisplayGeometry& display, PixelPoint pixel) {
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  const double right = (pixel.x - display.width.count() / 2.0) * pitch_mm;
  const double up = (display.height.count() / 2.0 - pixel.y) * pitch_mm;
  return {display.mirror_x ? -right : right, display.mirror_y ? -up : up};
}

PixelMap PixelMap::true_scale(const DisplayGeometry& display, Point center) {
  expects(display.pixel_pitch > Micrometers{}, "a pixel has a size");
  const double pixels_per_mm = 1000.0 / display.pixel_pitch.count();
  return PixelMap(pixels_per_mm, display.width.count() / 2.0 - center.x * pixels_per_mm, -pixels_per_mm,
                  display.height.count() / 2.0 + center.y * pixels_per_mm)
      .mirrored(display);
}

PixelMap PixelMap::fit(const DisplayGeometry& display, const Bounds& bounds) {
  if (bounds.empty()) return PixelMap(0, 0, 0, 0).mirrored(display);
  const double width = display.width.count();
  const double height = display.height.count();
  // Equations 3.6 and 3.7, without their divisions: AR_object >= AR_device is size_x / size_y >= width /
  // height.
  const bool fit_to_width = bounds.size_x() * height >= width * bounds.size_y();
  // Equation 3.8: R. The side that is fitted takes equation 3.9 (to width) or 3.13 (to height); the other
  // side is modified to keep the aspect ratio, equations 3.10 to 3.12 or 3.14 and 3.15. With V and W (3.16,
  // 3.17) put into 3.18 and 3.19, R V / size_x and R W / size_y are one and the same scale.
  const double r = (fit_to_width ? width : height) - 1.0;
  const double fitted_size = fit_to_width ? bounds.size_x() : bounds.size_y();
  const double scale = fitted_size > 0.0 ? r / fitted_size : 0.0;
  // Equation 3.18: x_pixel = (P_x - x_min) scale. Equation 3.19 counted from the top: row = (y_max - P_y)
  // scale.
  return PixelMap(scale, -bounds.min_x * scale, -scale, bounds.max_y * scale).mirrored(display);
}

PixelMap PixelMap::moved(const DisplayGeometry& from, const DisplayGeometry& to) const {
  expects(from.pixel_pitch > Micrometers{} && to.pixel_pitch > Micrometers{}, "a pixel has a size");
  const double ratio = from.pixel_pitch / to.pixel_pitch;
  const double along_x = from.mirror_x == to.mirror_x ? ratio : -ratio;
  const double along_y = from.mirror_y == to.mirror_y ? ratio : -ratio;
  const auto beyond_middle = [](double offset, Pixels size) { return offset - size.count() / 2.0; };
  return PixelMap(scale_x_ * along_x, beyond_middle(offset_x_, from.width) * along_x + to.width.count() / 2.0,
                  scale_y_ * along_y,
                  beyond_middle(offset_y_, from.height) * along_y + to.height.count() / 2.0);
}

PixelMap PixelMap::mirrored(const DisplayGeometry& display) const {
  PixelMap map = *this;
  if (display.mirror_x) {
    map.scale_x_ = -scale_x_;
    map.offset_x_ = display.width.count() - offset_x_;
  }
  if (display.mirror_y) {
    map.scale_y_ = -scale_y_;
    map.offset_y_ = display.height.count() - offset_y_;
  }
  return map;
}

}  // namespace contourd
