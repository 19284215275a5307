#include "core/clearance/lit_layers.hpp"

#include <algorithm>

#include "core/geometry/units.hpp"

namespace contourd {
namespace {

// Distance between examined layers: if layers are thinner, only some of them are examined.
constexpr double kLookedAt_mm = 0.1;

// Returns a lower bound for the whole pixels between a place in a row and the run; a pixel counts from its
// middle.
double gap(const LitLayers::Run& run, double column) {
  return std::max({run.first - column, column - (run.end - 1), 1.0}) - 1;
}

// True if one of a row's runs contains the pixel.
bool is_in(std::span<const LitLayers::Run> runs, double column) {
  const auto reaching =
      std::ranges::find_if(runs, [column](const LitLayers::Run& run) { return run.end > column; });
  return reaching != runs.end() && reaching->first <= column;
}

}  // namespace

void LitLayers::begin(const DisplayGeometry& sweep_display, Nanometers step) {
  columns_ = sweep_display.width.count();
  rows_ = sweep_display.height.count();
  pitch_mm_ = to_millimeters(sweep_display.pixel_pitch).count();
  step_mm_ = to_millimeters(step).count();
  stride_ = std::max(1, static_cast<std::int32_t>(kLookedAt_mm / step_mm_ + 1e-9));
  layers_.clear();
  row_starts_.clear();
  runs_.clear();
}

void LitLayers::layer(Nanometers /*height*/, const MaskRuns& lit) {
  const std::span<const PixelRun> runs = lit.runs();
  Layer layer{0, 0, row_starts_.size()};
  if (!runs.empty()) {
    layer.first_row = runs.front().row;
    layer.end_row = runs.back().row + 1;
  }
  for (std::int32_t row = layer.first_row; row < layer.end_row; ++row) {
    row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
    for (const PixelRun& run : lit.in_row(row))
      runs_.push_back({static_cast<std::uint16_t>(run.first), static_cast<std::uint16_t>(run.end)});
  }
  row_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
  layers_.push_back(layer);
}

std::span<const LitLayers::Run> LitLayers::runs_in(std::int32_t layer, std::int32_t row) const {
  if (layer < 0 || layer >= layers()) return {};
  const Layer& in = layers_[static_cast<std::size_t>(layer)];
  if (row < in.first_row || row >= in.end_row) return {};
  const std::size_t start = in.first_start + static_cast<std::size_t>(row - in.first_row);
  return std::span(runs_).subspan(row_starts_[start], row_starts_[start + 1] - row_starts_[start]);
}

bool LitLayers::is_clear(const PlatePoint& point, double distance_mm) const {
  const double column = point.x / pitch_mm_ + columns_ / 2.0 - 0.5;
  const double row = rows_ / 2.0 - point.y / pitch_mm_ - 0.5;
  const double level = point.z / step_mm_ - 0.5;
  const double up = distance_mm / step_mm_ + stride_;
  const double last = std::min(std::floor(level + up), layers() - 1.0);
  const auto first = static_cast<std::int32_t>(std::max(std::ceil(level - up), 0.0));
  for (std::int32_t layer = first; layer <= last; layer += stride_) {
    const double off = std::max(std::fabs(layer - level) - stride_, 0.0) * step_mm_;
    const double disc = distance_mm * distance_mm - off * off;
    if (disc > 0 && !is_disc_clear(layer, row, column, disc / (pitch_mm_ * pitch_mm_))) return false;
  }
  return true;
}

// `disc` is the squared radius, in squared pixels; row and column count from the first pixel's middle.
bool LitLayers::is_disc_clear(std::int32_t layer, double row, double column, double disc) const {
  const Layer& in = layers_[static_cast<std::size_t>(layer)];
  const double across = std::sqrt(disc) + 1;
  const double last = std::min(std::floor(row + across), in.end_row - 1.0);
  const auto first = static_cast<std::int32_t>(std::max<double>(std::ceil(row - across), in.first_row));
  // Neighbouring rows have similar runs: the ones near the disc have about the same index.
  std::size_t next = 0;
  for (std::int32_t at = first; at <= last; ++at) {
    const std::span<const Run> runs = runs_in(layer, at);
    if (runs.empty()) continue;
    const double aside = std::max(std::fabs(at - row), 1.0) - 1;
    const double left = disc - aside * aside;
    next = std::min(next, runs.size());
    while (next > 0 && runs[next - 1].end > column)
      --next;
    while (next < runs.size() && runs[next].end <= column)
      ++next;
    const auto reaches = [&](const Run& run) { return gap(run, column) * gap(run, column) < left; };
    if (next < runs.size() && reaches(runs[next])) return false;
    if (next > 0 && reaches(runs[next - 1])) return false;
  }
  return true;
}

bool LitLayers::is_pixel_lit(double layer, double row, double column) const {
  if (!(layer >= 0 && layer < layers() && row >= 0 && row < rows_)) return false;
  return is_in(runs_in(static_cast<std::int32_t>(layer), static_cast<std::int32_t>(row)), column);
}

bool LitLayers::is_lit(const PlatePoint& point) const {
  return is_pixel_lit(std::floor(point.z / step_mm_), row_of(point.y), column_of(point.x));
}

int LitLayers::lit_around(const PlatePoint& point, double distance_mm, int most) const {
  const auto reach = static_cast<int>(distance_mm / pitch_mm_ + 1e-9);
  int lit = 0;
  for (int row = -reach; row <= reach; ++row) {
    for (int column = -reach; column <= reach && lit < most; ++column) {
      if (row * row + column * column <= reach * reach &&
          is_lit({point.x + column * pitch_mm_, point.y + row * pitch_mm_, point.z}))
        ++lit;
    }
  }
  return lit;
}

std::optional<std::uint32_t> LitLayers::gap_at(const PlatePoint& point) const {
  const double layer = std::floor(point.z / step_mm_), row = row_of(point.y), column = column_of(point.x);
  if (!(layer >= 0 && layer < layers() && row >= 0 && row < rows_)) return std::nullopt;
  const std::span<const Run> runs = runs_in(static_cast<std::int32_t>(layer), static_cast<std::int32_t>(row));
  const auto next = std::ranges::find_if(runs, [column](const Run& run) { return run.end > column; });
  if (next == runs.begin() || next == runs.end() || next->first <= column) return std::nullopt;
  return number_of(*std::prev(next));
}

std::optional<double> LitLayers::underside_above(const PlatePoint& point, double up_mm) const {
  const double column = column_of(point.x), row = row_of(point.y);
  const auto last =
      static_cast<std::int32_t>(std::min(std::floor((point.z + up_mm) / step_mm_), layers() - 1.0));
  // Material in the first layer lies on the plate and needs no support.
  const auto first =
      static_cast<std::int32_t>(std::clamp<double>(std::ceil(point.z / step_mm_), 1, std::max(layers(), 1)));
  bool dark = !is_pixel_lit(first - 1, row, column);
  for (std::int32_t layer = first; layer <= last; ++layer) {
    const bool lit = is_pixel_lit(layer, row, column);
    if (lit && dark) return layer * step_mm_;
    dark = !lit;
  }
  return std::nullopt;
}

std::optional<double> LitLayers::top_below(const PlatePoint& point, double down_mm) const {
  const double column = column_of(point.x), row = row_of(point.y);
  if (row < 0 || row >= rows_ || point.z < 0) return std::nullopt;
  const auto level =
      static_cast<std::int32_t>(std::min(std::floor(point.z / step_mm_ - 0.5), layers() - 1.0));
  const auto last = static_cast<std::int32_t>(std::max(std::floor((point.z - down_mm) / step_mm_), 0.0));
  for (std::int32_t layer = level; layer >= last; --layer) {
    if (is_in(runs_in(layer, static_cast<std::int32_t>(row)), column)) return (layer + 1) * step_mm_;
  }
  return std::nullopt;
}

}  // namespace contourd
