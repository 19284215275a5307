// A cost field for support paths. A path leads around the models down to the plate or to a model's upper
// side, never flatter than 45 degrees. The field holds the cost of the cheapest path from each cell of a
// clearance field. It is computed from the plate up: the cost of a cell is the minimum, over its neighbours
// in the level beneath, of the neighbour's cost plus the cost of the move. A path then follows the cheapest
// cells and is drawn straight wherever there is room.
//
// Immutable once built; thread-safe. Deterministic. Memory: 2 bytes per cell of the clearance field.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/clearance/clearance_field.hpp"

namespace contourd {

// Radii along a path: that of a branch where there is room, that of a branch where there is little, and that
// of a foot on a model.
struct PathWidths {
  double usual_mm = 0, least_mm = 0, landing_mm = 0;
};

// A path from a point down. Each stretch has room for its radius.
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
    // The contacts from which paths may lead to a model; unused with End::Plate.
    std::span<const SupportContact> from;
  };

  // `field` must outlive the path field, which is unusable if `stop` was requested.
  SupportPathField(const ClearanceField& field, const Settings& settings, const std::stop_token& stop);

  [[nodiscard]] End end() const { return end_; }

  // Returns the place on the model's surface below the point on which a foot can stand; nullopt if the
  // surface is too far away or too steep.
  [[nodiscard]] std::optional<PlatePoint> landing_below(const PlatePoint& point) const;

  // Returns the approximate length of the path from the point, with narrow places counted twice; nullopt if
  // there is no path.
  [[nodiscard]] std::optional<double> length_from(const PlatePoint& point) const;
  // Returns the path from the point, with the room along each stretch checked; nullopt if there is no path.
  [[nodiscard]] std::optional<SupportPath> path_from(const PlatePoint& point) const;

 private:
  using Cost = std::uint16_t;
  static constexpr Cost kNoPath = 0xFFFF;
  // Length of one unit of cost.
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
  Cost straight_, aside_, across_;  // cost of a move to the level beneath: straight down, to a side
                                    // neighbour, to a corner neighbour
  std::vector<Cost> costs_;         // cost of the cheapest path, by cell
};

}  // namespace contourd
