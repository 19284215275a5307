// Fills polygons into a mask, by the non-zero winding rule, with exact area coverage (grey) or by pixel
// centres.
//
// Every side adds what it changes in the winding number to the pixels that it passes (font-rs's signed area
// deltas); one sum along each row then gives every pixel's winding, averaged over the pixel. The sums are
// whole numbers and a side's two ends are rounded alike wherever they meet, so closed polygons cancel exactly
// at the end of each row: no residue can spill, and every machine computes the same bytes. Only rows and
// pixels that a side passes are visited one by one; what lies between them is filled in runs.
//
// Not thread-safe; allocates in its constructor only.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mask.hpp"
#include "core/pixel_map.hpp"

namespace contourd {

enum class AntiAliasing {
  On,   // grey: the covered part of the pixel. Where polygons overlap within one pixel, their parts add up to
        // at most 1.
  Off,  // 255 where the pixel's centre is inside, else 0 (the thesis's way)
};

class Rasterizer {
 public:
  // Throws std::invalid_argument unless both sides are 1 to 16384 pixels.
  Rasterizer(Pixels width, Pixels height, AntiAliasing anti_aliasing);

  // Adds a directed side. Sides must form closed polygons by the time of paint(). They may lie outside the
  // display, at any finite distance.
  void add_side(PixelPoint from, PixelPoint to);

  // Paints all polygons added since the last call into the mask, whose former picture is lost.
  // REQUIRES: the mask has this rasterizer's size.
  void paint(Mask& mask);

 private:
  // The winding number one, and the height of one row, in the units of the sums: 2^15. Up to 65,535 polygons
  // may overlap in a pixel.
  static constexpr int kOneBits = 15;
  static constexpr std::int32_t kOne = 1 << kOneBits;

  void add_covered(PixelPoint from, PixelPoint to);
  void add_centers(PixelPoint from, PixelPoint to);
  void add_row_cover(std::int32_t row, double left, double right, std::int32_t cover, std::int32_t sign);
  void add_delta(std::int32_t row, std::int32_t column, std::int32_t delta);
  void paint_row(std::int32_t row, std::span<std::uint8_t> pixels);

  std::int32_t width_, height_;
  AntiAliasing anti_aliasing_;
  std::size_t words_per_row_;
  std::vector<std::int32_t> deltas_;    // change of the winding number at a pixel against its left neighbour
  std::vector<std::uint64_t> touched_;  // a bit a pixel: deltas_ may be other than 0 there
  std::vector<std::uint8_t> row_used_;
};

}  // namespace contourd
