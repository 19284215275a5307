// The outlines of a print's layers, one on top of another, as a slicer made them: closed loops in
// millimetres, from the plate's centre, seen from above. Coordinates are stored as whole nanometres, eight
// bytes a point, and a layer equal to the one beneath takes none.
//
// Not thread-safe while layers are added; then any number of threads may read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

class OutlineStack {
 public:
  // The largest distance of a coordinate from the plate's centre.
  static constexpr Millimeters kFarthest{2000};

  // A rectangle around outlines.
  struct Box {
    Point low, high;
  };

  // Makes a stack without layers, for layers of one thickness. REQUIRES: thickness > 0.
  explicit OutlineStack(Nanometers thickness);

  // Adds the next layer. REQUIRES: no coordinate is farther from the plate's centre than kFarthest; loops do
  // not cross, solids run counter-clockwise and holes clockwise (see ContourUnion).
  void add(const Contours& outlines);

  [[nodiscard]] Nanometers thickness() const { return thickness_; }
  [[nodiscard]] std::size_t layers() const { return layers_.size(); }
  // Returns the memory that the outlines take, in bytes.
  [[nodiscard]] std::size_t bytes() const;
  // Returns the smallest rectangle around all outlines; nullopt if no layer has any.
  [[nodiscard]] std::optional<Box> box() const { return box_; }
  // Returns the number of points of the layer at a height, and of the layer that has the most.
  [[nodiscard]] std::size_t points_at(Nanometers height) const;
  [[nodiscard]] std::size_t most_points() const { return most_points_; }

  // Replaces `contours` by the outlines of the layer at a height above the plate: a layer's lower side
  // belongs to it, its upper side does not. There are none below the first layer and above the last one.
  // Allocates only while contours grow.
  void section_at(Nanometers height, Contours& contours) const;

 private:
  struct StoredPoint {
    std::int32_t x_nm, y_nm;
    bool operator==(const StoredPoint&) const = default;
  };
  // The place of a layer in points_ and loop_sizes_.
  struct Layer {
    std::size_t first_point, end_point, first_loop, end_loop;
  };

  [[nodiscard]] const Layer* layer_at(Nanometers height) const;
  [[nodiscard]] bool repeats_last(const Layer& added) const;
  void widen(const StoredPoint& point);

  Nanometers thickness_;
  std::vector<StoredPoint> points_;
  std::vector<std::uint32_t> loop_sizes_;  // numbers of points
  std::vector<Layer> layers_;
  std::optional<Box> box_;
  std::size_t most_points_ = 0;
};

}  // namespace contourd
