#include "core/overhangs/surfaces_beneath.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

struct Vector {
  double x = 0, y = 0, z = 0;
};

Vector between(const PlatePoint& from, const PlatePoint& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

// Returns the facet's outward normal, twice as long as its area.
Vector normal_of(const PlatePoint& a, const PlatePoint& b, const PlatePoint& c) {
  const Vector u = between(a, b), v = between(a, c);
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

// The point of a facet over or under a point of the plate, or else the nearest point on its edges.
struct Nearest {
  PlatePoint point;
  double squared_distance;  // horizontal distance
};

Nearest nearest_on_side(const PlatePoint& from, const PlatePoint& to, Point place) {
  const double x = to.x - from.x, y = to.y - from.y;
  const double squared_length = x * x + y * y;
  const double along = (place.x - from.x) * x + (place.y - from.y) * y;
  const double part = squared_length > 0 ? std::clamp(along / squared_length, 0.0, 1.0) : 0.0;
  const PlatePoint point{from.x + part * x, from.y + part * y, from.z + part * (to.z - from.z)};
  const double dx = point.x - place.x, dy = point.y - place.y;
  return {point, dx * dx + dy * dy};
}

Nearest nearest_on(const PlatePoint& a, const PlatePoint& b, const PlatePoint& c, Point place) {
  const auto turn = [place](const PlatePoint& from, const PlatePoint& to) {
    return (to.x - from.x) * (place.y - from.y) - (to.y - from.y) * (place.x - from.x);
  };
  const double over_c = turn(a, b), over_a = turn(b, c), over_b = turn(c, a);
  const double all = over_a + over_b + over_c;
  const bool over =
      (over_a >= 0 && over_b >= 0 && over_c >= 0) || (over_a <= 0 && over_b <= 0 && over_c <= 0);
  if (over && all != 0) return {{place.x, place.y, (over_a * a.z + over_b * b.z + over_c * c.z) / all}, 0};
  const std::array<Nearest, 3> sides{nearest_on_side(a, b, place), nearest_on_side(b, c, place),
                                     nearest_on_side(c, a, place)};
  return *std::ranges::min_element(sides, {}, &Nearest::squared_distance);
}

// Returns the unit normal of the facets near a place, given the sum of their normals, turned so that it does
// not point up.
Direction outward_of(const Vector& sum) {
  const Vector down{sum.x, sum.y, std::min(sum.z, 0.0)};
  const double length = std::sqrt(down.x * down.x + down.y * down.y + down.z * down.z);
  if (!(length > 0)) return {0, 0, -1};
  return {down.x / length, down.y / length, down.z / length};
}

// The surface found for a place so far. A facet directly over the place is preferred, then the nearest one.
struct Found {
  double distance = std::numeric_limits<double>::infinity();  // squared
  std::optional<double> z_mm;
  Vector sum;  // weighted sum of the normals of nearby facets
};

void look_at(const PlatePoint& a, const PlatePoint& b, const PlatePoint& c, const SurfacePlace& place,
             Found& found) {
  const Vector normal = normal_of(a, b, c);
  if (!(normal.z < 0)) return;
  const Nearest nearest = nearest_on(a, b, c, place.at);
  if (nearest.squared_distance > place.reach_mm * place.reach_mm) return;
  if (nearest.point.z < place.low_mm || nearest.point.z > place.high_mm) return;
  // The weight limits a large facet to the area that can lie within reach.
  const double length = std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
  const double weight = std::min(1.0, 8 * place.reach_mm * place.reach_mm / length);
  Vector& sum = found.sum;
  sum = {sum.x + weight * normal.x, sum.y + weight * normal.y, sum.z + weight * normal.z};
  if (nearest.squared_distance > found.distance) return;
  if (nearest.squared_distance == found.distance && found.z_mm && *found.z_mm <= nearest.point.z) return;
  found.distance = nearest.squared_distance;
  found.z_mm = nearest.point.z;
}

// The box within reach of a place, in a model's own coordinates.
struct PlaceBox {
  double low_x, high_x, low_y, high_y, low_z, high_z;
  std::size_t place;  // the place's index
};

// Returns the boxes that meet the model's bounds, sorted by low_x. `origin` and `ones` are the places of the
// model's (0, 0, 0) and (1, 1, 0) on the plate.
std::vector<PlaceBox> boxes_in_model(std::span<const SurfacePlace> places, const Bounds& bounds,
                                     const PlatePoint& origin, const PlatePoint& ones) {
  std::vector<PlaceBox> boxes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const SurfacePlace& place = places[i];
    const double scale_x = ones.x - origin.x, scale_y = ones.y - origin.y;
    const double x = (place.at.x - origin.x) / scale_x, y = (place.at.y - origin.y) / scale_y;
    const double aside = place.reach_mm / std::fabs(scale_x), along = place.reach_mm / std::fabs(scale_y);
    const PlaceBox box{
        x - aside, x + aside, y - along, y + along, place.low_mm - origin.z, place.high_mm - origin.z, i};
    if (box.high_x >= bounds.min_x && box.low_x <= bounds.max_x && box.high_y >= bounds.min_y &&
        box.low_y <= bounds.max_y)
      boxes.push_back(box);
  }
  std::ranges::sort(boxes, {}, &PlaceBox::low_x);
  return boxes;
}

// Boxes indexed by their place, seen from above: for each of kSide columns the first box that begins in it,
// and for each of kSide x kSide cells a flag that says if a box touches the cell.
class BoxGrid {
 public:
  BoxGrid(std::vector<PlaceBox> boxes, const Bounds& bounds)
      : boxes_(std::move(boxes)),
        left_(bounds.min_x),
        front_(bounds.min_y),
        per_mm_(kSide / std::max({bounds.size_x(), bounds.size_y(), 1e-6})),
        any_(kSide * kSide, 0) {
    for (const PlaceBox& box : boxes_) {
      widest_ = std::max(widest_, box.high_x - box.low_x);
      for (std::size_t row = row_of(box.low_y); row <= row_of(box.high_y); ++row)
        for (std::size_t column = column_of(box.low_x); column <= column_of(box.high_x); ++column)
          any_[row * kSide + column] = 1;
    }
    std::size_t next = 0;
    for (std::size_t column = 0; column < kSide; ++column) {
      while (next < boxes_.size() && column_of(boxes_[next].low_x) < column)
        ++next;
      first_in_[column] = next;
    }
  }

  // Calls visit(place) for each place whose box meets the facet's bounds.
  template <typename Visit>
  void for_each_met(const std::array<Vertex, 3>& v, Visit&& visit) const {
    const auto [low_x, high_x] = std::minmax({v[0].x, v[1].x, v[2].x});
    const auto [low_y, high_y] = std::minmax({v[0].y, v[1].y, v[2].y});
    if (!has_any(low_x, high_x, low_y, high_y)) return;
    const auto [low_z, high_z] = std::minmax({v[0].z, v[1].z, v[2].z});
    for (std::size_t i = first_in_[column_of(low_x - widest_)];
         i < boxes_.size() && boxes_[i].low_x <= high_x; ++i) {
      const PlaceBox& box = boxes_[i];
      if (low_x <= box.high_x && low_y <= box.high_y && high_y >= box.low_y && low_z <= box.high_z &&
          high_z >= box.low_z)
        visit(box.place);
    }
  }

 private:
  static constexpr std::size_t kSide = 256;

  [[nodiscard]] static std::size_t cell_at(double cells) {
    return static_cast<std::size_t>(std::clamp(cells, 0.0, kSide - 1.0));
  }
  [[nodiscard]] std::size_t column_of(double x) const { return cell_at((x - left_) * per_mm_); }
  [[nodiscard]] std::size_t row_of(double y) const { return cell_at((y - front_) * per_mm_); }

  // Returns true without checking for areas so large that checking the cells takes longer than checking the
  // boxes.
  [[nodiscard]] bool has_any(double low_x, double high_x, double low_y, double high_y) const {
    const std::size_t left = column_of(low_x), right = column_of(high_x);
    const std::size_t front = row_of(low_y), back = row_of(high_y);
    if (right > left + 1 || back > front + 1) return true;
    const std::uint8_t* const near = any_.data() + front * kSide;
    const std::uint8_t* const far = any_.data() + back * kSide;
    return (near[left] | near[right] | far[left] | far[right]) != 0;
  }

  std::vector<PlaceBox> boxes_;
  double left_, front_, per_mm_;
  double widest_ = 0;
  std::vector<std::uint8_t> any_;
  std::array<std::size_t, kSide> first_in_{};
};

}  // namespace

