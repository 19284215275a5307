#include "core/geometry/vertex_numbers.hpp"

#include <bit>
#include <cstddef>

namespace contourd {
namespace {

constexpr std::uint32_t kEmpty = 0xFFFFFFFF;

std::uint64_t hash_bits(const Vertex& v) {
  // -0 + 0 is 0, so that both zeros hash alike.
  std::uint64_t hash = std::bit_cast<std::uint32_t>(v.x + 0.0F);
  for (const float coordinate : {v.y, v.z}) {
    hash = (hash ^ (hash >> 29)) * 0x9E3779B97F4A7C15U + std::bit_cast<std::uint32_t>(coordinate + 0.0F);
  }
  return (hash ^ (hash >> 32)) * 0xBF58476D1CE4E5B9U >> 16;
}

class VertexTable {
 public:
  // A closed mesh has half as many vertices as facets.
  explicit VertexTable(std::size_t facets)
      : slots_(std::bit_ceil(2 * facets + 1), kEmpty), last_(slots_.size() - 1) {
    vertices_.reserve(facets / 2 + 2);
  }

  std::uint32_t number_of(const Vertex& vertex) {
    std::uint32_t& slot = slots_[place_of(vertex)];
    if (slot == kEmpty) {
      slot = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
      if (vertices_.size() > slots_.size() / 2) grow();
      return static_cast<std::uint32_t>(vertices_.size() - 1);
    }
    return slot;
  }

 private:
  [[nodiscard]] std::size_t place_of(const Vertex& vertex) const {
    const std::uint32_t* const slots = slots_.data();
    const Vertex* const vertices = vertices_.data();
    std::size_t place = hash_bits(vertex) & last_;
    while (slots[place] != kEmpty && !(vertices[slots[place]] == vertex))
      place = (place + 1) & last_;
    return place;
  }

  void grow() {
    slots_.assign(slots_.size() * 2, kEmpty);
    last_ = slots_.size() - 1;
    for (std::uint32_t i = 0; i < vertices_.size(); ++i)
      slots_[place_of(vertices_[i])] = i;
  }

  std::vector<std::uint32_t> slots_;  // open addressing
  std::size_t last_;                  // the last slot's index
  std::vector<Vertex> vertices_;
};

}  // namespace

std::vector<Corners> number_vertices(std::span<const Facet> facets) {
  VertexTable table(facets.size());
  std::vector<Corners> corners(facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i)
      corners[f][i] = table.number_of(facets[f].vertices[i]);
  }
  return corners;
}

}  // namespace contourd
