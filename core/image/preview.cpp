#include "core/image/preview.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace contourd {
namespace {

// Sine and cosine of the eye's turn to the right, 35 degrees.
constexpr double kSinTurn = 0.573576436, kCosTurn = 0.819152044;

// The direction to the light, which is at the left, in front and above; about of length 1.
constexpr PreviewPlace kLight{-0.36, -0.56, 0.75};

// Returns the grey value of a surface by the cosine of the angle between its normal and the light.
std::uint8_t shade_of(double cosine) {
  constexpr double kAmbient = 60, kDiffuse = 190;
  return static_cast<std::uint8_t>(kAmbient + kDiffuse * std::clamp(cosine, 0.0, 1.0));
}

double dot(const PreviewPlace& a, const PreviewPlace& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The eye looks along -kTowardsEye, 25 degrees above the horizon. The three vectors are an orthonormal base:
// across the picture, up the picture, out of it.
constexpr double kSin25 = 0.422618262, kCos25 = 0.906307787;
constexpr PreviewPlace kRight{kCosTurn, kSinTurn, 0};
constexpr PreviewPlace kUp{-kSinTurn * kSin25, kCosTurn* kSin25, kCos25};
constexpr PreviewPlace kTowardsEye{kSinTurn * kCos25, -kCosTurn* kCos25, kSin25};

// Rounding of the weights must not lose heights exactly at the top.
constexpr double kRoundingMm = 1e-6;

constexpr double kFrame = 0.06;  // share of the picture, on each side

// Limit for the pixels examined, at some nanoseconds each. A picture of 720 x 720 pixels of a sound model
// takes a hundredth of it; thousands of facets behind each other that fill the picture take more.
constexpr double kMostLooks = 1e9;

class PreviewCanvas {
 public:
  PreviewCanvas(std::span<const PreviewPart> parts, double top_z, Pixels width, Pixels height)
      : image_(width, height),
        depth_(image_.pixels().size(), -std::numeric_limits<double>::infinity()),
        top_z_(top_z),
        has_supports_(std::ranges::any_of(parts, &PreviewPart::is_support)) {
    frame(parts);
  }

  // Returns roughly how many pixels draw() examines for the part.
  [[nodiscard]] double looks(const PreviewPart& part) {
    part_ = part;
    double sum = 0;
    for (const Facet& facet : part.facets) {
      const Corner a = project(facet.vertices[0]);
      const Corner b = project(facet.vertices[1]);
      const Corner c = project(facet.vertices[2]);
      const double area = std::fabs(doubled_area(a, b, c)) / 2;
      const double rows = std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y});
      if (std::isfinite(area + rows))
        sum += area + 3 * rows;  // up to a pixel on each side, and one for the row
    }
    return sum;
  }

  void draw(const PreviewPart& part) {
    part_ = part;
    for (const Facet& facet : part.facets)
      draw(facet);
  }

  // `factor` is the number of pixels of the picture, along each side, for one that was drawn.
  Preview take(int factor) {
    return {std::move(image_), scale_ * factor, {offset_x_ * factor, offset_y_ * factor}};
  }

 private:
  struct Corner {
    double x, y, depth, z;
  };

  [[nodiscard]] static PreviewPlace moved(const Vertex& v, const PreviewPart& part) {
    return {v.x + part.offset.x, v.y + part.offset.y, v.z + part.offset.z};
  }

  void frame(std::span<const PreviewPart> parts) {
    double min_x = HUGE_VAL, max_x = -HUGE_VAL, min_y = HUGE_VAL, max_y = -HUGE_VAL;
    for (const PreviewPart& part : parts) {
      for (const Facet& facet : part.facets) {
        for (const Vertex& v : facet.vertices) {
          const PreviewPlace p = moved(v, part);
          min_x = std::min(min_x, dot(p, kRight));
          max_x = std::max(max_x, dot(p, kRight));
          min_y = std::min(min_y, dot(p, kUp));
          max_y = std::max(max_y, dot(p, kUp));
        }
      }
    }
    const double width = image_.width().count(), height = image_.height().count();
    const double room = 1 - 2 * kFrame;
    const double smallest = std::numeric_limits<double>::min();
    scale_ = std::min(width * room / std::max(max_x - min_x, smallest),
                      height * room / std::max(max_y - min_y, smallest));
    offset_x_ = width / 2 - (min_x + max_x) / 2 * scale_;
    offset_y_ = height / 2 + (min_y + max_y) / 2 * scale_;
  }

  [[nodiscard]] Corner project(const Vertex& v) const {
    const PreviewPlace p = moved(v, part_);
    return {dot(p, kRight) * scale_ + offset_x_, offset_y_ - dot(p, kUp) * scale_, dot(p, kTowardsEye), p.z};
  }

