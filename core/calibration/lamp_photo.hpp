// Readings of a lamp's light from a photo of the white picture (see draw_lamp_photo()). Values; not
// thread-safe.
//
// The corners of the picture in the photo determine a projective map from the display to the photo (Heckbert
// 1989), so that the camera need not look straight down. The light of a cell is the mean of the pixels in the
// middle half of its width and height, so that what is at a cell's edge, the dots in the corners among it,
// does not count. A lens that makes a photo darker at its edges would be taken for the lamp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/calibration/lamp_fit.hpp"
#include "core/calibration/lamp_pictures.hpp"

namespace contourd {

// A place in a photo, in pixels from its upper left corner.
struct PhotoPoint {
  double x = 0, y = 0;
};

// The light that a sample of a photo stands for.
enum class PhotoEncoding {
  Linear,  // in proportion to the sample
  Srgb,    // by the curve of IEC 61966-2-1
};

class LampPhoto {
 public:
  // Makes a photo without pixels. `corners`: the picture's, by the number of their dots. Throws
  // CalibrationRefused unless they are the corners of a convex quadrangle, one after the other. REQUIRES: a
  // grid as for draw_lamp_field().
  LampPhoto(const std::array<PhotoPoint, 4>& corners, const LampGrid& grid, PhotoEncoding encoding);

  // Adds a row of pixels, each of `channels` samples up to 65535. Costs a few operations a pixel. REQUIRES:
  // at least one channel.
  void add_row(std::int32_t y, std::span<const std::uint16_t> samples, std::size_t channels);

  // Returns the mean light of each cell as a share of the photo's white. Throws CalibrationRefused if a cell
  // has fewer than 100 pixels, or the photo is too bright or too dark.
  [[nodiscard]] std::vector<LampReading> readings() const;

 private:
  struct Cell {
    double light = 0;  // sum over the pixels
    std::int64_t pixels = 0, white = 0;
  };
  // Returns the cell in whose middle half the pixel lies, or nullptr.
  [[nodiscard]] Cell* cell_at(double x, double y);

  LampGrid grid_;
  std::array<double, 9> to_display_{};  // from the photo to the display's unit square, row by row
  std::vector<float> light_of_;         // by value of a sample
  std::vector<Cell> cells_;
};

}  // namespace contourd
