#include "core/orientation/orientation_rating.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"
#include "core/orientation/rated_mesh.hpp"

namespace contourd {
namespace {

// Sines of how far a facet looks down: beyond 45 degrees, by more than rounding, it hangs over; within 5
// degrees of straight down it lies flat.
constexpr double kHangs = 0.7085, kLiesFlat = 0.9962;
// A vertex this near to the lowest point lies on the plate: a layer.
constexpr double kOnPlateMm = 0.05;
// A face on the plate holds this many times its area during peeling. A support tip holds 88 times its own
// area (PrusaSlicer's figure), and the plate, with its long exposures, no less; the factor is a quarter of
// that, for models that lean.
constexpr double kPlateHolds = 20, kLeastStandingMm2 = 1;

}  // namespace

OrientationRating::OrientationRating(const RatedMesh& mesh, const OrientationRequest& request, Mesh kind)
    : mesh_(mesh),
      request_(request),
      kind_(kind),
      plan_(request.scale.x * request.scale.y),
      heights_(mesh.vertices().size()),
      cells_(mesh.cells()) {
  if (kind == Mesh::Sample) return;
  reach_.resize(heights_.size());
  downwards_.resize(heights_.size());
}

OrientationFigures OrientationRating::rate(const Direction& up) {
  expects(dot(up, up) > 0, "the upward direction is finite and not zero");
  const PlateAxes axes = axes_with_up(up);
  OrientationFigures figures;
  figures.up = axes.up;
  if (mesh_.vertices().empty()) return figures;
  measure(axes, figures);
  look_at_sides(axes.up, figures);
  figures.stands =
      figures.standing_mm2 >= kLeastStandingMm2 && figures.standing_mm2 * kPlateHolds >= figures.largest_mm2;
  if (figures.stands) {
    for (const std::uint32_t number : on_plate_) {
      const RatedMesh::Side& side = mesh_.sides()[number];
      if (side.keep_clean) figures.touched_mm2 -= side.along(axes.up) * plan_;
    }
  } else {
    hanging_.insert(hanging_.end(), on_plate_.begin(), on_plate_.end());
  }
  if (kind_ == Mesh::Whole) {
    find_carried(axes.up, figures.stands);
    reach_out();
  }
  for (const std::uint32_t number : hanging_) {
    const RatedMesh::Side& side = mesh_.sides()[number];
    if (kind_ == Mesh::Sample || !is_carried(side)) hang(side, -side.along(axes.up) * plan_, figures);
  }
  if (kind_ == Mesh::Whole) find_lowest(axes.up, figures.stands);
  add_supports(figures.stands, figures);
  if (request_.build) {
    const double lift = figures.stands ? 0 : request_.supports.lift.count();
    // A thousandth of a millimetre allows for the rounding of float coordinates.
    const auto fits = [](double size, Millimeters room) { return size <= room.count() + 1e-3; };
    figures.fits = fits(figures.size_x_mm, request_.build->width) &&
                   fits(figures.size_y_mm, request_.build->depth) &&
                   fits(figures.size_z_mm + lift, request_.build->height);
  }
  return figures;
}

void OrientationRating::measure(const PlateAxes& axes, OrientationFigures& figures) {
  double least[3]{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most[3]{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  const auto take = [&](std::size_t axis, double along) {
    least[axis] = std::min(least[axis], along);
    most[axis] = std::max(most[axis], along);
  };
  const std::span<const Vertex> vertices = mesh_.vertices();
  const Scale& scale = request_.scale;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const Direction place{vertices[v].x, vertices[v].y, vertices[v].z};
    take(0, dot(axes.right, place));
    take(1, dot(axes.back, place));
    heights_[v] = dot(axes.up, place) * scale.z;
    take(2, heights_[v]);
  }
  for (double& height : heights_)
    height -= least[2];
  figures.size_x_mm = (most[0] - least[0]) * scale.x;
  figures.size_y_mm = (most[1] - least[1]) * scale.y;
  figures.size_z_mm = most[2] - least[2];
  parts_per_mm_ = figures.size_z_mm > 0 ? kParts / figures.size_z_mm : 0;
}

void OrientationRating::look_at_sides(const Direction& up, OrientationFigures& figures) {
  std::ranges::fill(cells_, Cell{});
  whole_.fill(0);
  cut_.fill(0);
  on_plate_.clear();
  hanging_.clear();
  const std::span<const RatedMesh::Side> sides = mesh_.sides();
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const RatedMesh::Side& side = sides[i];
    const double upwards = side.along(up), size = side.size;
    add_to_sections(side, upwards * plan_);
    if (upwards >= -kHangs * size) continue;
    const bool lies_flat = upwards < -kLiesFlat * size && is_low(side);
    if (lies_flat) figures.standing_mm2 -= upwards * plan_;
    (lies_flat ? on_plate_ : hanging_).push_back(static_cast<std::uint32_t>(i));
  }
  steps_ += sides.size();
  figures.largest_mm2 = largest_section();
}

bool OrientationRating::is_low(const RatedMesh::Side& side) const {
  return std::ranges::all_of(side.corners, [this](std::uint32_t v) { return heights_[v] <= kOnPlateMm; });
}

void OrientationRating::hang(const RatedMesh::Side& side, double area, OrientationFigures& figures) {
  const auto [a, b, c] = side.corners;
  figures.overhang_mm2 += area;
  if (side.keep_clean) figures.touched_mm2 += area;
  Cell& cell = cells_[mesh_.cell_of(a)];
  cell.area += area;
  cell.moment += area * (heights_[a] + heights_[b] + heights_[c]) / 3;
}

// Adds a facet to the sections. By Gauss' theorem the area of a section is the area, seen from above, of the
// facets above it: those that look up minus those that look down. Of a facet that is cut, the part above the
// cut counts.
void OrientationRating::add_to_sections(const RatedMesh::Side& side, double upwards) {
  double a = heights_[side.corners[0]], b = heights_[side.corners[1]], c = heights_[side.corners[2]];
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  const auto first = static_cast<std::size_t>(a * parts_per_mm_) + 1;
  const auto last = std::min(static_cast<std::size_t>(c * parts_per_mm_), kParts);
  whole_[std::min(first - 1, kParts)] += upwards;
  for (std::size_t part = first; part <= last; ++part) {
    const double height = static_cast<double>(part) / parts_per_mm_;
    double above = 0;
    if (height <= b) {
      above = c > a && b > a ? 1 - (height - a) * (height - a) / ((b - a) * (c - a)) : 1;
    } else if (height < c) {
      above = (c - height) * (c - height) / ((c - b) * (c - a));
    }
    cut_[part] += upwards * above;
    ++steps_;
  }
}

double OrientationRating::largest_section() const {
  double largest = 0, above = whole_[kParts];
  for (std::size_t part = kParts - 1; part > 0; --part) {
    largest = std::max(largest, above + cut_[part]);
    above += whole_[part];
  }
  return largest;
}

// Sets the reach to 0 at the upper ends of facets that do not hang over: they carry the overhangs that begin
// there. Another body carries what begins within it, at facets that do not count.
void OrientationRating::find_carried(const Direction& up, bool stands) {
  std::ranges::fill(reach_, HUGE_VAL);
  for (const RatedMesh::Side& side : mesh_.sides()) {
    if (side.along(up) < -kHangs * double{side.size}) continue;
    const auto [a, b, c] = side.corners;
    const double middle = (heights_[a] + heights_[b] + heights_[c]) / 3;
    for (const std::uint32_t v : side.corners)
      if (heights_[v] > middle || side.size == 0) reach_[v] = 0;
  }
  if (!stands) return;
  for (std::size_t v = 0; v < heights_.size(); ++v)
    if (heights_[v] <= kOnPlateMm) reach_[v] = 0;
}

// Extends the reach from vertex to vertex along overhanging facets. It goes forwards and backwards through
// them, which comes close to the shortest distances.
void OrientationRating::reach_out() {
  constexpr int kPasses = 4;
  const std::span<const RatedMesh::Side> sides = mesh_.sides();
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t i = 0; i < hanging_.size(); ++i) {
      const Corners& corners = sides[hanging_[pass % 2 == 0 ? i : hanging_.size() - 1 - i]].corners;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        double &from = reach_[corners[corner]], &to = reach_[corners[(corner + 1) % 3]];
        if (from == to) continue;
        const double distance = apart(corners[corner], corners[(corner + 1) % 3]);
        to = std::min(to, from + distance);
        from = std::min(from, to + distance);
      }
    }
  }
}

