// Small pictures of some of a print's layers for its report, from the masks that were shown. Thread-safe (no
// shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/image/thumbnail.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

inline constexpr std::size_t kMaxLayerPictures = 12;
inline constexpr Pixels kLayerPictureSide{300};  // at most

struct ChosenLayer {
  std::size_t record = 0;  // which of the report's layers
  std::string why;         // "first, island"; empty for one that only fills a gap

  bool operator==(const ChosenLayer&) const = default;
};

// Of the layers that were exposed: the first, the largest, the last, those that warnings name and that were
// interrupted, one of each before a second of any; then those in the middle of the widest gaps. The most
// important one first, none twice, kMaxLayerPictures at most.
[[nodiscard]] std::vector<ChosenLayer> choose_layers(const PrintReport& report);

// The part of a display so large in which the masks of these models and of their supports are, with some room
// around it.
[[nodiscard]] PixelBox box_around(std::span<const PlateModel> models, Pixels width, Pixels height,
                                  std::span<const SupportPrimitive> supports = {});
// The supports that the job has.
[[nodiscard]] std::span<const SupportPrimitive> supports_of(const JobSummary& job);
// The display whose masks the engine makes, of which one shows a copy of its first model.
[[nodiscard]] DisplayGeometry display_of(const ContourEngine& engine);

// Computes their masks once more: the same height and engine make the same mask. Those that are not there by
// the deadline are left out. Takes the memory of the engine's mask, which it has already, and the pictures'.
[[nodiscard]] std::vector<LayerPicture> draw_layer_pictures(const PrintReport& report, ContourEngine& engine,
                                                            MaskBudget::Clock::time_point deadline);

}  // namespace contourd
