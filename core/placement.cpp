#include "core/placement.hpp"

#include <array>
#include <cstddef>

#include "core/sine_cosine.hpp"

namespace contourd {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix product{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k)
        product[i][j] += a[i][k] * b[k][j];
    }
  }
  return product;
}

Matrix matrix_of(const Orientation& orientation) {
  const auto [sx, cx] = sine_cosine(orientation.x_deg);
  const auto [sy, cy] = sine_cosine(orientation.y_deg);
  const auto [sz, cz] = sine_cosine(orientation.z_deg);
  const Matrix about_x{{{1, 0, 0}, {0, cx, -sx}, {0, sx, cx}}};
  const Matrix about_y{{{cy, 0, sy}, {0, 1, 0}, {-sy, 0, cy}}};
  const Matrix about_z{{{cz, -sz, 0}, {sz, cz, 0}, {0, 0, 1}}};
  Matrix matrix = multiply(about_z, multiply(about_y, about_x));
  for (auto& row : matrix) {
    for (double& element : row)
      element *= orientation.scale;
  }
  return matrix;
}

}  // namespace

void orient(std::span<Facet> facets, const Orientation& orientation) {
  if (orientation.is_identity()) return;
  const Matrix m = matrix_of(orientation);
  const auto turned = [&m](const Vertex& v, std::size_t row) {
    return static_cast<float>(m[row][0] * v.x + m[row][1] * v.y + m[row][2] * v.z);
  };
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices)
      v = {turned(v, 0), turned(v, 1), turned(v, 2)};
  }
}

}  // namespace contourd
