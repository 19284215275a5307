// Checks of the models that a job prints: refuses models that are too large or flat, of which nothing would
// be printed, or whose cracks the ticket refuses, and warns about faults of their meshes. Thread-safe (no
// shared state).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>

#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/prepare/plate_arrangement.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Throws JobRefused if a model with these bounds is flat or too high for the machine.
void refuse_size(const Bounds& bounds, const std::string& name, const BuildVolume& volume);

// Heights and limits of a search for a bright pixel.
struct LightSearch {
  EngineSettings settings;
  std::span<const Nanometers> heights;
  std::uint8_t least_grey;  // lowest grey value that cures; the tone threshold of the settings may raise it
  Duration mask_budget;     // for each mask
};
// Throws JobRefused if one copy of the model, alone on the plate, lights no pixel brightly enough at any of
// the heights: it is smaller than a pixel, for instance drawn in metres, or removed completely by its drain
// holes. Does nothing if a mask overruns its budget or `stop` is requested. Blocks, usually for one mask.
void refuse_dark(const PlateModel& model, const std::string& name, const LightSearch& search,
                 const std::stop_token& stop);

// Throws JobRefused if any layer needs a guess to close its contours. Cuts all layers before the first one is
// exposed, since even a guess in the last layer must not be printed.
void refuse_cracks(const ModelToPlace& model, const PrintLayers& layers, const BuildVolume& volume);

// Adds the figures of the meshes and their warnings to the summary. Inspects each file and each model once,
// however often the plate contains it. `models` are those of `content`, in its order.
void inspect_models(const JobContent& content, std::span<const PlateModel> models, JobSummary& summary);

}  // namespace contourd
