#include "tests/reference/supported_print.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "core/support/support_structure.hpp"

namespace contourd::reference {
namespace {

constexpr Nanometers kLayer{50'000};
// A part contains a pixel with at least half the light. It is connected, in itself and to what is below, by
// pixels with at least a quarter: the rim of a hair may be greyer in one layer and brighter in the next,
// depending on the pixel grid.
constexpr std::uint8_t kSolid = 128, kLit = 64;

// The number of violations of a rule, and the first place.
struct Breaches {
  int count = 0;
  PlatePoint first;
  void add(const PlatePoint& place) {
    if (count++ == 0) first = place;
  }
  void tell(const char* what, std::vector<std::string>& all) const {
    if (count == 0) return;
    char text[200];
    std::snprintf(text, sizeof text, "%d %s, first at (%.2f, %.2f, %.2f) mm", count, what, first.x, first.y,
                  first.z);
    all.emplace_back(text);
  }
};

double distance(const PlatePoint& a, const PlatePoint& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z));
}

// --- parts with nothing below: each is flooded from pixel to pixel, also across corners

void find_floating(const Mask& below, const Mask& mask, double z_mm, const DisplayGeometry& display,
                   Breaches& breaches) {
  const std::int32_t width = mask.width().count(), height = mask.height().count();
  std::vector<std::uint8_t> seen(mask.pixels().size());
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start] != 0 || mask.pixels()[start] < kSolid) continue;
    bool held = false;
    seen[start] = 1;
    open.assign(1, start);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      held |= below.pixels()[at] >= kLit;
      const auto x = static_cast<std::int32_t>(at % static_cast<std::size_t>(width));
      const auto y = static_cast<std::int32_t>(at / static_cast<std::size_t>(width));
      for (int side = 0; side < 9; ++side) {
        const std::int32_t nx = x + side % 3 - 1, ny = y + side / 3 - 1;

        if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
        const auto next =
            static_cast<std::size_t>(ny) * static_cast<std::size_t>(width) + static_cast<std::size_t>(nx);
        if (seen[next] != 0 || mask.pixels()[next] < kLit) continue;
        seen[next] = 1;
        open.push_back(next);
      }
    }
    const Point place =
        on_plate(display, {static_cast<double>(start % static_cast<std::size_t>(width)) + 0.5,
                           static_cast<double>(start / static_cast<std::size_t>(width)) + 0.5});
    if (!held) breaches.add({place.x, place.y, z_mm});
  }
}

// --- facets indexed by cubes of a millimetre

class FacetCubes {
 public:
  explicit FacetCubes(const std::vector<PlateModel>& models, const DisplayGeometry& display) {
    for (const PlateModel& model : models) {
      for (const PixelMap& copy : model.copies)
        add(model, copy, display);
    }
  }

  // Returns the distance of the surface from a point, up to `most`.
  [[nodiscard]] double distance_from(const PlatePoint& p, double most) const {
    double least = most;
    for (int x = cube(p.x - most); x <= cube(p.x + most); ++x) {
      for (int y = cube(p.y - most); y <= cube(p.y + most); ++y) {
        for (int z = cube(p.z - most); z <= cube(p.z + most); ++z) {
          const auto found = cubes_.find({x, y, z});
          if (found == cubes_.end()) continue;
          for (const std::uint32_t triangle : found->second)
            least = std::min(least, distance_to(triangles_[triangle], p));
        }
      }
    }
    return least;
  }

 private:
  struct Triangle {
    PlatePoint a, b, c;
  };

  static int cube(double mm) { return static_cast<int>(std::floor(mm)); }

