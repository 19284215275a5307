// Shared by the tests of supports: models as a sweep sees them, supports for given places, and checks that
// hold for all supports, computed from facets and primitives alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/routing/support_layout.hpp"
#include "core/support/plate_segment.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// A build area of 40 by 30 mm.
inline const DisplayGeometry kBuildArea{Pixels{800}, Pixels{600}, Micrometers{50.0}};

// Returns a model whose facets stand as they are: in millimetres from the plate's centre, and above the
// plate.
inline PlateModel standing(models::Facets facets, const DisplayGeometry& display) {
  auto model = std::make_shared<const HeightIndex>(std::move(facets));
  const Nanometers above{std::llround(model->bounds().min_z * 1e6)};
  return {{std::move(model), Elevation(above)}, {PixelMap::true_scale(display, {0, 0})}};
}

// Fills `layers` as a sweep would: pixels of 100 um, layers of 50 um, a margin of two pixels.
inline void stack(std::vector<models::Facets> all, const DisplayGeometry& build_area, LitLayers& layers) {
  const DisplayGeometry display{
      Pixels{static_cast<std::int32_t>(std::ceil(build_area.width_mm() / 0.1)) + 4},
      Pixels{static_cast<std::int32_t>(std::ceil(build_area.height_mm() / 0.1)) + 4}, Micrometers{100.0}};
  std::vector<PlateModel> models;
  Millimeters top{0};
  for (models::Facets& facets : all) {
    models.push_back(standing(std::move(facets), display));
    top = std::max(top, models.back().top());
  }
  ContourEngine engine(std::move(models), {display});
  const Nanometers step{50'000};
  layers.begin(display, step);
  Mask half(display.width, display.height);
  MaskRuns lit;
  for (Nanometers height = step / 2; to_millimeters(height) < top; height += step) {
    const Mask& mask = engine.mask_at(height);
    for (std::int32_t row = 0; row < display.height.count(); ++row) {
      std::ranges::transform(mask.row(row), half.row(row).begin(), [](std::uint8_t grey) {
        return grey >= 128 ? std::uint8_t{255} : std::uint8_t{0};
      });
    }
    lit.extract(half);
    layers.layer(height, lit);
  }
}

inline double distance(const PlatePoint& p, const Facet& facet) {
  // Finds the nearest point of a triangle by the region in which p lies (Ericson, Real-Time Collision
  // Detection).
  const auto sub = [](const PlatePoint& a, const PlatePoint& b) {
    return PlatePoint{a.x - b.x, a.y - b.y, a.z - b.z};
  };
  const auto dot = [](const PlatePoint& a, const PlatePoint& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  const auto point = [](const Vertex& v) { return PlatePoint{v.x, v.y, v.z}; };
  const PlatePoint a = point(facet.vertices[0]), b = point(facet.vertices[1]), c = point(facet.vertices[2]);
  const auto to_side = [&](const PlatePoint& from, const PlatePoint& to) {
    const PlatePoint along = sub(to, from);
    const double squared = dot(along, along);
    const double part = squared > 0 ? std::clamp(dot(sub(p, from), along) / squared, 0.0, 1.0) : 0;
    return PlateSegment{p, PlateSegment{from, to}.at(part)}.length();
  };
  const double nearest = std::min({to_side(a, b), to_side(b, c), to_side(c, a)});
  const PlatePoint u = sub(b, a), v = sub(c, a), w = sub(p, a);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
  const double area = uu * vv - uv * uv;
  if (!(area > 0)) return nearest;
  const double s = (vv * wu - uv * wv) / area, t = (uu * wv - uv * wu) / area;
  if (s < 0 || t < 0 || s + t > 1) return nearest;
  return PlateSegment{p, {a.x + s * u.x + t * v.x, a.y + s * u.y + t * v.y, a.z + s * u.z + t * v.z}}
      .length();
}

inline double distance(const PlatePoint& p, const models::Facets& facets) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Facet& facet : facets)
    nearest = std::min(nearest, distance(p, facet));
  return nearest;
}

