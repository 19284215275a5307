#include "tests/reference/scan_lines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace contourd::reference {
namespace {

constexpr int kLinesAPixel = 64;

struct Place {
  double x, y;
};

// The points at which a facet's outline passes the plane upwards and downwards, in pixels.
struct Cut {
  Place up{}, down{};
  bool crossed = false;
};

Cut cut_of(const Facet& facet, double z, const Picture& picture) {
  Cut cut;
  for (int i = 0; i < 3; ++i) {
    const Vertex& a = facet.vertices.at(static_cast<std::size_t>(i));
    const Vertex& b = facet.vertices.at(static_cast<std::size_t>((i + 1) % 3));
    if ((a.z > z) == (b.z > z)) continue;
    const double part = (z - a.z) / (double{b.z} - a.z);
    const double x = a.x + part * (double{b.x} - a.x), y = a.y + part * (double{b.y} - a.y);
    const Place place{(x - picture.center_x) * picture.pixels_per_mm + picture.width / 2.0,
                      picture.height / 2.0 - (y - picture.center_y) * picture.pixels_per_mm};
    (b.z > z ? cut.up : cut.down) = place;
    cut.crossed = true;
  }
  return cut;
}

using Crossing = std::pair<double, int>;  // x, and the change of the winding number there

// Returns the crossings of each line, from the top.
std::vector<std::vector<Crossing>> crossings_of(std::span<const Facet> facets, double z,
                                                const Picture& picture) {
  std::vector<std::vector<Crossing>> lines(static_cast<std::size_t>(picture.height * kLinesAPixel));
  for (const Facet& facet : facets) {
    const Cut cut = cut_of(facet, z, picture);
    if (!cut.crossed || cut.up.y == cut.down.y) continue;
    const bool downwards = cut.down.y < cut.up.y;
    const Place& top = downwards ? cut.down : cut.up;
    const Place& bottom = downwards ? cut.up : cut.down;
    const auto first = std::max(0.0, std::ceil(top.y * kLinesAPixel - 0.5));
    const auto end = std::min(static_cast<double>(lines.size()), std::ceil(bottom.y * kLinesAPixel - 0.5));
    for (auto line = static_cast<std::int64_t>(first); line < static_cast<std::int64_t>(end); ++line) {
      const double y = (static_cast<double>(line) + 0.5) / kLinesAPixel;
      const double x = top.x + (y - top.y) / (bottom.y - top.y) * (bottom.x - top.x);
      lines[static_cast<std::size_t>(line)].push_back({x, downwards ? 1 : -1});
    }
  }
  return lines;
}

void cover(std::span<double> row, double from, double to) {
  from = std::max(from, 0.0);
  to = std::min(to, static_cast<double>(row.size()));
  for (auto column = static_cast<std::size_t>(from); static_cast<double>(column) < to; ++column) {
    const auto left = static_cast<double>(column);
    row[column] += (std::min(to, left + 1) - std::max(from, left)) / kLinesAPixel;
  }
}

}  // namespace

std::vector<double> coverage_at(std::span<const Facet> facets, double z, const Picture& picture) {
  const auto width = static_cast<std::size_t>(picture.width);
  std::vector<double> coverage(width * static_cast<std::size_t>(picture.height));
  std::vector<std::vector<Crossing>> lines = crossings_of(facets, z, picture);
  for (std::size_t line = 0; line < lines.size(); ++line) {
    std::sort(lines[line].begin(), lines[line].end());
    int winding = 0;
    double from = 0;
    for (const auto& [x, change] : lines[line]) {
      if (winding != 0) cover(std::span(coverage).subspan(line / kLinesAPixel * width, width), from, x);
      winding += change;
      from = x;
    }
  }
  return coverage;
}

double overlap_of(std::span<const double> coverage, std::span<const std::uint8_t> mask) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    both += std::min(coverage[i], mask[i] / 255.0);
    either += std::max(coverage[i], mask[i] / 255.0);
  }
  return either > 0 ? both / either : 1;
}

}  // namespace contourd::reference
