// Where a support meets the model: a cone that ends in the surface, within 45 degrees of straight down, and
// the way that leads on from it. Immutable; thread-safe. Deterministic.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/clearance/clearance_field.hpp"
#include "core/clearance/support_path_field.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

struct SupportTip {
  PlatePoint at;         // on the model's surface
  PlatePoint joint;      // where the cone ends and the branch begins; on the plate: it has no branch
  Direction outward;     // from `at` to `joint`, of length 1
  double radius_mm = 0;  // at the joint
  SupportPath way;       // from the joint on
};

class SupportTips {
 public:
  // Both must outlive it.
  SupportTips(const ClearanceField& field, const SupportPathField& ways, const SupportSettings& settings);

  // The tip that holds this place: along the surface's normal if that leads anywhere, else aside of it,
  // longer or thinner. An island so close to other material that nothing else has room is joined to that.
  // Nothing where none does.
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
  const SupportPathField& ways_;
  SupportSettings settings_;
};

}  // namespace contourd
