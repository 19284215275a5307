// The light that a print really gave, from the record of its layers. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/print/print_plan.hpp"

namespace contourd {

struct PrintedLight {
  std::vector<LayerDose> layers;         // from the plate up
  std::vector<Nanometers> mask_heights;  // of the cuts, by layer
};

// Returns the light of the recorded layers: at the plate's measured heights, the mean of the bounds on the
// time of the light. Light that was not confirmed off counts with its lower bound. nullopt if these are not
// all layers of a print from the first one on, each above the one before.
[[nodiscard]] std::optional<PrintedLight> printed_light(std::span<const LayerRecord> records,
                                                        double irradiance_mw_cm2);

}  // namespace contourd
