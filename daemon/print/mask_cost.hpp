// Checks on a sample of a print's masks, before the print begins, that they keep their budget
// (mask_budget_ms), and describes the cost of a mask. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Describes the cost of the engine's last mask: "1003 ms, 345678 steps, 2345 facets cut".
[[nodiscard]] std::string describe_mask_cost(const ContourEngine& engine, const MaskBudget& spent,
                                             Duration time);

// The largest number of layers in a sample.
inline constexpr std::size_t kSampledLayers = 12;
// Returns a sample of the print's layers, as indices into `middles`, the rising heights of the layers'
// middles: the print is divided into kSampledLayers equal parts, and each contributes the layer that cuts the
// most facets.
[[nodiscard]] std::vector<std::size_t> layers_to_sample(std::span<const PlateModel> models,
                                                        std::span<const Nanometers> middles);

// A sampled mask is abandoned after kSampledBudgets budgets of real time. If the thread had the processor for
// less than one budget by then, the mask is computed again with four times the limit, up to
// kMostSampledBudgets.
inline constexpr int kSampledBudgets = 4;
inline constexpr int kMostSampledBudgets = 256;
// Computes the masks of a sample. Throws JobRefused, with the figures, if a mask needs more than the budget
// or too many sides. The budget counts this thread's processor time, as other threads may delay it.
void refuse_costly_masks(ContourEngine& engine, std::span<const Nanometers> thicknesses, Duration budget);

}  // namespace contourd