  void add(const PlateModel& model, const PixelMap& copy, const DisplayGeometry& display) {
    const double lift = model.elevation.lift(model.model->bounds()).count();
    const auto placed = [&](const Vertex& v) {
      const Point p = on_plate(display, copy.to_pixels({v.x, v.y}));
      return PlatePoint{p.x, p.y, v.z + lift};
    };
    for (const Facet& facet : model.model->facets()) {
      const Triangle t{placed(facet.vertices[0]), placed(facet.vertices[1]), placed(facet.vertices[2])};
      const auto number = static_cast<std::uint32_t>(triangles_.size());
      triangles_.push_back(t);
      const auto range = [&](double PlatePoint::*axis) {
        const auto [low, high] = std::minmax({t.a.*axis, t.b.*axis, t.c.*axis});
        return std::pair{cube(low), cube(high)};
      };
      const auto [x0, x1] = range(&PlatePoint::x);
      const auto [y0, y1] = range(&PlatePoint::y);
      const auto [z0, z1] = range(&PlatePoint::z);
      for (int x = x0; x <= x1; ++x) {
        for (int y = y0; y <= y1; ++y) {
          for (int z = z0; z <= z1; ++z)
            cubes_[{x, y, z}].push_back(number);
        }
      }
    }
  }

  static double to_side(const PlatePoint& p, const PlatePoint& a, const PlatePoint& b) {
    const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z, squared = x * x + y * y + z * z;
    const double t =
        squared > 0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y + (p.z - a.z) * z) / squared, 0.0, 1.0)
                    : 0.0;
    return distance(p, {a.x + t * x, a.y + t * y, a.z + t * z});
  }

  // The distance from the plane if the point's foot is inside all three sides, else from the nearest side.
  static double distance_to(const Triangle& t, const PlatePoint& p) {
    const double ux = t.b.x - t.a.x, uy = t.b.y - t.a.y, uz = t.b.z - t.a.z;
    const double vx = t.c.x - t.a.x, vy = t.c.y - t.a.y, vz = t.c.z - t.a.z;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double squared = nx * nx + ny * ny + nz * nz;
    const double wx = p.x - t.a.x, wy = p.y - t.a.y, wz = p.z - t.a.z;
    if (squared > 0) {
      const double s =
          ((wy * vz - wz * vy) * nx + (wz * vx - wx * vz) * ny + (wx * vy - wy * vx) * nz) / squared;
      const double r =
          ((uy * wz - uz * wy) * nx + (uz * wx - ux * wz) * ny + (ux * wy - uy * wx) * nz) / squared;
      if (s >= 0 && r >= 0 && s + r <= 1) return std::fabs(wx * nx + wy * ny + wz * nz) / std::sqrt(squared);
    }
    return std::min({to_side(p, t.a, t.b), to_side(p, t.b, t.c), to_side(p, t.c, t.a)});
  }

  std::vector<Triangle> triangles_;
  std::map<std::tuple<int, int, int>, std::vector<std::uint32_t>> cubes_;
};

// --- primitives

struct Sample {
  PlatePoint place;
  double radius_mm;
};

// Points along the axis, 0.1 mm apart.
std::vector<Sample> samples_of(const SupportPrimitive& primitive) {
  if (const auto* ball = std::get_if<Ball>(&primitive)) return {{ball->center, ball->radius_mm}};
  const auto& f = std::get<Frustum>(primitive);
  const int steps = static_cast<int>(distance(f.lower, f.upper) / 0.1) + 1;
  std::vector<Sample> samples;
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    samples.push_back({{f.lower.x + t * (f.upper.x - f.lower.x), f.lower.y + t * (f.upper.y - f.lower.y),
                        f.lower.z + t * (f.upper.z - f.lower.z)},
                       f.lower_radius_mm + t * (f.upper_radius_mm - f.lower_radius_mm)});
  }
  return samples;
}

// True if the primitive ends as thin as a tip: a tip, or a foot on a model.
bool is_tip(const SupportPrimitive& primitive, const SupportSettings& settings) {
  const auto* f = std::get_if<Frustum>(&primitive);
  return f != nullptr &&
         std::min(f->lower_radius_mm, f->upper_radius_mm) <= settings.tip_diameter.count() / 2 + 1e-6;
}

