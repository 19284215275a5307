// Draws a picture of a part from its masks, for viewing: parallel projection from the front, above and to the
// right, as in render_preview(), lit from the upper left.
//
// The masks are taken one after the other, from the plate up, and only the last two are kept: higher masks
// hide lower ones, so each pixel stores the height at which its line of sight last left the part. Grey is
// interpolated between two masks; the surface is where it falls below kLeastGrey. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

class PartPicture {
 public:
  // The least grey that is drawn as part of the part: half of the light, less the loss on a strut thinner
  // than its pixels.
  static constexpr double kLeastGrey = 100;

  // The box that contains the part: the size of the masks, and the height in pixels of the same size.
  struct Box {
    Pixels columns, rows;
    double height = 1;
    bool mirror_x = false, mirror_y = false;  // mirrors of the masks; undone in the picture
  };

  // Returns how many pixels of a picture with this side correspond to one pixel of the box.
  [[nodiscard]] static double scale_of(const Box& box, Pixels side);

  // Makes a picture at most `side` pixels wide and high that has room for the box. Takes up to 16 bytes for
  // each of its pixels, and two masks. REQUIRES: a box with pixels and a height above 0; side > 0.
  PartPicture(const Box& box, Pixels side);

  // Returns the number of masks for the box: at most twice as many as the picture has rows.
  [[nodiscard]] std::int32_t masks() const { return masks_; }
  // Returns the height of the next mask as a share of the box' height, from half a step to half a step below
  // the top: 0 to 1.
  [[nodiscard]] double next_height() const { return (taken_ + 0.5) / masks_; }

  // Adds the next mask. `beside` is the part of the mask that stands beside the models, such as supports;
  // give it for each mask or for none. REQUIRES: masks of the box' size; fewer than masks() added.
  void add(const Mask& mask, const Mask* beside = nullptr);
  // Draws all masks added from here on faintly, as not present.
  void add_faintly_from_here();

  // A place in the box as shares of its columns, rows and height, from the masks' first column and row and
  // from below.
  struct Place {
    double columns, rows, height;
  };
  struct Drawing {
    Mask picture;
    std::vector<PixelPoint> marks;  // in the picture's pixels; outside it if the place is
  };
  // Returns the part on black, cut to a square around it; the highest mask is its top. If anything stands
  // beside the models, the lowest bit of each grey value marks its pixels. Also returns the positions of
  // `places`, visible or hidden.
  [[nodiscard]] Drawing draw(std::span<const Place> places = {}) const;

 private:
  // A mask with a border of one dark pixel. Pixel (0, 0) is the mask's, and its middle is at (0.5, 0.5).
  struct Bordered {
    std::vector<std::uint8_t> pixels;
    std::size_t stride = 0;
    double columns = 0, rows = 0;

    void take(const Mask& mask);
    [[nodiscard]] double grey_at(double x, double y) const;
  };
  // The points of a mask, in its pixels, at which the lines of sight of a row of the picture meet its height.
  struct Sight {
    double x, y;            // at column 0
    double step_x, step_y;  // to the next column
  };
  // The height, in masks, at which each line of sight left the part; kNone if it never met the part.
  using Surface = std::vector<float>;

  [[nodiscard]] Sight sight_of(std::int32_t row, double height) const;
  // Returns where a place lies in the whole picture.
  [[nodiscard]] PixelPoint project(const Place& place) const;
  void look_along(std::int32_t row);
  [[nodiscard]] float leaves_at(double x, double y) const;
  // Returns the depths towards the eye, in the picture's pixels; NAN where no surface is seen.
  [[nodiscard]] std::vector<float> depths_of(const Surface& surface) const;
  [[nodiscard]] Mask shaded(const Surface& surface) const;
  // Returns the picture of draw() before it is cut.
  [[nodiscard]] Mask whole_picture() const;
  void mark_beside(Mask& picture) const;

  // Flags of the pixels whose surface, or present surface, belongs to the mask given as `beside`; empty if
  // there is none.
  struct IsBeside {
    std::vector<std::uint8_t> surface, present;
  };

  Box box_;
  std::int32_t side_;
  double scale_ = 1, middle_up_ = 0;  // pixels of the picture for one of a mask; height in its middle
  std::int32_t masks_ = 1, taken_ = 0;
  double along_x_ = 0, along_y_ = 0;  // movement of a line of sight from a mask to the one beneath
  Bordered beneath_, last_, beside_;
  Surface surface_;
  IsBeside is_beside_;
  std::vector<std::uint8_t> inside_;  // true where the line of sight was in the part at the last mask
  Surface present_;                   // surface of the present part; empty as long as nothing is faint
};

}  // namespace contourd
