// The tip of a support: a cone that ends in the model's surface, within 45 degrees of straight down, and the
// path that leads down from it. Immutable; thread-safe. Deterministic.
#pragma once

#include <optional>
#include <span>

#include "core/clearance/clearance_field.hpp"
#include "core/clearance/support_path_field.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

struct SupportTip {
  PlatePoint at;  // on the model's surface
  PlatePoint
      joint;  // where the cone ends and the branch begins; on the plate or on a model there is no branch
  Direction outward;     // from `at` to `joint`, of length 1
  double radius_mm = 0;  // at the joint
  SupportPath path;      // from the joint down; empty if the tip has no branch
};

class SupportTips {
 public:
  // `field` and `paths` must outlive the object.
  SupportTips(const ClearanceField& field, const SupportPathField& paths, const SupportSettings& settings);

  // Returns the tip that holds this place: along the surface's normal if a path leads on from there, else in
  // other directions, longer or thinner. An island with no room for anything else is joined to nearby
  // material. Returns nullopt if no tip fits.
  [[nodiscard]] std::optional<SupportTip> tip_at(const SupportContact& contact) const;

 private:
  struct Cone {
    Direction outward;
    double length_mm, radius_mm;
  };

  [[nodiscard]] std::optional<SupportTip> tip_with(const PlatePoint& at, const Cone& cone) const;
  [[nodiscard]] std::optional<SupportTip> pin_at(const PlatePoint& at,
                                                 std::span<const Direction> directions) const;
  [[nodiscard]] std::optional<SupportTip> strut_near(const PlatePoint& at) const;
  [[nodiscard]] std::optional<PlatePoint> foot_of_pin(const PlatePoint& at, const Direction& direction) const;
  [[nodiscard]] bool is_free(const PlatePoint& at, const Cone& cone) const;

  const ClearanceField& field_;
  const SupportPathField& paths_;
  SupportSettings settings_;
};

}  // namespace contourd
