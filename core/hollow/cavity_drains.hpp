// The holes that open a model's cavities at their lowest points. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/hollow/cavity_bodies.hpp"
#include "core/hollow/cavity_grid.hpp"
#include "core/hollow/solid_columns.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

// True if the axis of one of the holes meets the body.
[[nodiscard]] bool is_opened(const CavityBodies& bodies, std::uint32_t body, const CavityGrid& grid,
                             std::span<const Frustum> holes);

// A hole that opens a body.
struct BasinDrain {
  std::uint32_t body;  // number of the body
  Frustum hole;
};

// Returns for each basin the shortest hole of this diameter that opens it at its lowest point, in the model's
// own millimetres: level, or, unless the model stands on the plate, which would close it, straight down. The
// hole reaches out by half its diameter, so that no skin is left, and a fifth of that below the basin's
// floor, so that the floor drains. A basin has none for instance in a cavity around which another one lies.
// Returns nullopt if `stop` is requested.
[[nodiscard]] std::optional<std::vector<BasinDrain>> find_drains(
    const SolidColumns& solid, const CavityBodies& bodies, std::span<const CavityBasin> basins,
    const CavityGrid& grid, Millimeters diameter, bool stands_on_plate, const std::stop_token& stop);

}  // namespace contourd