// True if the primitive ends in a model: tips and feet on models, which have no clearance.
inline bool is_tip(const SupportPrimitive& primitive, const SupportSettings& settings) {
  const auto* frustum = std::get_if<Frustum>(&primitive);
  const double least = settings.pillar_diameter.count() / 4 - 1e-9;
  return frustum != nullptr && std::min(frustum->lower_radius_mm, frustum->upper_radius_mm) < least;
}

// Returns the least distance of any branch, ball or foot to the facets, sampled every 0.1 mm.
inline double least_clearance(const Supports& supports, const models::Facets& facets,
                              const SupportSettings& settings) {
  double least = std::numeric_limits<double>::infinity();
  if (!supports.structure) return least;
  for (const SupportPrimitive& primitive : supports.structure->primitives()) {
    if (is_tip(primitive, settings)) continue;
    if (const auto* ball = std::get_if<Ball>(&primitive)) {
      least = std::min(least, distance(ball->center, facets) - ball->radius_mm);
      continue;
    }
    const auto& frustum = std::get<Frustum>(primitive);
    const PlateSegment axis{frustum.lower, frustum.upper};
    const double looks = std::ceil(axis.length() / 0.1);
    for (double i = 0; i <= looks; ++i) {
      const double radius =
          frustum.lower_radius_mm + (frustum.upper_radius_mm - frustum.lower_radius_mm) * i / looks;
      least = std::min(least, distance(axis.at(i / looks), facets) - radius);
    }
  }
  return least;
}

inline bool is_within(const Supports& supports, const DisplayGeometry& area) {
  const auto inside = [&area](const PlatePoint& p, double radius) {
    const double rounding = 1e-9;  // mm, error of a sum of two numbers of some tens
    return std::fabs(p.x) + radius <= area.width_mm() / 2 + rounding &&
           std::fabs(p.y) + radius <= area.height_mm() / 2 + rounding;
  };
  return std::ranges::all_of(supports.structure->primitives(), [&](const SupportPrimitive& primitive) {
    if (const auto* ball = std::get_if<Ball>(&primitive)) return inside(ball->center, ball->radius_mm);
    const auto& frustum = std::get<Frustum>(primitive);
    return inside(frustum.lower, frustum.lower_radius_mm) && inside(frustum.upper, frustum.upper_radius_mm);
  });
}

// True if no frustum is flatter than 45 degrees, within about a thousandth of a degree.
inline bool is_steep(const Supports& supports) {
  return std::ranges::all_of(supports.structure->primitives(), [](const SupportPrimitive& primitive) {
    const auto* frustum = std::get_if<Frustum>(&primitive);
    return frustum == nullptr ||
           level_distance(frustum->lower, frustum->upper) <= frustum->upper.z - frustum->lower.z + 1e-5;
  });
}

// True if every frustum stands on the plate, on another frustum that stands (its lower end lies on the axis
// of that one), or with its tip in a model.
inline bool is_connected(const Supports& supports, const models::Facets& facets) {
  std::vector<Frustum> frustums;
  for (const SupportPrimitive& primitive : supports.structure->primitives()) {
    if (const auto* frustum = std::get_if<Frustum>(&primitive)) frustums.push_back(*frustum);
  }
  const auto on_axis = [](const PlatePoint& p, const Frustum& frustum) {
    const double through = PlateSegment{frustum.lower, p}.length() + PlateSegment{p, frustum.upper}.length();
    return through <= PlateSegment{frustum.lower, frustum.upper}.length() + 1e-9;
  };
  std::vector<Frustum> stand;
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < frustums.size();) {
      const PlatePoint& low = frustums[i].lower;
      // A foot on a model begins inside the model, at the tip's depth.
      const bool stands = low.z == 0 ||
                          std::ranges::any_of(stand, [&](const Frustum& f) { return on_axis(low, f); }) ||
                          (frustums[i].lower_radius_mm == frustums[i].upper_radius_mm &&
                           frustums[i].upper_radius_mm < 0.5 && distance(frustums[i].upper, facets) < 0.2);
      if (!stands) {
        ++i;
        continue;
      }
      stand.push_back(frustums[i]);
      frustums.erase(frustums.begin() + static_cast<std::ptrdiff_t>(i));
      more = true;
    }
  }
  return frustums.empty();
}

}  // namespace contourd::testing
