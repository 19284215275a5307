// Whether a print's masks keep their budget (mask_budget_ms), known from a few of them before it begins, and
// what is said of one that does not. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "hw/clock.hpp"

namespace contourd {

// What the engine's last mask has taken: "1003 ms, 345678 steps, 2345 facets cut".
[[nodiscard]] std::string describe_mask_cost(const ContourEngine& engine, const MaskBudget& spent,
                                             Duration time);

// The layers of a sample, by their number: of each of so many equal parts of the print the one that cuts the
// most facets.
inline constexpr std::size_t kSampledLayers = 12;
[[nodiscard]] std::vector<std::size_t> layers_to_sample(std::span<const PlateModel> models,
                                                        std::span<const Nanometers> middles);

// Computes the masks of such a sample. Throws JobRefused with the figures when one takes longer than the
// budget by this thread's processor time: it may have to give way to others. Each is given up after so many
// budgets by the clock; if the thread had less of the processor than one of them, the mask is tried again
// with four times as many, up to the most.
inline constexpr int kSampledBudgets = 4;
inline constexpr int kMostSampledBudgets = 256;
void refuse_costly_masks(ContourEngine& engine, std::span<const Nanometers> thicknesses, Duration budget);

}  // namespace contourd
