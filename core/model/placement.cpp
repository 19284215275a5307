#include "core/model/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/contract/expects.hpp"
#include "core/model/sine_cosine.hpp"

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

Matrix turn_about_axes(const Orientation& orientation) {
  const auto [sx, cx] = sine_cosine(orientation.x_deg);
  const auto [sy, cy] = sine_cosine(orientation.y_deg);
  const auto [sz, cz] = sine_cosine(orientation.z_deg);
  const Matrix about_x{{{1, 0, 0}, {0, cx, -sx}, {0, sx, cx}}};
  const Matrix about_y{{{cy, 0, sy}, {0, 1, 0}, {-sy, 0, cy}}};
  const Matrix about_z{{{cz, -sz, 0}, {sz, cz, 0}, {0, 0, 1}}};
  return multiply(about_z, multiply(about_y, about_x));
}

// Returns the vector of length 1 in this direction, without over- or underflow.
Direction unit_vector(Direction n) {
  const double largest = std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
  n = {n.x / largest, n.y / largest, n.z / largest};
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  return {n.x / length, n.y / length, n.z / length};
}

// Returns the shortest rotation that takes the unit vector n to (0, 0, 1), by Rodrigues' formula: about v = n
// x (0, 0, 1), R = I + [v] + [v]^2 (1 - n.z) / |v|^2. Uses only + - * / and the square root, which every
// machine rounds alike.
Matrix turn_upwards(const Direction& direction) {
  const Direction n = unit_vector(direction);
  const double across = std::max(std::fabs(n.x), std::fabs(n.y));
  if (across == 0.0)
    return n.z > 0 ? Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}} : Matrix{{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
  // Only v's direction is used: |v|^2 itself may be too small for a double.
  const double x = n.x / across, y = n.y / across;
  const double k = (1 - n.z) / (x * x + y * y);
  return {{{1 - x * x * k, -x * y * k, -n.x}, {-x * y * k, 1 - y * y * k, -n.y}, {n.x, n.y, n.z}}};
}

Matrix matrix_of(const Orientation& orientation) {
  Matrix matrix = orientation.up ? turn_upwards(*orientation.up) : turn_about_axes(orientation);
  const double factors[]{orientation.scale.x, orientation.scale.y, orientation.scale.z};
  for (std::size_t row = 0; row < 3; ++row) {
    for (double& element : matrix[row])
      element *= factors[row];
  }
  return matrix;
}

bool is_direction(const Direction& d) {
  return std::isfinite(d.x) && std::isfinite(d.y) && std::isfinite(d.z) && d != Direction{0, 0, 0};
}

}  // namespace

PlateAxes axes_with_up(const Direction& up) {
  expects(is_direction(up), "the upward direction is finite and not zero");
  const Matrix m = turn_upwards(up);
  const auto row = [&m](std::size_t i) { return Direction{m[i][0], m[i][1], m[i][2]}; };
  return {row(0), row(1), row(2)};
}

void orient(std::span<Facet> facets, const Orientation& orientation) {
  expects(!orientation.up || is_direction(*orientation.up), "the upward direction is finite and not zero");
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
