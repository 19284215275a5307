// The light that a print really gave, from the record of its layers and of the masks that its rises showed.
// Pure, thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/frames/frame_record.hpp"
#include "daemon/print/print_plan.hpp"

namespace contourd {

// The light of a print's rises, from the masks that they showed.
struct RiseLight {
  std::uint64_t masks = 0;
  Nanometers step{};  // masks within this distance count as one, cut at their mean height
  // Dose of lit resin over the critical dose, at the median and the least of all steps.
  double margin = 0, least_margin = 0;
  Nanometers least_at{};        // height of the plate there
  Micrometers print_through{};  // depth to which light cures resin above a thick part's underside, median
};

struct PrintedLight {
  std::vector<LayerDose> layers;         // from the plate up; a rise's are steps of its masks
  std::vector<Nanometers> mask_heights;  // heights of the cuts, by layer
  struct Source {
    std::size_t record;    // index among the records
    bool is_step = false;  // a step of a rise, of which the record is a slice
  };
  std::vector<Source> sources;    // by layer
  std::optional<RiseLight> rise;  // nullopt: there is none, or its masks are not known
};

// Returns the layer of the print that this one of its light is, or belongs to.
[[nodiscard]] inline std::int32_t layer_of(const PrintedLight& light, std::int32_t number) {
  return static_cast<std::int32_t>(light.sources.at(static_cast<std::size_t>(number)).record);
}

// The masks that a print's rises showed, in the order of time, and what their light does.
struct ShownFrames {
  std::span<const FrameRecord> frames{};  // empty: slices count as layers, with their whole light
  CureSettings cure{};
  std::size_t most_steps = 20'000;  // the limit of memory and time
};

// Returns the light of the recorded layers: at the plate's measured heights, the mean of the bounds on the
// time of the light. Light that was not confirmed off counts with its lower bound. A rise's slices are
// replaced by its masks, joined to steps of at least 4 um, of which there are at most `most_steps`. All light
// of a step is put at its upper end, less so much that resin below gets what the masks gave. nullopt if these
// are not all layers of a print from the first one on, each above the one before.
[[nodiscard]] std::optional<PrintedLight> printed_light(std::span<const LayerRecord> records,
                                                        double irradiance_mw_cm2,
                                                        const ShownFrames& shown = {});

}  // namespace contourd