// True if the facet's middle can be bridged: from a corner, or across from an edge.
bool OrientationRating::is_carried(const RatedMesh::Side& side) const {
  const double bridge = request_.supports.bridge.count();
  const auto [a, b, c] = side.corners;
  const double ab = apart(a, b), bc = apart(b, c), ca = apart(c, a);
  // The middle is two thirds of the median from a corner, and a third of the height from an edge.
  const auto median = [](double left, double right, double across) {
    return std::sqrt(std::max(0.0, 2 * left * left + 2 * right * right - across * across)) / 2;
  };
  const double half = (ab + bc + ca) / 2;
  const double area = std::sqrt(std::max(0.0, half * (half - ab) * (half - bc) * (half - ca)));
  const auto edge = [&](std::uint32_t from, std::uint32_t to, double length) {
    return length > 0 && std::max(reach_[from], reach_[to]) + 2 * area / length / 3 <= bridge;
  };
  return reach_[a] + median(ab, ca, bc) * 2 / 3 <= bridge ||
         reach_[b] + median(ab, bc, ca) * 2 / 3 <= bridge ||
         reach_[c] + median(bc, ca, ab) * 2 / 3 <= bridge || edge(a, b, ab) || edge(b, c, bc) ||
         edge(c, a, ca);
}

double OrientationRating::apart(std::uint32_t a, std::uint32_t b) const {
  const Vertex &from = mesh_.vertices()[a], &to = mesh_.vertices()[b];
  const double x = double{to.x} - from.x, y = double{to.y} - from.y, z = double{to.z} - from.z;
  const double up = (heights_[b] - heights_[a]) / request_.scale.z;
  return std::sqrt(std::max(0.0, x * x + y * y + z * z - up * up) * plan_);
}

