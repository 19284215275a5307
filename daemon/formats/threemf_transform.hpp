// The transformations of 3MF: affine maps of row vectors (3MF Core Specification 1.4, 3.3). A value.
#pragma once

#include <array>
#include <string_view>

#include "core/geometry/facet.hpp"

namespace contourd {

struct ThreeMfTransform {
  // Four rows of three numbers; the last row is the translation.
  std::array<double, 12> m{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  bool operator==(const ThreeMfTransform&) const = default;

  // Returns the factor of volumes: negative if the transformation mirrors, which turns facets inside out.
  [[nodiscard]] double determinant() const;
  // Returns the transformed vertex, in floats, whose coordinates may be infinite.
  [[nodiscard]] Vertex operator()(const Vertex& vertex) const;
};

// Returns the transformation that applies `first`, then `second`.
[[nodiscard]] ThreeMfTransform combined(const ThreeMfTransform& first, const ThreeMfTransform& second);

// Reads 12 numbers between blanks. Throws ModelError.
[[nodiscard]] ThreeMfTransform parse_transform(std::string_view text);

}  // namespace contourd
