// The pictures of a print's layers, one on top of another, as a slicer made them: grey values by pixel, as in
// a mask. Each is stored as runs of equal pixels: a layer of an ordinary part takes a few kilobytes, whatever
// the display's size is, and a layer equal to the one beneath takes none.
//
// Not thread-safe while pictures are added; then any number of threads may draw.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

class PictureStack {
 public:
  // Makes a stack without pictures, for layers of one thickness. REQUIRES: 1 to 16384 pixels wide and high;
  // thickness > 0.
  PictureStack(Pixels width, Pixels height, Nanometers thickness);

  // Adds the picture of the next layer. REQUIRES: it has the stack's size.
  void add(const Mask& picture);

  [[nodiscard]] Pixels width() const { return width_; }
  [[nodiscard]] Pixels height() const { return height_; }
  [[nodiscard]] Nanometers thickness() const { return thickness_; }
  [[nodiscard]] std::size_t layers() const { return pictures_.size(); }
  // Returns the memory that the pictures take, in bytes.
  [[nodiscard]] std::size_t bytes() const {
    return runs_.capacity() + pictures_.capacity() * sizeof pictures_[0];
  }
  // Returns the smallest box around the pixels that any picture lights; nullopt if all are dark.
  [[nodiscard]] std::optional<PixelBox> lit() const { return lit_; }

  // Replaces the mask by the picture of the layer at a height above the plate: a layer's lower side belongs
  // to it, its upper side does not. The mask is dark below the first layer and above the last one. Allocates
  // nothing. REQUIRES: the mask has the stack's size.
  void draw(Nanometers height, Mask& mask) const;

 private:
  // The place of a picture in runs_.
  struct Picture {
    std::size_t begin, end;
  };

  void widen(const Mask& picture);

  Pixels width_, height_;
  Nanometers thickness_;
  // Runs of equal pixels, row by row without a break between rows: the grey value, then the length, seven
  // bits a byte from the lowest, all but the last byte with 128 added.
  std::vector<std::uint8_t> runs_;
  std::vector<Picture> pictures_;  // by layer
  std::optional<PixelBox> lit_;
};

}  // namespace contourd