std::vector<std::optional<Surface>> surfaces_beneath(std::span<const PlateModel> models,
                                                     const DisplayGeometry& display,
                                                     std::span<const SurfacePlace> places) {
  expects(std::ranges::all_of(models, [](const PlateModel& each) { return each.model != nullptr; }),
          "every model is there");
  std::vector<Found> found(places.size());
  for (const PlateModel& model : models) {
    const Bounds& bounds = model.model->bounds();
    const double lift_mm = model.elevation.lift(bounds).count();
    for (const PixelMap& copy : model.copies) {
      const auto placed = [&](const Vertex& v) {
        const Point at = on_plate(display, copy.to_pixels({v.x, v.y}));
        return PlatePoint{at.x, at.y, v.z + lift_mm};
      };
      std::vector<PlaceBox> near = boxes_in_model(places, bounds, placed({0, 0, 0}), placed({1, 1, 0}));
      if (near.empty()) continue;
      const BoxGrid boxes(std::move(near), bounds);
      for (const Facet& facet : model.model->facets()) {
        const auto& v = facet.vertices;
        boxes.for_each_met(v, [&](std::size_t place) {
          look_at(placed(v[0]), placed(v[1]), placed(v[2]), places[place], found[place]);
        });
      }
    }
  }
  std::vector<std::optional<Surface>> surfaces;
  for (const Found& each : found)
    surfaces.push_back(each.z_mm ? std::optional(Surface{*each.z_mm, outward_of(each.sum)}) : std::nullopt);
  return surfaces;
}

}  // namespace contourd
