// Turns and scales a model before it is sliced. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

// A direction in a model's own coordinates: the thesis's slicing normal n (section 3.3.2). It may have any
// length but 0.
struct Direction {
  double x = 0, y = 0, z = 1;
  bool operator==(const Direction&) const = default;
};

// Factors along the plate's axes.
struct Scale {
  constexpr Scale() = default;
  constexpr explicit Scale(double all) : x(all), y(all), z(all) {}
  constexpr Scale(double along_x, double along_y, double along_z) : x(along_x), y(along_y), z(along_z) {}

  [[nodiscard]] constexpr bool uniform() const { return x == y && y == z; }
  friend constexpr Scale operator*(const Scale& a, const Scale& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  bool operator==(const Scale&) const = default;

  double x = 1, y = 1, z = 1;
};

// A rotation, followed by scaling.
struct Orientation {
  // Degrees about the fixed axes x, then y, then z (right-handed).
  double x_deg = 0, y_deg = 0, z_deg = 0;
  Scale scale{};
  // The direction of the model that comes to point up by the shortest rotation; for straight down, half a
  // turn about x. If set, the angles are ignored.
  std::optional<Direction> up{};

  [[nodiscard]] bool is_identity() const {
    return x_deg == 0 && y_deg == 0 && z_deg == 0 && scale == Scale() && !up;
  }
};

// The plate's axes as directions of a model, each of length 1.
struct PlateAxes {
  Direction right, back, up;
};
// Returns the plate's axes for a model that is rotated as by `Orientation::up`. REQUIRES: the direction is
// finite and not zero.
[[nodiscard]] PlateAxes axes_with_up(const Direction& up);

// Applies the orientation to every vertex, in double, rounded to float once. Equal vertices stay equal, so
// closed models stay closed. Quarter turns are exact, and so are directions along an axis. A direction gives
// the same bits on every machine. Coordinates must stay within float's range (the caller checks bounds and
// scale). REQUIRES: `up` is finite and not zero.
void orient(std::span<Facet> facets, const Orientation& orientation);

}  // namespace contourd
