// Splits the light of a mask into pictures for a display that has few grey levels: shown one after the other
// during one exposure, they give each pixel nearly the share of the light that the mask asks for.
//
// A pixel shows a level of the display, and from one of the pictures on the next darker one: the first
// picture is the brightest in every pixel, and each later one only darkens. The exposure is divided into
// equal steps; the pictures change at some of them. Of all divisions that leave each picture its shortest
// time, the one is chosen that reaches kExactness with the fewest pictures, or else the most exact one.
// Allocates in the constructor only. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/mask/mask.hpp"

namespace contourd {

// The grey levels of a display: 2^grey_bits values in equal steps, which give (value / greatest) ^ gamma of
// white's light.
struct PanelTone {
  int grey_bits = 8;
  double gamma = 1;
};

class LightSplit {
 public:
  // The largest difference from the wanted share of the light that is worth no further picture.
  static constexpr double kExactness = 0.01;

  // REQUIRES: 1 <= grey_bits <= 7; 0.1 <= gamma <= 10.
  explicit LightSplit(const PanelTone& panel);

  // Chooses the pictures for a mask whose values are linear shares of the light, in 255ths. Each picture
  // lasts at least the share `shortest` of the exposure. A mask that the display can show needs one picture.
  void plan(const Mask& light, double shortest);

  // Return the number of pictures, the share of the exposure after which one begins, and the largest
  // difference between the wanted and the given share of the light among the mask's pixels.
  [[nodiscard]] std::size_t pictures() const { return begins_.size(); }
  [[nodiscard]] double begin(std::size_t picture) const;
  [[nodiscard]] double error() const { return error_; }
  // Returns the share of the light that a pixel with this value of the planned mask gets.
  [[nodiscard]] double given(std::uint8_t light) const { return division().given[light]; }

  // Makes a mask of the light that the pictures give together, in 255ths. REQUIRES: as for draw().
  void sum(const Mask& light, Mask& to) const;
  // Rows of a mask, up to the one before `end`.
  struct Rows {
    std::int32_t first, end;
  };
  // Makes rows of a picture: the grey values to send to the display. REQUIRES: picture < pictures(); both
  // masks have one size, with these rows, and are two objects.
  void draw(std::size_t picture, const Mask& light, const Rows& rows, Mask& to) const;

 private:
  using Greys = std::array<std::uint8_t, 256>;
  // A way to divide the exposure: for each share of the light, in 255ths, the grey values that come nearest.
  struct Division {
    std::vector<Greys> greys;  // by step, each by the share
    std::array<double, 256> given{};
  };
  using Values = std::array<bool, 256>;  // values that occur

  void add_division(std::size_t step_count);
  [[nodiscard]] const Division& division() const { return divisions_[chosen_]; }
  [[nodiscard]] static double error_of(const Division& division, const Values& values);
  // Sets `begins` to the steps at which pictures begin. False if one is too short.
  [[nodiscard]] static bool list_begins(const Division& division, const Values& values, double shortest,
                                        std::vector<std::size_t>& begins);

  std::vector<double> levels_;        // light of each grey level
  std::vector<std::uint8_t> greys_;   // value to send for each
  std::vector<Division> divisions_;   // by number of steps, from 1; the last one has more
  std::size_t chosen_ = 0;            // of divisions_
  std::vector<std::size_t> begins_;   // steps of the chosen division, rising from 0
  std::vector<std::size_t> attempt_;  // begins_ of another division
  double error_ = 0;
};

// The light that the split exposures of a print give. Not thread-safe.
class GivenLight {
 public:
  // `shortest`: by layer, the share of its exposure that a picture lasts at least.
  GivenLight(const PanelTone& panel, std::vector<double> shortest)
      : split_(panel), shortest_(std::move(shortest)) {}

  // Returns the light that is given in a layer for a mask, both linear, in 255ths. Valid until the next call.
  // REQUIRES: a layer of the print.
  [[nodiscard]] const Mask& of(std::size_t layer, const Mask& light);

 private:
  LightSplit split_;
  std::vector<double> shortest_;
  Mask given_;
};

}  // namespace contourd
