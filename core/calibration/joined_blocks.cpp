#include "core/calibration/joined_blocks.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

using Triple = std::array<float, 3>;
using Cell = std::array<std::size_t, 3>;

Triple triple(const Vertex& vertex) {
  return {vertex.x, vertex.y, vertex.z};
}

// The cells into which the blocks' faces divide space.
class BlockGrid {
 public:
  explicit BlockGrid(std::span<const Block> blocks) {
    for (const Block& block : blocks)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        edges_[axis].push_back(triple(block.low)[axis]);
        edges_[axis].push_back(triple(block.high)[axis]);
      }
    for (std::vector<float>& edges : edges_) {
      std::ranges::sort(edges);
      edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    }
    solid_.resize(cells(0) * cells(1) * cells(2));
    for (const Block& block : blocks)
      fill(block);
  }

  [[nodiscard]] std::vector<Facet> surface() const {
    std::vector<Facet> facets;
    for (Cell cell{}; cell[2] < cells(2); ++cell[2])
      for (cell[1] = 0; cell[1] < cells(1); ++cell[1])
        for (cell[0] = 0; cell[0] < cells(0); ++cell[0])
          if (solid_[index(cell)]) add_faces(cell, facets);
    return facets;
  }

 private:
  [[nodiscard]] std::size_t cells(std::size_t axis) const {
    return edges_[axis].empty() ? 0 : edges_[axis].size() - 1;
  }
  [[nodiscard]] std::size_t index(const Cell& cell) const {
    return (cell[2] * cells(1) + cell[1]) * cells(0) + cell[0];
  }

  void fill(const Block& block) {
    Cell first{}, end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto edge = [this, axis](const Vertex& vertex) {
        const std::vector<float>& edges = edges_[axis];
        return static_cast<std::size_t>(std::ranges::lower_bound(edges, triple(vertex)[axis]) -
                                        edges.begin());
      };
      first[axis] = edge(block.low);
      end[axis] = edge(block.high);
    }
    for (Cell cell = first; cell[2] < end[2]; ++cell[2])
      for (cell[1] = first[1]; cell[1] < end[1]; ++cell[1])
        for (cell[0] = first[0]; cell[0] < end[0]; ++cell[0])
          solid_[index(cell)] = true;
  }

  // Adds the faces of a solid cell that have no solid on their other side.
  void add_faces(const Cell& cell, std::vector<Facet>& facets) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Cell next = cell, last = cell;
      ++next[axis];
      --last[axis];
      if (next[axis] == cells(axis) || !solid_[index(next)]) add_face(next, axis, true, facets);
      if (cell[axis] == 0 || !solid_[index(last)]) add_face(cell, axis, false, facets);
    }
  }

  // Adds the lower face of a cell along an axis.
  void add_face(const Cell& cell, std::size_t axis, bool faces_up, std::vector<Facet>& facets) const {
    const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
    const auto corner = [&](std::size_t along_second, std::size_t along_third) {
      Triple at{};
      at[axis] = edges_[axis][cell[axis]];
      at[second] = edges_[second][cell[second] + along_second];
      at[third] = edges_[third][cell[third] + along_third];
      return Vertex{at[0], at[1], at[2]};
    };
    const Vertex a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
    if (faces_up) {
      facets.push_back({{a, b, c}});
      facets.push_back({{a, c, d}});
    } else {
      facets.push_back({{a, c, b}});
      facets.push_back({{a, d, c}});
    }
  }

  std::array<std::vector<float>, 3> edges_;  // by axis: coordinates of faces, rising
  std::vector<bool> solid_;                  // by cell
};

}  // namespace

std::vector<Facet> joined(std::span<const Block> blocks) {
  for (const auto& [low, high] : blocks)
    expects(low.x < high.x && low.y < high.y && low.z < high.z, "a block has a volume");
  return BlockGrid(blocks).surface();
}

}  // namespace contourd