void find_outside(const SupportedPrint& print, Breaches& breaches) {
  const double x = print.display.width_mm() / 2, y = print.display.height_mm() / 2;
  for (const SupportPrimitive& primitive : print.primitives) {
    for (const Sample& at : samples_of(primitive)) {
      if (std::fabs(at.place.x) + at.radius_mm > x + 1e-9 ||
          std::fabs(at.place.y) + at.radius_mm > y + 1e-9 || at.place.z < -1e-9) {
        breaches.add(at.place);
        break;
      }
    }
  }
}

// Reports each primitive once, at its nearest place. A branch may begin at a tip's thick end, which is a
// tip's length from the surface. A flat end counts as if it were round. Samples are 0.1 mm apart, so the
// primitive may be slightly nearer in between: 0.02 mm of slack, since no point is more than 0.05 mm from a
// sample on the axis.
void find_near(const SupportedPrint& print, Breaches& breaches) {
  const FacetCubes facets(print.models, print.display);
  const double clearance = print.settings.clearance.count();
  for (const SupportPrimitive& primitive : print.primitives) {
    if (is_tip(primitive, print.settings)) continue;
    for (const Sample& at : samples_of(primitive)) {
      const double most = at.radius_mm + clearance - 0.02;
      if (facets.distance_from(at.place, most) < most) {
        breaches.add(at.place);
        break;
      }
    }
  }
}

// A pixel that belongs to both a support and a model must be at a tip.
void find_inside(const SupportedPrint& print, const Mask& model, const Mask& support, double z_mm,
                 Breaches& breaches) {
  const std::int32_t width = model.width().count();
  for (std::int32_t y = 0; y < model.height().count(); ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const auto column = static_cast<std::size_t>(x);
      if (model.row(y)[column] != 255 || support.row(y)[column] == 0) continue;
      const Point p = on_plate(print.display, {x + 0.5, y + 0.5});
      const PlatePoint place{p.x, p.y, z_mm};
      // Distance from the axis: the greatest radius, and a pixel.
      const bool at_a_tip = std::ranges::any_of(print.primitives, [&](const SupportPrimitive& primitive) {
        if (!is_tip(primitive, print.settings)) return false;
        return std::ranges::any_of(samples_of(primitive), [&](const Sample& at) {
          return distance(at.place, place) < at.radius_mm + 0.15;
        });
      });
      if (!at_a_tip) breaches.add(place);
    }
  }
}

}  // namespace

std::vector<std::string> broken_rules(const SupportedPrint& print) {
  const auto structure = std::make_shared<const SupportStructure>(print.primitives);
  ContourEngine both(print.models, {print.display}, structure), model(print.models, {print.display}),
      support({}, {print.display}, structure);
  Millimeters top{0};
  for (const PlateModel& each : print.models)
    top = std::max(top, each.top());
  Breaches floating, inside, near, outside, overloaded;
  std::optional<Mask> below;
  for (Nanometers height = kLayer / 2; to_millimeters(height) < top; height += kLayer) {
    const double z_mm = to_millimeters(height).count();
    const Mask& mask = both.mask_at(height);
    if (below) find_floating(*below, mask, z_mm, print.display, floating);
    below = mask;
    find_inside(print, model.mask_at(height), support.mask_at(height), z_mm, inside);
  }
  find_near(print, near);
  find_outside(print, outside);
  for (const SupportContact& contact : print.contacts) {
    if (contact.load_mm2 > print.settings.tip_holds_mm2 * (1 + 1e-9)) overloaded.add(contact.place);
  }
  std::vector<std::string> broken;
  floating.tell("parts of layers begin with nothing below", broken);
  inside.tell("pixels of supports are in a model away from tips", broken);
  near.tell("primitives are nearer to a model than the clearance", broken);
  outside.tell("primitives are outside the build volume", broken);
  overloaded.tell("contacts hold more than they can", broken);
  return broken;
}

}  // namespace contourd::reference
