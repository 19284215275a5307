// The height up to which resin has gelled beneath a plate that rises in the light. A value; not thread-safe.
//
// Resin at a height z gets light from the plate's heights x above z + dead zone on, exp(-(x - z) / Dp) of it,
// and gels when the sum passes the critical dose. At a constant speed the front is gel_gap() below the plate;
// where the speed or the light changes, it follows with the resin that is already on its way.
//
// A mask that is cut at the front lights each column of a part until the resin at its top has gelled, and no
// longer: every level top ends at its height, at any speed.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>

#include "core/continuous/rise_laws.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

class GelFront {
 public:
  // Light at a place, in units of the time of all of the lamp's light.
  struct Light {
    std::chrono::duration<double> time{};
    double share = 1;  // part of the lamp's light
  };

  // Resin beneath the height `solid` has gelled. The front does not rise by more than `fastest`, so that
  // masks can follow it: where the plate stops in the light, it comes nearer to the plate. REQUIRES: as for
  // cure_speed(); a positive speed.
  GelFront(const LitResin& resin, Nanometers solid, MillimetersPerSecond fastest);

  // Adds light in which the plate has risen to a height, at which it was at the last call if that is higher.
  void add(Nanometers plate, Light light);
  // Forgets all doses, as the liquid is stirred when the plate goes up in the dark. What has gelled stays so.
  void forget();

  // Returns the front, and the one after some more light in which the plate rises to a height.
  [[nodiscard]] Nanometers height() const { return height_; }
  [[nodiscard]] Nanometers ahead(Nanometers plate, Light light) const;

 private:
  // A stretch of the plate's way.
  struct Stretch {
    double from_um, to_um;
    double dose;  // at the height origin_um_, over Ec
  };
  [[nodiscard]] double falloff(double um) const;
  [[nodiscard]] Stretch stretch_to(double plate_um, Light light) const;
  [[nodiscard]] Nanometers limited(double front_um, std::chrono::duration<double> time) const;
  void move_origin();

  double depth_um_, dead_zone_um_;
  double doses_per_s_;  // Ec in a second of all light, without resin above
  MillimetersPerSecond fastest_;
  std::deque<Stretch> lit_;  // the stretches that resin above the front has had light from
  double sum_ = 0;           // sum of their doses
  double origin_um_ = 0;     // near the plate, so that doses neither vanish nor overflow
  double plate_um_ = 0;
  bool begun_ = false;  // the plate's height is known
  Nanometers height_;
};

}  // namespace contourd
