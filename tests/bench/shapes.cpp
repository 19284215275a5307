#include "tests/bench/shapes.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace contourd::bench {
namespace {

class Prism {
 public:
  Prism(const PrismShape& shape, double x, double y) : shape_(shape) {
    for (int i = 0; i < shape.sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / shape.sides;
      corners_.push_back({x + shape.radius_mm * std::cos(angle), y + shape.radius_mm * std::sin(angle)});
    }
    center_ = {x, y};
  }

  [[nodiscard]] Vertex corner(int side, int band) const {
    return lifted(corners_[static_cast<std::size_t>(side % shape_.sides)], band);
  }
  [[nodiscard]] Vertex center(int band) const { return lifted(center_, band); }

 private:
  [[nodiscard]] Vertex lifted(const Point& point, int band) const {
    return {static_cast<float>(point.x), static_cast<float>(point.y),
            static_cast<float>(shape_.height_mm * band / shape_.bands)};
  }

  PrismShape shape_;
  std::vector<Point> corners_;
  Point center_{};
};

}  // namespace

models::Facets prism(const PrismShape& shape, double x_mm, double y_mm) {
  const Prism points(shape, x_mm, y_mm);
  models::Facets facets;
  for (int side = 0; side < shape.sides; ++side) {
    for (int band = 0; band < shape.bands; ++band) {
      const Vertex a = points.corner(side, band), b = points.corner(side + 1, band);
      const Vertex c = points.corner(side + 1, band + 1), d = points.corner(side, band + 1);
      facets.push_back({{a, b, c}});
      facets.push_back({{a, c, d}});
    }
    facets.push_back({{points.center(0), points.corner(side + 1, 0), points.corner(side, 0)}});
    facets.push_back({{points.center(shape.bands), points.corner(side, shape.bands),
                       points.corner(side + 1, shape.bands)}});
  }
  return facets;
}

models::Facets field_of_prisms(int count) {
  constexpr PrismShape kShape{16, 1, 0.4, 1};
  models::Facets facets;
  for (int i = 0; i < count; ++i) {
    const int cell = i * (kFieldColumns * kFieldRows) / count;
    const models::Facets one = prism(kShape, cell % kFieldColumns + 0.5, cell / kFieldColumns + 0.5);
    facets.insert(facets.end(), one.begin(), one.end());
  }
  return facets;
}

}  // namespace contourd::bench
