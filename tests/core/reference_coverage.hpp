// The part of each pixel that the non-zero set of polygons covers, by brute force: 64 lines through every row
// of pixels, exact along each. Shares only its points with the core.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/mask/pixel_map.hpp"

namespace contourd::testing {

inline constexpr int kReferenceLines = 64;

class ReferenceCoverage {
 public:
  ReferenceCoverage(int width, int height)
      : width_(width),
        height_(height),
        covered_(static_cast<std::size_t>(width * height)),
        mean_winding_(covered_.size()) {}

  void add(const std::vector<PixelPoint>& polygon) { polygons_.push_back(polygon); }

  // Returns the coverage, 0 to 1, row by row.
  const std::vector<double>& compute() {
    for (int line = 0; line < height_ * kReferenceLines; ++line)
      add_line(line);
    return covered_;
  }

  // True, after compute(), if no point is wound around more than once or the wrong way.
  [[nodiscard]] bool winds_once() const { return winds_once_; }
  // True if the mean winding number of some pixel shows this, by more than one line in 64 may miss.
  [[nodiscard]] bool shows_overlap() const {
    constexpr double kSlack = 1.0 / kReferenceLines;
    return std::ranges::any_of(mean_winding_,
                               [](double mean) { return mean < -kSlack || mean > 1 + kSlack; });
  }

 private:
  void add_line(int line) {
    const double y = (line + 0.5) / kReferenceLines;
    std::vector<std::pair<double, int>> hits;
    for (const auto& polygon : polygons_) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PixelPoint a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        if ((a.y < y) == (b.y < y)) continue;
        hits.emplace_back(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), a.y < b.y ? 1 : -1);
      }
    }
    std::sort(hits.begin(), hits.end());
    int winding = 0;
    for (std::size_t i = 0; i + 1 < hits.size(); ++i) {
      winding += hits[i].second;
      if (winding != 0) add_stretch(line / kReferenceLines, hits[i].first, hits[i + 1].first, winding);
    }
  }

  void add_stretch(int row, double from, double to, int winding) {
    winds_once_ = winds_once_ && (winding == 1 || from == to);
    from = std::clamp(from, 0.0, static_cast<double>(width_));
    to = std::clamp(to, 0.0, static_cast<double>(width_));
    for (int column = static_cast<int>(from); column < width_ && column < to; ++column) {
      const double part = std::min(to, column + 1.0) - std::max(from, static_cast<double>(column));
      const auto pixel = static_cast<std::size_t>(row * width_ + column);
      covered_[pixel] += part / kReferenceLines;
      mean_winding_[pixel] += winding * part / kReferenceLines;
    }
  }

  int width_, height_;
  std::vector<double> covered_, mean_winding_;
  bool winds_once_ = true;
  std::vector<std::vector<PixelPoint>> polygons_;
};

}  // namespace contourd::testing
