// Maps a section's millimetres to the display's pixels (step 13 of the thesis's algorithm 1): at true scale
// (a part must come out at its size) or fitted to the display as the thesis does. Pixel coordinates are
// continuous: pixel (column, row) covers [column, column + 1) by [row, row + 1), row 0 at the top. x grows to
// the right; larger y lies higher. Immutable value, thread-safe.
#pragma once

#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

struct PixelPoint {
  double x, y;
};

struct DisplayGeometry {
  Pixels width{1920};
  Pixels height{1080};
  Micrometers pixel_pitch{50.0};  // side of a pixel's image on the plate
  bool mirror_x = false;          // left and right exchanged (a mirror in the light's path)
  bool mirror_y = false;          // top and bottom exchanged

  // The size of the display's image on the plate.
  [[nodiscard]] double width_mm() const { return width.count() * to_millimeters(pixel_pitch).count(); }
  [[nodiscard]] double height_mm() const { return height.count() * to_millimeters(pixel_pitch).count(); }
};

// Returns a pixel point's place on the plate: millimetres from the plate's centre, seen from above, mirrors
// undone.
[[nodiscard]] Point on_plate(const DisplayGeometry& display, PixelPoint pixel);

class PixelMap {
 public:
  // Makes a map at true scale: `center` (millimetres) is mapped to the display's centre. REQUIRES:
  // pixel_pitch > 0.
  [[nodiscard]] static PixelMap true_scale(const DisplayGeometry& display, Point center);

  // Makes a map that fits the model to the display, by the thesis's equations 3.6 to 3.19: the model's bounds
  // fill the display's width or height, aspect ratio kept. The equations' pixel (0, 0) is the image's upper
  // left corner here, where the largest y lies: row 0 is the top. A model without width or height keeps the
  // scale of its other side; one without both maps to (0, 0).
  [[nodiscard]] static PixelMap fit(const DisplayGeometry& display, const Bounds& bounds);

  [[nodiscard]] PixelPoint to_pixels(Point point) const {
    return {point.x * scale_x_ + offset_x_, point.y * scale_y_ + offset_y_};
  }

  // Returns the map to the same places on the plate for another display. `from` is the display that this map
  // is for. REQUIRES: pixel_pitch > 0 of both.
  [[nodiscard]] PixelMap moved(const DisplayGeometry& from, const DisplayGeometry& to) const;

  // True if a mirror reverses loops: a loop that runs counter-clockwise on the plate runs clockwise in the
  // picture.
  [[nodiscard]] bool turns_round() const { return (scale_x_ < 0) != (scale_y_ > 0); }

  // Returns the scale, which is the same along x and y and always positive.
  [[nodiscard]] double pixels_per_mm() const { return scale_x_ < 0 ? -scale_x_ : scale_x_; }

 private:
  PixelMap(double scale_x, double offset_x, double scale_y, double offset_y)
      : scale_x_(scale_x), scale_y_(scale_y), offset_x_(offset_x), offset_y_(offset_y) {}
  [[nodiscard]] PixelMap mirrored(const DisplayGeometry& display) const;

  double scale_x_, scale_y_, offset_x_, offset_y_;
};

}  // namespace contourd
