// A picture of a part for a person, from the masks of which it is made: parallel projection from the front,
// above and to the right, as render_preview()'s, lit from the upper left.
//
// The masks are taken one after the other, from the plate up, and none is kept but the last two: what lies
// higher hides what lies lower, so a pixel knows how far up its line of sight last left what is lit. Between
// two masks their grey is interpolated; where it falls below kLeastGrey is the surface. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

class PartPicture {
 public:
  // Less of it is not drawn as part of the part: half of the light, less what a thin strut loses where its
  // pixels are larger than it.
  static constexpr double kLeastGrey = 100;

  // What is drawn lies in it: masks of so many pixels, and so many of those pixels high.
  struct Box {
    Pixels columns, rows;
    double height = 1;
    bool mirror_x = false, mirror_y = false;  // the masks', undone in the picture
  };

  // How many pixels of a picture with this side one of the box is.
  [[nodiscard]] static double scale_of(const Box& box, Pixels side);

  // At most `side` pixels wide and high, in which the box has room. Takes up to 16 bytes for each of its
  // pixels, and two masks. REQUIRES: a box with pixels and a height above 0; side > 0.
  PartPicture(const Box& box, Pixels side);

  // How many masks the box takes: no more than twice as many as the picture has rows.
  [[nodiscard]] std::int32_t masks() const { return masks_; }
  // At which share of the box' height the next one lies, from half a step to the last one's: 0 to 1.
  [[nodiscard]] double next_height() const { return (taken_ + 0.5) / masks_; }

  // `beside` is what of it stands beside the models, such as supports: of each mask, or of none.
  // REQUIRES: masks of the box' size; fewer than masks() added.
  void add(const Mask& mask, const Mask* beside = nullptr);
  // What is added from here on is not there: it is drawn faint.
  void add_faintly_from_here();

  // A place in the box: which shares of its columns, rows and height lie before it, from the masks' first
  // column and row and from below.
  struct Place {
    double columns, rows, height;
  };
  struct Drawing {
    Mask picture;
    std::vector<PixelPoint> marks;  // in its pixels; a place that lies beside it is beside it
  };
  // What was added, on black, cut to a square around it; the highest mask is its top. Where there is
  // something beside the models, the lowest bit of each grey value says whether it is that. With it, where
  // `places` lie, in front or hidden.
  [[nodiscard]] Drawing draw(std::span<const Place> places = {}) const;

 private:
  // A mask with a dark pixel around it. Pixel (0, 0) is the mask's, and its middle is at (0.5, 0.5).
  struct Bordered {
    std::vector<std::uint8_t> pixels;
    std::size_t stride = 0;
    double columns = 0, rows = 0;

    void take(const Mask& mask);
    [[nodiscard]] double grey_at(double x, double y) const;
  };
  // Along a row of the picture: where its pixels' lines of sight meet a height, in a mask's pixels.
  struct Sight {
    double x, y;            // of column 0
    double step_x, step_y;  // to the next column
  };
  // How far each line of sight went up within the part: heights in masks, none where it never met the part.
  using Surface = std::vector<float>;

  [[nodiscard]] Sight sight_of(std::int32_t row, double height) const;
  // In the whole picture.
  [[nodiscard]] PixelPoint project(const Place& place) const;
  void look_along(std::int32_t row);
  [[nodiscard]] float leaves_at(double x, double y) const;
  // Towards the eye, in the picture's pixels.
  [[nodiscard]] std::vector<float> depths_of(const Surface& surface) const;
  [[nodiscard]] Mask shaded(const Surface& surface) const;
  // As draw(), not cut.
  [[nodiscard]] Mask whole_picture() const;
  void mark_beside(Mask& picture) const;

  // Whether the surface, and the present one, is of what stands beside the models; empty where nothing does.
  struct IsBeside {
    std::vector<std::uint8_t> surface, present;
  };

  Box box_;
  std::int32_t side_;
  double scale_ = 1, middle_up_ = 0;  // the picture's pixels for one of a mask; what is in its middle
  std::int32_t masks_ = 1, taken_ = 0;
  double along_x_ = 0, along_y_ = 0;  // how far a line of sight moves from a mask to the one beneath it
  Bordered beneath_, last_, beside_;
  Surface surface_;
  IsBeside is_beside_;
  std::vector<std::uint8_t> inside_;  // whether the line of sight was in the part at the last mask
  Surface present_;                   // what is there; empty as long as nothing is faint
};

}  // namespace contourd