  [[nodiscard]] static double doubled_area(const Corner& a, const Corner& b, const Corner& c) {
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  }

  [[nodiscard]] static std::int32_t clamped(double value, Pixels limit) {
    return static_cast<std::int32_t>(std::clamp(value, 0.0, static_cast<double>(limit.count())));
  }

  // Returns the first column, and the one past the last, that the facet may cover at this y: a pixel more on
  // each side than it does, since the weights decide.
  [[nodiscard]] std::pair<std::int32_t, std::int32_t> columns_at(double y, const Corner& a, const Corner& b,
                                                                 const Corner& c) const {
    double left = HUGE_VAL, right = -HUGE_VAL;
    for (const auto& [from, to] : {std::pair{&a, &b}, std::pair{&b, &c}, std::pair{&c, &a}}) {
      if (y < std::min(from->y, to->y) || y > std::max(from->y, to->y)) continue;
      const double height = to->y - from->y;
      const double part = height != 0 ? (y - from->y) / height : 0;
      const double x = from->x + part * (to->x - from->x);
      left = std::min({left, x, height != 0 ? x : to->x});
      right = std::max({right, x, height != 0 ? x : to->x});
    }
    return {clamped(std::floor(left) - 1, image_.width()), clamped(std::ceil(right) + 1, image_.width())};
  }

  void draw(const Facet& facet) {
    const Corner a = project(facet.vertices[0]);
    const Corner b = project(facet.vertices[1]);
    const Corner c = project(facet.vertices[2]);
    const double area = doubled_area(a, b, c);
    if (!(std::fabs(area) > 0.0) || !std::isfinite(area)) return;
    std::uint8_t grey = shade(facet);
    if (has_supports_) grey = static_cast<std::uint8_t>((grey & ~1U) | (part_.is_support ? 1U : 0U));
    const std::int32_t top = clamped(std::floor(std::min({a.y, b.y, c.y})), image_.height());
    const std::int32_t bottom = clamped(std::ceil(std::max({a.y, b.y, c.y})), image_.height());
    for (std::int32_t row = top; row < bottom; ++row) {
      const double y = row + 0.5;
      const auto [left, right] = columns_at(y, a, b, c);
      for (std::int32_t column = left; column < right; ++column) {
        const double x = column + 0.5;
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
    const PreviewPlace u{static_cast<double>(b.x) - a.x, static_cast<double>(b.y) - a.y,
                         static_cast<double>(b.z) - a.z};
    const PreviewPlace v{static_cast<double>(c.x) - a.x, static_cast<double>(c.y) - a.y,
                         static_cast<double>(c.z) - a.z};
    PreviewPlace normal{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0.0)) return shade_of(0);
    // A surface seen from behind (a turned facet, or the inside of a half-printed part) is lit as if seen
    // from the front.
    const double facing = dot(normal, kTowardsEye) < 0 ? -1.0 : 1.0;
    return shade_of(facing * dot(normal, kLight) / length);
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
  bool has_supports_;
  PreviewPart part_;  // the part being drawn
  double scale_ = 1, offset_x_ = 0, offset_y_ = 0;
};

Mask enlarged(const Mask& picture, std::int32_t factor, Pixels width, Pixels height) {
  Mask large(width, height);
  for (std::int32_t y = 0; y < height.count(); ++y) {
    const auto from = picture.row(y / factor);
    const auto to = large.row(y);
    for (std::size_t x = 0; x < to.size(); ++x)
      to[x] = from[x / static_cast<std::size_t>(factor)];
  }
  return large;
}

}  // namespace

PixelPoint Preview::at(const PreviewPlace& place) const {
  return {origin.x + dot(place, kRight) * scale, origin.y - dot(place, kUp) * scale};
}

Preview render_preview(std::span<const PreviewPart> parts, Millimeters top, Pixels width, Pixels height) {
  PreviewCanvas canvas(parts, top.count(), width, height);
  double looks = 0;
  for (const PreviewPart& part : parts)
    looks += canvas.looks(part);
  const double longest = std::max(width.count(), height.count());
  const auto factor =
      static_cast<std::int32_t>(std::ceil(std::clamp(std::sqrt(looks / kMostLooks), 1.0, longest)));
  const auto divided = [factor](Pixels side) { return Pixels{(side.count() + factor - 1) / factor}; };
  if (factor > 1) canvas = PreviewCanvas(parts, top.count(), divided(width), divided(height));
  for (const PreviewPart& part : parts)
    canvas.draw(part);
  Preview preview = canvas.take(factor);
  if (factor > 1) preview.picture = enlarged(preview.picture, factor, width, height);
  return preview;
}

Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width, Pixels height) {
  const PreviewPart part{facets};
  return render_preview(std::span(&part, 1), top_z, width, height).picture;
}

}  // namespace contourd
