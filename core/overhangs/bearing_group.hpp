// The bearings that hold a body while its layers are peeled off: tips of supports, and the face with which
// it stands on the plate. Bearings share a pull as the bolts of a joint do (Navier's law of bending): each
// bears its part of the pull itself and, because the pull acts beside their centre, of the pull's moment,
//   strain(r) = F / W + F e' I^-1 (r - c)
// with W, c and I the weight, centre and second moment of the bearings, weighted by their strength, and e the
// lever from c to the pull. A lone tip bears a moment only by its own width. Not thread-safe.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

// The strength of every tip. Both numbers are positive.
struct TipStrength {
  double holds_pixels;  // area of a layer
  double diameter_pixels;
};

// A force that peels a body off the film: the area that pulls, and where.
struct PeelPull {
  double pixels = 0;
  double column = 0, row = 0;
};

class BearingGroup {
 public:
  // Adds a tip, with a number that the caller chooses.
  void add_tip(SweepPixel at, std::uint32_t number, const TipStrength& strength);
  // Adds pixels that rest on the plate.
  void add_base(const PixelRun& run);
  // Removes all pixels that rest on the plate.
  void clear_base() { base_ = {}; }
  // Takes over the other group's bearings.
  void merge(BearingGroup&& other);

  [[nodiscard]] bool stands() const { return base_.weight > 0; }
  // Returns the area of a layer that all tips hold together.
  [[nodiscard]] double tips_hold_pixels() const { return tips_.weight; }

  // True if no bearing bears more than its strength.
  [[nodiscard]] bool bear(const PeelPull& pull, const TipStrength& strength) const;
  // Returns the share of its strength that the most strained bearing bears; infinite without bearings. Of a
  // body that stands on the plate only the moment counts.
  [[nodiscard]] double strain(const PeelPull& pull, const TipStrength& strength) const;
  // Returns strain() as if the group had another tip.
  [[nodiscard]] double strain_with(SweepPixel tip, const PeelPull& pull, const TipStrength& strength) const;
  // A direction over the plate, of length 1.
  struct Lever {
    double x = 0, y = 0;
  };
  // Returns the direction in which the strain under the pull grows; no direction if the pull has no lever.
  // REQUIRES: there is a bearing.
  [[nodiscard]] Lever lever(const PeelPull& pull) const;

  // Calls visit(number, strain) for each tip; a pressed tip's strain is negative.
  template <typename Visit>
  void for_each_tip(const PeelPull& pull, Visit&& visit) const {
    const Strains strains = strains_under(pull);
    for (const Tip& tip : list_)
      visit(tip.number, strains.at(tip.at.column, tip.at.row));
  }

 private:
  // Weight, and first and second moments about the grid's origin.
  struct Moments {
    double weight = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    // `own` is the second moment about the added part's own centre, for a weight of 1.
    void add(double added_weight, double at_x, double at_y, double own_xx, double own_yy);
    void add(const Moments& other);
    void add_tip(SweepPixel at, const TipStrength& strength);
  };
  // The strains of a group: linear over the plate.
  struct Strains {
    double direct, slope_x, slope_y;
    double center_x, center_y;
    [[nodiscard]] double slope() const { return std::sqrt(slope_x * slope_x + slope_y * slope_y); }
    [[nodiscard]] double at(double x, double y) const {
      return direct + slope_x * (x - center_x) + slope_y * (y - center_y);
    }
  };
  struct Tip {
    SweepPixel at;
    std::uint32_t number;
  };
  // Valid only with a bearing. `tips` are the moments of the group's tips, and perhaps of another.
  [[nodiscard]] Strains strains_under(const PeelPull& pull, const Moments& tips) const;
  [[nodiscard]] Strains strains_under(const PeelPull& pull) const { return strains_under(pull, tips_); }
  [[nodiscard]] double strain_of_base(const Strains& strains) const;

  void include(SweepPixel low, SweepPixel high);
  [[nodiscard]] bool is_empty() const { return list_.empty() && !stands(); }
  [[nodiscard]] double strain_of_tips(const Strains& strains) const;

  Moments tips_, base_;
  SweepPixel low_, high_;  // corners around the tips
  std::vector<Tip> list_;
};

}  // namespace contourd
