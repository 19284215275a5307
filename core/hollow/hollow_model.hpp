// Hollows a model: finds the cavities that leave walls of a thickness everywhere, and the holes that open
// them. Thread-safe (no shared state). Deterministic: the same model and settings give the same cavities on
// every machine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/engine/section_source.hpp"
#include "core/geometry/units.hpp"
#include "core/hollow/hollow_settings.hpp"
#include "core/model/standing_model.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

struct HollowRequest {
  StandingModel model;
  HollowSettings settings;
  // Holes that are drilled into the model anyway, in its own millimetres.
  std::span<const Frustum> holes;
  // The finest cells: a pixel of the display.
  Millimeters finest;
};

// Limits on the cells of a search, and on the places where solid or a cavity begins or ends in a row of
// cells. A search that would be larger has cells of two, three... pixels.
inline constexpr double kMostCavityCells = 2e8;
inline constexpr std::size_t kMostCavityEnds = std::size_t{1} << 21;

// A cavity is made if it holds at least this much: less saves no resin worth a hole.
inline constexpr double kLeastCavityMm3 = 50;

struct HollowedModel {
  // The cavities and all holes, to be cut out of the model (see PlateModel::holes); without a cavity, the
  // holes of the request; null if there are none either.
  std::shared_ptr<const SectionSource> removed;
  std::size_t cavities = 0;
  double volume_mm3 = 0;       // all cavities together
  Millimeters cell{};          // within which their walls are right
  std::vector<Frustum> holes;  // added for the cavities
  std::size_t closed = 0;      // cavities without a hole
  // The least of the areas of the sections with a cavity, over the largest area of a section above: what the
  // walls carry when a layer is peeled off. Infinite without a cavity.
  double least_carrying = 0;
  std::uint64_t memory = 0;  // bytes that the cavities take
};

// Returns an upper bound of the memory that hollow_model() takes, in bytes.
[[nodiscard]] std::uint64_t memory_to_hollow(const Bounds& model, Millimeters finest);

// Hollows the model. Returns nullopt if `stop` is requested. Blocks: about a second for 100 million cells,
// and for a mask of each slice of cells. REQUIRES: positive lengths, but for a hole of 0; struts thinner than
// their cells. Throws std::range_error if the model is so intricate that it has more ends than
// kMostCavityEnds in cells of a quarter of the wall, or if the wall is thinner or the holes are narrower than
// two of the finest cells.
[[nodiscard]] std::optional<HollowedModel> hollow_model(const HollowRequest& request,
                                                        const std::stop_token& stop = {});

}  // namespace contourd
