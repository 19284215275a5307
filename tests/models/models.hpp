// Models generated from formulas, for the tests, the benchmark and the demo. Facets are counter-clockwise as
// seen from outside; all closed models are watertight to the bit.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd::models {

using Facets = std::vector<Facet>;

// Returns an axis-aligned box of 12 facets.
[[nodiscard]] Facets box(Vertex low, Vertex high);

// Returns a closed surface of revolution around the z axis. The profile runs from the lowest point to the
// highest, in (radius, z) in mm, the first and the last on the axis.
[[nodiscard]] Facets lathe(std::span<const Point> profile, int sides);
// Returns a cone with its base on z = 0 and its point up.
[[nodiscard]] Facets cone(double radius_mm, double height_mm, int sides);
// Returns a ball around the origin with `bands` rings of facets.
[[nodiscard]] Facets globe(double radius_mm, int bands, int sides);

// Returns the surface value = 0 of a function, whose inside is where the value is negative, within a cube of
// `cells` cells a side around the origin (marching tetrahedra: every shared vertex is computed from the same
// two grid points, in the same order). The function must be positive on the cube's faces.
[[nodiscard]] Facets isosurface(const std::function<double(double, double, double)>& value,
                                double half_side_mm, int cells);

// Returns a ball of about 24 cells^2 / 4 facets.
[[nodiscard]] Facets sphere(double radius_mm, int cells);

// Returns a gyroid's walls within a sphere that stands on z = 0: many loops, holes and islands a layer.
[[nodiscard]] Facets gyroid_sphere(double radius_mm, double period_mm, int cells);

void translate(Facets& facets, float x, float y, float z);
// Reverses all facets.
void invert(Facets& facets);
[[nodiscard]] Facets inverted(Facets facets);
[[nodiscard]] Facets together(Facets facets, const Facets& more);
[[nodiscard]] Facets together(std::initializer_list<Facets> parts);

[[nodiscard]] std::vector<std::byte> to_binary_stl(std::span<const Facet> facets);
[[nodiscard]] std::string to_ascii_stl(std::span<const Facet> facets);
// Writes a binary STL file. Throws std::runtime_error if that fails.
void write_binary_stl(const std::filesystem::path& path, std::span<const Facet> facets);

}  // namespace contourd::models
