#include "core/analysis/print_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/mask/exposure_correction.hpp"

namespace contourd {

PrintAnalysis::PrintAnalysis(const DisplayGeometry& display, const CarryingSupport& support)
    : display_(display), support_(support) {
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  pixel_area_mm2_ = pitch_mm * pitch_mm;
}

void PrintAnalysis::add_layer(const Mask& mask, const Layer& layer) {
  expects(mask.width() == display_.width && mask.height() == display_.height,
          "the mask has the display's size");
  std::swap(layer_, beneath_);
  layer_.lit.extract(mask);
  layer_.bright.extract_bright(mask, layer_.lit, support_.least_grey);
  note_area(static_cast<double>(layer_.lit.grey_sum()) / 255.0 * pixel_area_mm2_, layer);
  if (beneath_.lit.rows() > 0) note_islands();  // else it stands on the plate, as far as is known
  if (layer.cracks != LayerCracks{}) {
    findings_.cracks += layer.cracks;
    findings_.cracked_layers.push_back({findings_.layers() - 1, layer.cracks});
  }
  findings_.layer_time += layer.duration;
}

// What stands on it is told by the layer beneath, which it may well go on from.
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
  // On a lit layer a dark one is put off until there is more above: it may be the rest of the model's height.
  if (dark && number > 0 && findings_.area_mm2[static_cast<std::size_t>(number) - 1] > 0) return;
  for (; dark_since_ < number + (dark ? 1 : 0); ++dark_since_)
    findings_.empty_layers.push_back(dark_since_);
  dark_since_ = number + 1;
}

void PrintAnalysis::note_islands() {
  const auto contact = static_cast<std::int64_t>(std::ceil(support_.contact_area_mm2 / pixel_area_mm2_));
  for (const MaskIsland& island : finder_.find(layer_, beneath_, std::max<std::int64_t>(contact, 1))) {
    ++findings_.island_count;
    if (findings_.islands.size() == PrintFindings::kMaxIslands) continue;
    findings_.islands.push_back({findings_.layers() - 1, island.center, on_plate(display_, island.center),
                                 static_cast<double>(island.grey) / 255.0 * pixel_area_mm2_});
  }
}

std::optional<PrintFindings> analyze_print(
    ContourEngine& engine, const DisplayGeometry& display, std::span<const Nanometers> thicknesses,
    const std::function<std::chrono::nanoseconds(std::int32_t layer)>& layer_duration,
    const std::stop_token& stop, const AnalysisOptions& options) {
  PrintAnalysis analysis(display, options.support);
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
  return analysis.findings();
}

}  // namespace contourd