// Finds the vertices that no facet joins to a lower one; of several at one height, one counts. If the
// vertex's facets look down, the model begins there; if they look up, it is the bottom of a pit; if one lies
// within another body, that body carries the vertex.
void OrientationRating::find_lowest(const Direction& up, bool stands) {
  std::ranges::fill(downwards_, 0.0);
  const auto lower = [this](std::uint32_t v, std::uint32_t other) {
    return heights_[v] < heights_[other] || (heights_[v] == heights_[other] && v < other) ? v : other;
  };
  for (const RatedMesh::Side& side : mesh_.sides()) {
    const auto [a, b, c] = side.corners;
    const std::uint32_t lowest = lower(lower(a, b), c);
    for (const std::uint32_t v : side.corners)
      downwards_[v] += v == lowest && !side.hidden ? side.along(up) : HUGE_VAL;
  }
  for (std::uint32_t v = 0; v < downwards_.size(); ++v) {
    if (!(downwards_[v] < 0) || (stands && heights_[v] <= kOnPlateMm)) continue;
    Cell& cell = cells_[mesh_.cell_of(v)];
    cell.lowest = cell.lowest < 0 ? heights_[v] : std::min(cell.lowest, heights_[v]);
  }
}

void OrientationRating::add_supports(bool stands, OrientationFigures& figures) const {
  const double lift = stands ? 0 : request_.supports.lift.count();
  for (const Cell& cell : cells_) {
    double contacts = cell.area / kContactHoldsMm2;
    double height = cell.area > 0 ? cell.moment / cell.area : 0;
    if (cell.lowest >= 0 && contacts < 1) {
      contacts = 1;
      height = cell.lowest;
    }
    figures.contacts += contacts;
    figures.support_mm3 += contacts * pillar_mm3(height + lift);
  }
}

}  // namespace contourd
