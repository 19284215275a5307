// Checks of the models that a job prints: refuses models that are too large or flat, of which nothing would
// be printed, or whose cracks the ticket refuses, and warns about faults of their meshes, units and
// precision. Thread-safe (no shared state).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "hw/clock.hpp"

namespace contourd {

using SizeMm = std::array<double, 3>;

// The unit of a model's coordinates.
struct ModelUnit {
  std::optional<LengthUnit> asked{};  // by the ticket; nullopt: mm
  std::optional<LengthUnit> named{};  // by the file
  bool is_applied = false;            // see applies_unit(): `asked` has no effect
};

// True if files of this format have a unit, which is applied when they are read: 3MF and AMF.
[[nodiscard]] bool applies_unit(std::string_view format);

// Returns a warning that the file's own unit was used instead of the one that was asked for; empty if the
// file has none, or if they are the same.
[[nodiscard]] std::string unit_conflict(const ModelUnit& unit);

// Returns a hint, a clause with the size that the model would have in its likely unit; empty if its own unit
// is plausible. The likely unit is the one that the file names, unless a ticket asks for a unit; for a model
// that is smaller than 2 mm or larger than `room` in any orientation, it is a unit in which the model fits.
[[nodiscard]] std::string unit_hint(const SizeMm& size, const ModelUnit& unit, const SizeMm& room);

// Returns a warning, a sentence, if 32-bit floats near these coordinates, which are multiplied by
// `millimeters` to print them, are so far apart that the part shows it; empty if not.
[[nodiscard]] std::string precision_warning(const Bounds& coordinates, double millimeters);

// Throws JobRefused if coordinates or sizes leave the range of numbers.
void refuse_infinite(const Bounds& bounds, const std::string& name);
// Throws JobRefused if a model with these bounds is infinite, flat or too high for the machine.
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

// Returns a sentence if the compensation erases parts of layers whole, with the largest of them; empty if
// not. Compares at most 200 layers.
[[nodiscard]] std::string erased_sentence(const std::vector<PlateModel>& models, const LightSearch& search,
                                          const std::stop_token& stop = {});

// Throws JobRefused if any layer needs a guess to close its contours. Cuts all layers before the first one is
// exposed, since even a guess in the last layer must not be printed.
void refuse_cracks(const ModelToPlace& model, const PrintLayers& layers, const BuildVolume& volume);

// Returns a sentence if contours of many layers are closed over gaps far wider than a pixel; empty if not.
// Cuts at most 200 of the layers, whose middles are `heights`.
[[nodiscard]] std::string wide_gaps_sentence(const ModelToPlace& model, std::span<const Nanometers> heights,
                                             Millimeters pixel);

// Returns a warning, a sentence, if thin parts of the model lie between two layers' cuts, so that they are
// not printed; empty if not. `heights` are the cuts of all layers. Computes a few masks, each within its
// budget.
[[nodiscard]] std::string unmet_parts_warning(const PlateModel& model, const DisplayGeometry& display,
                                              std::span<const Nanometers> heights, Duration mask_budget);

// Returns the beginning of a warning about a model: its name, or nothing if the job has only one model.
[[nodiscard]] std::string prefix_of(const NamedModel& model, const JobSummary& summary);

// Adds the figures of the meshes and their warnings to the summary. Inspects each file and each model once,
// however often the plate contains it. `models` are those of `content`, in its order.
void inspect_models(const JobContent& content, std::span<const PlateModel> models, JobSummary& summary);

}  // namespace contourd
