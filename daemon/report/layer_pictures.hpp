// Small pictures of some layers of a print for its report, from masks that are computed again when the print
// has ended. Also the box around all layers, to which the picture of the part is cropped. Thread-safe (no
// shared state).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/image/thumbnail.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

inline constexpr std::size_t kMaxLayerPictures = 12;
inline constexpr Pixels kLayerPictureSide{300};  // at most

struct ChosenLayer {
  std::size_t record = 0;  // index into the report's layers
  std::string why;         // "first, island"; empty for a layer that only fills a gap

  bool operator==(const ChosenLayer&) const = default;
};

// Chooses at most kMaxLayerPictures of the exposed layers, the most important first: the first, the largest
// and the last layer, layers named by warnings and interrupted layers, one of each kind before the second of
// any kind; then layers in the middle of the widest gaps.
[[nodiscard]] std::vector<ChosenLayer> choose_layers(const PrintReport& report);

// Returns the part of a display of this size that the masks of the models and of their supports cover, with a
// margin around it.
[[nodiscard]] PixelBox box_around(std::span<const PlateModel> models, Pixels width, Pixels height,
                                  std::span<const SupportPrimitive> supports = {});
// Returns the supports of the job.
[[nodiscard]] std::span<const SupportPrimitive> supports_of(const JobSummary& job);
// The makers of a print's masks.
struct PrintedMasks {
  ContourEngine& engine;
  DimmedMasks* undersides = nullptr;  // null: none were dimmed
};

// Draws the chosen layers, in rising order. Computes their masks again: the same height and engine make the
// same mask. Omits layers that are not drawn by the deadline. Takes memory for the pictures only, as the
// engine's mask exists already.
[[nodiscard]] std::vector<LayerPicture> draw_layer_pictures(const PrintReport& report,
                                                            const PrintedMasks& masks,
                                                            MaskBudget::Clock::time_point deadline);

}  // namespace contourd
