#include "core/image/preview.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace contourd {
namespace {

struct Vector {
  double x, y, z;
};

double dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The eye looks along -kTowardsEye, turned 35 degrees to the right and 25 degrees above the horizon. The
// three are an orthonormal base: across the picture, up the picture, out of it.
constexpr double kSinTurn = 0.573576436, kCosTurn = 0.819152044;
constexpr double kSinRise = 0.422618262, kCosRise = 0.906307787;
constexpr Vector kRight{kCosTurn, kSinTurn, 0};
constexpr Vector kUp{-kSinTurn * kSinRise, kCosTurn* kSinRise, kCosRise};
constexpr Vector kTowardsEye{kSinTurn * kCosRise, -kCosTurn* kCosRise, kSinRise};
constexpr Vector kLight{-0.36, -0.56, 0.75};  // from the left, the front and above; about of length 1

// Heights at exactly the top must not be lost to the rounding of the weights.
constexpr double kRoundingMm = 1e-6;

constexpr double kMargin = 0.06;  // of the picture, on each side
constexpr double kAmbient = 60, kDiffuse = 190;

class Canvas {
 public:
  Canvas(std::span<const PreviewPart> parts, double top_z, Pixels width, Pixels height)
      : image_(width, height),
        depth_(image_.pixels().size(), -std::numeric_limits<double>::infinity()),
        top_z_(top_z) {
    frame(parts);
    for (const PreviewPart& part : parts) {
      move_ = {part.x, part.y, part.z};
      for (const Facet& facet : part.facets)
        draw(facet);
    }
  }

  Mask take() { return std::move(image_); }

 private:
  struct Corner {
    double x, y, depth, z;
  };

  void frame(std::span<const PreviewPart> parts) {
    double min_x = HUGE_VAL, max_x = -HUGE_VAL, min_y = HUGE_VAL, max_y = -HUGE_VAL;
    for (const PreviewPart& part : parts) {
      for (const Facet& facet : part.facets) {
        for (const Vertex& v : facet.vertices) {
          const Vector p{v.x + part.x, v.y + part.y, v.z + part.z};
          min_x = std::min(min_x, dot(p, kRight));
          max_x = std::max(max_x, dot(p, kRight));
          min_y = std::min(min_y, dot(p, kUp));
          max_y = std::max(max_y, dot(p, kUp));
        }
      }
    }
    const double width = image_.width().count(), height = image_.height().count();
    const double room = 1 - 2 * kMargin;
    const double smallest = std::numeric_limits<double>::min();
    scale_ = std::min(width * room / std::max(max_x - min_x, smallest),
                      height * room / std::max(max_y - min_y, smallest));
    offset_x_ = width / 2 - (min_x + max_x) / 2 * scale_;
    offset_y_ = height / 2 + (min_y + max_y) / 2 * scale_;
  }

  [[nodiscard]] Corner project(const Vertex& v) const {
    const Vector p{v.x + move_.x, v.y + move_.y, v.z + move_.z};
    return {dot(p, kRight) * scale_ + offset_x_, offset_y_ - dot(p, kUp) * scale_, dot(p, kTowardsEye), p.z};
  }

  void draw(const Facet& facet) {
    const Corner a = project(facet.vertices[0]);
    const Corner b = project(facet.vertices[1]);
    const Corner c = project(facet.vertices[2]);
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::fabs(area) > 0.0) || !std::isfinite(area)) return;
    const std::uint8_t grey = shade(facet);
    const auto clamp_to = [](double value, std::int32_t limit) {
      return static_cast<std::int32_t>(std::clamp(value, 0.0, static_cast<double>(limit)));
    };
    const std::int32_t top = clamp_to(std::floor(std::min({a.y, b.y, c.y})), image_.height().count());
    const std::int32_t bottom = clamp_to(std::ceil(std::max({a.y, b.y, c.y})), image_.height().count());
    const std::int32_t left = clamp_to(std::floor(std::min({a.x, b.x, c.x})), image_.width().count());
    const std::int32_t right = clamp_to(std::ceil(std::max({a.x, b.x, c.x})), image_.width().count());
    for (std::int32_t row = top; row < bottom; ++row) {
      for (std::int32_t column = left; column < right; ++column) {
        const double x = column + 0.5, y = row + 0.5;
        // Barycentric weights of a, b and c at the pixel's centre.
        const double wb = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
        const double wc = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
        const double wa = 1 - wb - wc;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        if (wa * a.z + wb * b.z + wc * c.z > top_z_ + kRoundingMm) continue;
        plot(row, column, wa * a.depth + wb * b.depth + wc * c.depth, grey);
      }
    }
  }

  [[nodiscard]] static std::uint8_t shade(const Facet& facet) {
    const auto [a, b, c] = facet.vertices;
    const Vector u{static_cast<double>(b.x) - a.x, static_cast<double>(b.y) - a.y,
                   static_cast<double>(b.z) - a.z};
    const Vector v{static_cast<double>(c.x) - a.x, static_cast<double>(c.y) - a.y,
                   static_cast<double>(c.z) - a.z};
    Vector normal{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0.0)) return static_cast<std::uint8_t>(kAmbient);
    // A surface seen from behind (a turned facet, or the inside of a half-printed part) is lit as if seen
    // from the front.
    const double facing = dot(normal, kTowardsEye) < 0 ? -1.0 : 1.0;
    const double lit = facing * dot(normal, kLight) / length;
    return static_cast<std::uint8_t>(kAmbient + kDiffuse * std::clamp(lit, 0.0, 1.0));
  }

  void plot(std::int32_t row, std::int32_t column, double depth, std::uint8_t grey) {
    const auto width = static_cast<std::size_t>(image_.width().count());
    double& nearest = depth_[static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column)];
    if (depth <= nearest) return;
    nearest = depth;
    image_.row(row)[static_cast<std::size_t>(column)] = grey;
  }

  Mask image_;
  std::vector<double> depth_;
  double top_z_;
  Vector move_{};  // of the part that is being drawn
  double scale_ = 1, offset_x_ = 0, offset_y_ = 0;
};

}  // namespace

Mask render_preview(std::span<const PreviewPart> parts, Millimeters top, Pixels width, Pixels height) {
  return Canvas(parts, top.count(), width, height).take();
}

Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width, Pixels height) {
  const PreviewPart part{facets};
  return render_preview(std::span(&part, 1), top_z, width, height);
}

}  // namespace contourd
