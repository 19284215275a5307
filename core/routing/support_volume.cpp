#include "core/routing/support_volume.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/engine/contour_engine.hpp"
#include "core/mask/mask_runs.hpp"

namespace contourd {
namespace {

constexpr double kApart_mm = 0.2;

std::int64_t pixels_beside(const PixelRun& run, std::span<const LitLayers::Run> models) {
  std::int64_t pixels = run.end - run.first;
  for (const LitLayers::Run& model : models)
    pixels -= std::max(
        0, std::min<std::int32_t>(run.end, model.end) - std::max<std::int32_t>(run.first, model.first));
  return pixels;
}

}  // namespace

double volume_beside_models_mm3(const std::shared_ptr<const SupportStructure>& structure,
                                const LitLayers& layers, const std::stop_token& stop) {
  const DisplayGeometry grid{Pixels{layers.columns()}, Pixels{layers.rows()},
                             Micrometers{layers.pitch_mm() * 1000}};
  ContourEngine engine({}, {.display = grid, .anti_aliasing = AntiAliasing::Off}, structure);
  MaskRuns lit;
  const std::int32_t stride = std::max(1, static_cast<std::int32_t>(kApart_mm / layers.step_mm() + 1e-9));
  std::int64_t pixels = 0;
  for (std::int32_t first = 0; first < layers.layers() && !stop.stop_requested(); first += stride) {
    const Millimeters middle{(first + stride / 2.0) * layers.step_mm()};
    lit.extract(engine.mask_at(to_nanometers(middle).value()));
    for (const PixelRun& run : lit.runs())
      pixels += pixels_beside(run, layers.runs_in(first + stride / 2, run.row));
  }
  return static_cast<double>(pixels) * layers.pitch_mm() * layers.pitch_mm() * layers.step_mm() * stride;
}

}  // namespace contourd
