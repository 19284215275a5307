// Rates directions of a model straight from its facets: no section is cut. Not thread-safe: holds what it
// works with. Deterministic: the same figures on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/orientation/orientation_figures.hpp"
#include "core/orientation/rated_mesh.hpp"

namespace contourd {

// What a contact is taken to hold where a surface hangs over, and how thick what it stands on is: as
// PrusaSlicer has them by default (its PrintConfig.cpp), and so wide a grid that a cell holds about one.
inline constexpr double kContactHoldsMm2 = 11.1, kContactCellMm = 3.3;

class OrientationRating {
 public:
  // Of a whole model, what hangs over is followed from what carries it, as far as that reaches; and where it
  // begins on nothing a contact is needed, however small that is. A sample's facets are not joined: of them,
  // all that hangs over counts, and no more. Both must outlive the rating.
  enum class Mesh { Sample, Whole };
  OrientationRating(const RatedMesh& mesh, const OrientationRequest& request, Mesh kind);

  // All but the score. REQUIRES: a direction that is finite and not zero.
  [[nodiscard]] OrientationFigures rate(const Direction& up);

  // Facets looked at so far, and heights of those that span several.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  // Sections are looked at in so many parts of the height, at the heights between them.
  static constexpr std::size_t kParts = 128;
  struct Cell {
    double area = 0, moment = 0;  // of what hangs over in it: seen from above; times its height
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
  double plan_ = 1;                // by how much an area is larger as it is printed, seen from above
  std::vector<double> heights_;    // by vertex, above the lowest one; as it is printed
  std::vector<double> reach_;      // by vertex: from what carries it, seen from above, in mm
  std::vector<double> downwards_;  // by vertex: see find_lowest()
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> on_plate_, hanging_;  // sides
  std::array<double, kParts + 1> whole_{};         // added to every section below a height
  std::array<double, kParts + 1> cut_{};           // and at one
  double parts_per_mm_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace contourd
