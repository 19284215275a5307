#include "core/analysis/print_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/mask/exposure_correction.hpp"

namespace contourd {
namespace {

// The area of a dot of an eighth of a millimetre; at least one pixel.
constexpr double kSpeckMm2 = 0.0125;

// Keeps the kMaxVoids voids with the largest figure, as a heap whose front is the smallest of them.
void keep(const PrintVoid& found, double PrintVoid::*figure, std::vector<PrintVoid>& largest) {
  const auto larger = [figure](const PrintVoid& a, const PrintVoid& b) { return a.*figure > b.*figure; };
  if (largest.size() == PrintFindings::kMaxVoids) {
    if (!larger(found, largest.front())) return;
    std::ranges::pop_heap(largest, larger);
    largest.pop_back();
  }
  largest.push_back(found);
  std::ranges::push_heap(largest, larger);
}

void sort_from_the_bottom(std::vector<PrintVoid>& voids) {
  std::ranges::sort(voids, {}, [](const PrintVoid& each) {
    return std::tuple(each.first_layer, each.widest_layer, each.pixel.y, each.pixel.x);
  });
}

}  // namespace

PrintAnalysis::PrintAnalysis(const DisplayGeometry& display, const CarryingSupport& support,
                             const VoidLimits& limits)
    : display_(display), support_(support), limits_(limits) {
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  pixel_area_mm2_ = pitch_mm * pitch_mm;
}

void PrintAnalysis::add_layer(const Mask& mask, const Layer& layer) {
  expects(mask.width() == display_.width && mask.height() == display_.height,
          "the mask has the display's size");
  std::swap(bright_, beneath_);
  lit_.extract(mask);
  bright_.extract_bright(mask, lit_, support_.least_grey);
  note_area(static_cast<double>(lit_.grey_sum()) / 255.0 * pixel_area_mm2_, layer);
  if (beneath_.rows() > 0) note_islands();  // the first layer stands on the plate, as far as is known
  beneath_layer_ = findings_.layers() - 1;
  note_voids(void_finder_.add_layer(bright_, {findings_.layers() - 1, layer.thickness}));
  if (layer.cracks != LayerCracks{}) {
    findings_.cracks += layer.cracks;
    findings_.cracked_layers.push_back({findings_.layers() - 1, layer.cracks});
  }
  findings_.layer_time += layer.duration;
}

// Islands above an abandoned layer are found against the layer beneath it, on which they may well continue;
// voids continue through it.
void PrintAnalysis::add_abandoned_layer(const Layer& layer) {
  findings_.abandoned_layers.push_back(findings_.layers());
  findings_.area_mm2.push_back(0);
  dark_since_ = findings_.layers();
  findings_.layer_time += layer.duration;
}

void PrintAnalysis::note_area(double area_mm2, const Layer& layer) {
  const std::int32_t number = findings_.layers();
  findings_.area_mm2.push_back(area_mm2);
  findings_.volume_mm3 += area_mm2 * to_millimeters(layer.thickness).count();
  if (area_mm2 > findings_.largest_area_mm2) {
    findings_.largest_area_mm2 = area_mm2;
    findings_.largest_area_layer = number;
  }
  const bool dark = area_mm2 == 0;
  // The first dark layer on a lit one is not counted until another layer follows: it may hold a
  // tip that is too small for a pixel.
  if (dark && number > 0 && findings_.area_mm2[static_cast<std::size_t>(number) - 1] > 0) return;
  for (; dark_since_ < number + (dark ? 1 : 0); ++dark_since_)
    findings_.empty_layers.push_back(dark_since_);
  dark_since_ = number + 1;
}

void PrintAnalysis::note_islands() {
  const auto contact = static_cast<std::int64_t>(std::ceil(support_.contact_area_mm2 / pixel_area_mm2_));
  // Slightly increased because the square of the pitch is rounded.
  const double speck_grey = 255 * std::max(kSpeckMm2 / pixel_area_mm2_, 1.0) + 1e-3;
  const IslandFinder::Islands found = finder_.find(
      bright_, beneath_, {std::max<std::int64_t>(contact, 1), static_cast<std::uint64_t>(speck_grey)});
  const std::int32_t layer = findings_.layers() - 1;
  for (const MaskIsland& island : found.beneath)
    note_island(island, beneath_layer_);
  for (const MaskIsland& island : found.here)
    note_island(island, layer);
}

void PrintAnalysis::note_island(const MaskIsland& island, std::int32_t layer) {
  ++findings_.island_count;
  if (findings_.islands.size() == PrintFindings::kMaxIslands) return;
  findings_.islands.push_back({layer, island.center, on_plate(display_, island.center),
                               static_cast<double>(island.grey) / 255.0 * pixel_area_mm2_});
}

void PrintAnalysis::note_voids(std::span<const MaskVoid> ended) {
  const double volume_unit_mm3 = pixel_area_mm2_ / 1e6;  // volume of one pixel, one nanometre thick
  for (const MaskVoid& each : ended) {
    const PrintVoid found{each.first_layer,
                          each.last_layer,
                          each.widest_layer,
                          each.center,
                          on_plate(display_, each.center),
                          static_cast<double>(each.widest_pixels) * pixel_area_mm2_,
                          static_cast<double>(each.volume) * volume_unit_mm3,
                          each.on_plate};
    if (found.area_mm2 >= limits_.cup_area_mm2 && found.volume_mm3 >= limits_.cup_volume_mm3) {
      ++findings_.suction_cup_count;
      keep(found, &PrintVoid::area_mm2, findings_.suction_cups);
    }
    if (each.closed && !each.on_plate && found.volume_mm3 >= limits_.trap_volume_mm3) {
      ++findings_.resin_trap_count;
      keep(found, &PrintVoid::volume_mm3, findings_.resin_traps);
    }
  }
}

void PrintAnalysis::end() {
  note_voids(void_finder_.end());
  sort_from_the_bottom(findings_.suction_cups);
  sort_from_the_bottom(findings_.resin_traps);
}

std::optional<PrintFindings> analyze_print(
    ContourEngine& engine, const DisplayGeometry& display, std::span<const Nanometers> thicknesses,
    const std::function<std::chrono::nanoseconds(std::int32_t layer)>& layer_duration,
    const std::stop_token& stop, const AnalysisOptions& options) {
  PrintAnalysis analysis(display, options.support, options.void_limits);
  const ExposureCorrection threshold({.threshold = engine.threshold()}, std::nullopt);
  std::optional<Mask> kept;
  if (!threshold.is_none()) kept.emplace(display.width, display.height);
  Nanometers bottom{};
  for (std::int32_t layer = 0; const Nanometers thickness : thicknesses) {
    if (stop.stop_requested()) return std::nullopt;
    MaskBudget budget;
    if (options.mask_budget) budget = MaskBudget(MaskBudget::Clock::now() + *options.mask_budget);
    const PrintAnalysis::Layer figures{thickness, layer_duration(layer), {}};
    if (engine.mask_within(bottom + thickness / 2, budget) == nullptr) {
      analysis.add_abandoned_layer(figures);
    } else {
      if (kept) threshold.apply(engine.coverage(), *kept);
      analysis.add_layer(kept ? *kept : engine.coverage(), {thickness, figures.duration, engine.cracks()});
    }
    bottom += thickness;
    ++layer;
  }
  analysis.end();
  return analysis.findings();
}

}  // namespace contourd
