// Rates directions of a model from its facets alone, without cutting sections. Not thread-safe: an object
// holds its working memory. Deterministic: the same figures on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/orientation/orientation_figures.hpp"
#include "core/orientation/rated_mesh.hpp"

namespace contourd {

// The area of an overhang that one contact is taken to hold, as PrusaSlicer has it by default (its
// PrintConfig.cpp), and the size of a grid cell that holds about one contact.
inline constexpr double kContactHoldsMm2 = 11.1, kContactCellMm = 3.3;

// Returns the volume of a support that holds a contact at this height, by PrusaSlicer's pillar and foot, with
// diameters of 1 and 4 mm.
[[nodiscard]] inline double pillar_mm3(double height_mm) {
  constexpr double kPillarMm2 = 0.785398, kFootMm3 = 4.7;
  return kPillarMm2 * height_mm + kFootMm3;
}

class OrientationRating {
 public:
  // In a whole model, overhangs are followed from the surfaces that carry them, as far as those reach; and a
  // part that begins on nothing needs a contact, however small the part is. A sample's facets are not
  // connected: all of their overhangs count, and nothing else does. `mesh` and `request` must outlive the
  // rating.
  enum class Mesh { Sample, Whole };
  OrientationRating(const RatedMesh& mesh, const OrientationRequest& request, Mesh kind);

  // Returns all figures but the score. REQUIRES: the direction is finite and not zero.
  [[nodiscard]] OrientationFigures rate(const Direction& up);

  // Returns the work done so far: facets looked at, and heights of facets that span several heights.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  // The model's height is divided into this many parts; sections are calculated at the heights between them.
  static constexpr std::size_t kParts = 128;
  struct Cell {
    double area = 0, moment = 0;  // overhangs in the cell: area seen from above; area times height
    double lowest = -1;           // height of a point with nothing under it; below 0: none
  };

  void measure(const PlateAxes& axes, OrientationFigures& figures);
  void look_at_sides(const Direction& up, OrientationFigures& figures);
  void add_to_sections(const RatedMesh::Side& side, double upwards);
  [[nodiscard]] double largest_section() const;
  [[nodiscard]] bool is_low(const RatedMesh::Side& side) const;
  void hang(const RatedMesh::Side& side, double area, OrientationFigures& figures);
  void find_carried(const Direction& up, bool stands);
  void reach_out();
  [[nodiscard]] bool is_carried(const RatedMesh::Side& side) const;
  [[nodiscard]] double apart(std::uint32_t a, std::uint32_t b) const;
  void find_lowest(const Direction& up, bool stands);
  void add_supports(bool stands, OrientationFigures& figures) const;

  const RatedMesh& mesh_;
  const OrientationRequest& request_;
  Mesh kind_;
  double plan_ = 1;              // factor by which scaling enlarges an area seen from above
  std::vector<double> heights_;  // by vertex: height above the lowest vertex, as printed
  std::vector<double> reach_;  // by vertex: distance from the surface that carries it, seen from above, in mm
  std::vector<double> downwards_;  // by vertex: see find_lowest()
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> on_plate_, hanging_;  // sides
  std::array<double, kParts + 1> whole_{};         // area added to every section below a height
  std::array<double, kParts + 1> cut_{};           // area added to the section at a height
  double parts_per_mm_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace contourd
