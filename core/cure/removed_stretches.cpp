#include "core/cure/removed_stretches.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>

#include "core/mask/conic_rows.hpp"

namespace contourd {
namespace {

// A stretch that is removed.
struct Removed {
  std::uint32_t ray;
  float from, to;
};

// Calls visit(row, first, end) for runs of pixels of the window that the holes remove from all copies at a z
// of the model's; the numbers are those of the display.
template <typename Visit>
void for_removed_runs(const PlateModel& model, const PixelWindow& window, double z_mm, ConvexRows& rows,
                      Contours& section, Visit&& visit) {
  model.holes->section_at(to_nanometers(Millimeters{z_mm}).value_or(Nanometers{}), section);
  for (const PixelMap& copy : model.copies)
    for (const ContourLoop& loop : section.loops)
      rows.visit(section.points_of(loop), copy, [&](std::int32_t row, std::int32_t first, std::int32_t end) {
        if (row >= window.row) visit(row, std::max(first, window.column), end);
      });
}

std::vector<Removed> removed_on_level_lines(const PlateModel& model, const Rays& rays, double lift_mm,
                                            ConvexRows& rows, StopCheck& check) {
  std::vector<Removed> removed;
  Contours section;
  const bool along_rows = rays.axis == RayAxis::X;
  const std::int32_t lines = along_rows ? rays.window.rows : rays.window.columns;
  for (std::size_t i = 0; i < rays.heights_mm.size(); ++i) {
    const auto line = [&](std::int32_t number) {
      return static_cast<std::uint32_t>(static_cast<std::size_t>(number) +
                                        i * static_cast<std::size_t>(lines));
    };
    for_removed_runs(model, rays.window, rays.heights_mm[i] - lift_mm, rows, section,
                     [&](std::int32_t row, std::int32_t first, std::int32_t end) {
                       check.spend(10);
                       if (along_rows && first < end)
                         removed.push_back({line(row - rays.window.row), static_cast<float>(first),
                                            static_cast<float>(end)});
                       for (std::int32_t column = first; !along_rows && column < end; ++column)
                         removed.push_back({line(column - rays.window.column), static_cast<float>(row),
                                            static_cast<float>(row + 1)});
                     });
  }
  return removed;
}

// Samples the holes at heights a pixel apart.
std::vector<Removed> removed_on_vertical_lines(const PlateModel& model, const Rays& rays, double lift_mm,
                                               ConvexRows& rows, StopCheck& check) {
  const double step_mm = 1 / model.copies.front().pixels_per_mm();
  const Bounds& bounds = model.model->bounds();
  const auto steps = static_cast<std::int32_t>(std::ceil(bounds.size_z() / step_mm));
  // The stretch that each line has in hand, as steps.
  struct Open {
    std::int32_t first = 0, end = 0;
  };
  std::vector<Open> open(rays.window.pixels());
  std::vector<Removed> removed;
  const auto close = [&](std::size_t ray) {
    const auto at = [&](std::int32_t step) {
      return static_cast<float>(bounds.min_z + lift_mm + step * step_mm);
    };
    if (open[ray].first < open[ray].end)
      removed.push_back({static_cast<std::uint32_t>(ray), at(open[ray].first), at(open[ray].end)});
  };
  Contours section;
  for (std::int32_t step = 0; step < steps; ++step) {
    for_removed_runs(model, rays.window, bounds.min_z + (step + 0.5) * step_mm, rows, section,
                     [&](std::int32_t row, std::int32_t first, std::int32_t end) {
                       check.spend(static_cast<std::size_t>(std::max(end - first, 1)));
                       const std::size_t start = static_cast<std::size_t>(row - rays.window.row) *
                                                 static_cast<std::size_t>(rays.window.columns);
                       for (std::int32_t column = first; column < end; ++column) {
                         const std::size_t ray =
                             start + static_cast<std::size_t>(column - rays.window.column);
                         if (open[ray].end < step) {
                           close(ray);
                           open[ray].first = step;
                         }
                         open[ray].end = step + 1;
                       }
                     });
  }
  for (std::size_t ray = 0; ray < open.size(); ++ray)
    close(ray);
  return removed;
}

}  // namespace

std::vector<RayStretch> without_holes(std::vector<RayStretch> stretches, const PlateModel& model,
                                      const Rays& rays, float steepness, StopCheck& check) {
  if (!model.holes || model.copies.empty()) return stretches;
  ConvexRows rows(Pixels{rays.window.column + rays.window.columns},
                  Pixels{rays.window.row + rays.window.rows});
  const double lift_mm = model.elevation.lift(model.model->bounds()).count();
  std::vector<Removed> removed = rays.axis == RayAxis::Z
                                     ? removed_on_vertical_lines(model, rays, lift_mm, rows, check)
                                     : removed_on_level_lines(model, rays, lift_mm, rows, check);
  std::ranges::sort(removed, {}, [](const Removed& each) { return std::tie(each.ray, each.from); });
  std::vector<RayStretch> left;
  auto next = removed.cbegin();
  for (RayStretch stretch : stretches) {
    check.spend(10);
    while (next != removed.cend() && next->ray < stretch.ray)
      ++next;
    for (auto each = next; each != removed.cend() && each->ray == stretch.ray && each->from < stretch.to.at;
         ++each) {
      if (each->to <= stretch.from.at) continue;
      if (each->from > stretch.from.at)
        left.push_back({stretch.ray, stretch.from, {stretch.ray, each->from, steepness}});
      stretch.from = {stretch.ray, each->to, -steepness};
    }
    if (stretch.from.at < stretch.to.at) left.push_back(stretch);
  }
  return left;
}

}  // namespace contourd
