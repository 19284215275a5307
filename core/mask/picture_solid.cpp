#include "core/mask/picture_solid.hpp"

#include <algorithm>
#include <array>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Two opposite corners of a box, the first one lower in all coordinates.
struct Corners {
  Vertex low, high;
};

// A rectangle on the plate, and the layers that stand on it.
struct LayeredBox {
  Point low, high;
  Nanometers thickness;
  std::size_t layers;
};

// Appends the twelve facets of a box, seen from outside counter-clockwise.
void append_box(const Corners& box, std::vector<Facet>& facets) {
  const auto corner = [&box](unsigned bits) {
    return Vertex{(bits & 1U) != 0 ? box.high.x : box.low.x, (bits & 2U) != 0 ? box.high.y : box.low.y,
                  (bits & 4U) != 0 ? box.high.z : box.low.z};
  };
  // The corners of each side, by their bits (x, y, z).
  constexpr std::array<std::array<unsigned, 4>, 6> kSides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kSides) {
    facets.push_back({{corner(a), corner(b), corner(c)}});
    facets.push_back({{corner(a), corner(c), corner(d)}});
  }
}

std::vector<Facet> facets_of(const LayeredBox& box) {
  const double top_mm = to_millimeters(box.thickness).count() * static_cast<double>(box.layers);
  const auto vertex = [](const Point& at, double z) {
    return Vertex{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(z)};
  };
  std::vector<Facet> facets;
  append_box({vertex(box.low, 0), vertex(box.high, top_mm)}, facets);
  return facets;
}

}  // namespace

std::vector<Facet> box_of(const PictureStack& pictures, const DisplayGeometry& display) {
  expects(display.width == pictures.width() && display.height == pictures.height(),
          "the display has the pictures' size");
  if (!pictures.lit()) return {};
  const PixelBox lit = *pictures.lit();
  const Point a = on_plate(display, {static_cast<double>(lit.left), static_cast<double>(lit.top)});
  const Point b = on_plate(display, {static_cast<double>(lit.right), static_cast<double>(lit.bottom)});
  return facets_of({{std::min(a.x, b.x), std::min(a.y, b.y)},
                    {std::max(a.x, b.x), std::max(a.y, b.y)},
                    pictures.thickness(),
                    pictures.layers()});
}

std::vector<Facet> box_of(const OutlineStack& outlines) {
  if (!outlines.box()) return {};
  return facets_of({outlines.box()->low, outlines.box()->high, outlines.thickness(), outlines.layers()});
}

}  // namespace contourd
