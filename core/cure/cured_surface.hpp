// The surface of the part that a print's light makes, as facets. Not thread-safe.
//
// The dose is known at the middles of pixels, there at all heights: within a layer it falls with the depth by
// a known factor (see CuredLayers). The surface is where the dose falls to Ec: on the vertical lines through
// the middles at its exact height, and between two middles where walls are measured (see wall_between()), on
// some levels. Between four lines and two levels, facets separate the solid corners from the liquid ones
// (marching cubes, Lorensen and Cline 1987). Solid corners that face each other across a side stay apart in
// both cells of that side, so that the surface is closed everywhere.
//
// The dose jumps at each layer's end. Where lines go through every pixel, both sides of the end are levels,
// so that tops are level and a slope has the stairs of its layers. Otherwise the levels are middles of
// layers, about as far apart as the lines.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/cure/cured_layers.hpp"
#include "core/cure/surface_rays.hpp"
#include "core/geometry/facet.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

class CuredSurface {
 public:
  // Prepares the surface on a window of a display's pixels, on the lines through every `step`-th pixel in
  // each direction. A wall between two lines stays at its own pixel. What is thinner than the distance of
  // lines may be left out, and a gap filled. `sink` gets the facets, counter-clockwise seen from outside, in
  // millimetres from the plate's centre and above it. REQUIRES: step >= 1, a window with pixels.
  CuredSurface(const DisplayGeometry& display, const PixelWindow& window, std::int32_t step,
               std::function<void(const Facet&)> sink);

  // Adds the layer below those that were added before, with the doses that CuredLayers returned. REQUIRES: a
  // dose for each pixel of the window.
  void add_layer(const LayerDose& layer, const CuredLayers& cured, std::span<const float> dose);
  // Closes the surface beneath the lowest layer. Must be the last call.
  void finish();

 private:
  // A height at which nodes are solid or not.
  struct Level {
    double height_mm = 0;
    double least = 1;  // the dose, over Ec at the layer's top, from which on a pixel is solid here
    std::shared_ptr<const std::vector<float>> dose{};  // at the layer's top, by pixel of the window
    std::vector<std::uint8_t> solid{};                 // by node
  };
  // The part of a layer that is above the plate.
  struct Slab {
    const LayerDose& layer;
    const CuredLayers& cured;
    std::shared_ptr<const std::vector<float>> dose;
    double top_mm, bottom_mm;
  };

  [[nodiscard]] static double least_at(double height_mm, const Slab& slab);
  void go_down_to(double height_mm, const Slab& slab);
  void keep_level(double height_mm, const Slab& slab);
  void add_cells(const Level& lower);
  void add_cell(const Level& lower, std::size_t column, std::size_t row, std::uint8_t corners);
  [[nodiscard]] Vertex crossing(const Level& lower, std::size_t column, std::size_t row,
                                std::uint8_t edge) const;
  [[nodiscard]] double wall_on(const Level& level, const std::vector<std::int32_t>& nodes, std::size_t node,
                               std::int32_t line, bool along_rows) const;
  [[nodiscard]] Vertex vertex(double column, double row, double height_mm) const;

  DisplayGeometry display_;
  PixelWindow window_;
  std::function<void(const Facet&)> sink_;
  bool turns_round_;  // columns, rows and heights are a left-handed system on the plate
  // Pixels of the nodes' lines; the first and the last are beside the window and dark.
  std::vector<std::int32_t> columns_, rows_;
  double distance_mm_;  // between levels, at least; 0: both sides of all ends of layers are levels
  Level above_;         // the lowest level so far
  std::vector<std::uint8_t> solid_;                   // by node, at the lowest height so far
  std::vector<float> first_bottom_mm_, last_top_mm_;  // by node, of solids beneath above_
  std::vector<std::uint8_t> column_;                  // solid corners of a cell's side, by column of nodes
};

}  // namespace contourd
