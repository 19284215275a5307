// Ways around the models, down to the plate or to a model's upper side, never flatter than 45 degrees. What
// every way takes is worked out for all cells of a clearance field at once, level by level from the plate up;
// a way then follows what takes least, and is drawn straight wherever there is room.
//
// Immutable once built; thread-safe. Deterministic. Memory: 2 bytes a cell of the field.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/clearance/clearance_field.hpp"

namespace contourd {

// What a way is made of: the radius of a branch where there is room, and where there is little; that of a
// foot on a model.
struct PathWidths {
  double usual_mm = 0, least_mm = 0, landing_mm = 0;
};

// A way from a point down. Each stretch has room for its radius.
struct SupportPath {
  struct Stretch {
    PlatePoint end;
    double radius_mm = 0;
  };
  std::vector<Stretch> stretches;     // from the top down; the last one ends on the plate or above a model
  std::optional<PlatePoint> landing;  // on the model's surface, straight below
  double length_mm = 0;
};

class SupportPathField {
 public:
  enum class End { Plate, Model };

  struct Settings {
    PathWidths widths;
    End end = End::Plate;
    std::span<const SupportContact> from;  // with feet on models: from near which ways are wanted
  };

  // `field` must outlive the ways. Once `stop` was asked for they are of no use.
  SupportPathField(const ClearanceField& field, const Settings& settings, const std::stop_token& stop);

  [[nodiscard]] End end() const { return end_; }

  // Whether a foot may stand on the model there: a place on its surface that is flat enough, and near enough
  // below.
  [[nodiscard]] std::optional<PlatePoint> landing_below(const PlatePoint& point) const;

  // How long a way from there is, about, narrow places counted more; nothing where there is none.
  [[nodiscard]] std::optional<double> length_from(const PlatePoint& point) const;
  // A way from there, each of its stretches looked at; nothing where there is none.
  [[nodiscard]] std::optional<SupportPath> path_from(const PlatePoint& point) const;

 private:
  using Cost = std::uint16_t;
  static constexpr Cost kNoWay = 0xFFFF;
  // Of a cost.
  static constexpr double kUnit_mm = 0.02;

  struct Step {
    ClearanceField::Cell cell;
    double cost_mm;
  };

  void begin_level(std::int32_t level);
  void reach_level(std::int32_t level);
  void land_on_models(std::int32_t level, std::span<const SupportContact> from);
  void mark_near(const PlatePoint& place, std::int32_t level, std::vector<std::uint8_t>& near) const;
  void keep_to_room(std::int32_t level);
  [[nodiscard]] Cost cost_at(const ClearanceField::Cell& cell) const;
  [[nodiscard]] std::optional<Step> first_step(const PlatePoint& point) const;
  [[nodiscard]] std::optional<ClearanceField::Cell> next_step(const ClearanceField::Cell& cell) const;
  [[nodiscard]] std::optional<std::vector<PlatePoint>> steps_from(const PlatePoint& point) const;
  [[nodiscard]] bool ends_at(const ClearanceField::Cell& cell) const;
  [[nodiscard]] SupportPath::Stretch longest_stretch(std::span<const PlatePoint> steps,
                                                     std::size_t& reached) const;
  [[nodiscard]] double room_along(const PlateSegment& segment) const;

  const ClearanceField& field_;
  PathWidths widths_;
  End end_;
  Cost straight_, aside_, across_;  // to the level beneath: in the same column, in the next, over a corner
  std::vector<Cost> costs_;         // by cell
};

}  // namespace contourd
