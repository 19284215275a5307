#include "daemon/prepare/model_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/contour/crack_survey.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr std::string_view kRepairIt = "fix the model, or print it with \"cracks\": \"repair\" in its ticket";

bool has_bright_pixel(const Mask& mask, std::uint8_t least_grey) {
  for (std::int32_t row = 0; row < mask.height().count(); ++row)
    if (std::ranges::max(mask.row(row)) >= least_grey) return true;
  return false;
}

// True if the model lights a pixel, see refuse_dark(), or if that is not known.
bool lights_a_pixel(const PlateModel& model, const LightSearch& search, const std::stop_token& stop) {
  PlateModel alone = model;
  alone.copies.resize(1, model.copies.front());
  ContourEngine engine(std::vector{std::move(alone)}, search.settings);
  const std::uint8_t least_grey = std::max(search.least_grey, engine.threshold());
  return std::ranges::any_of(search.heights, [&](Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + search.mask_budget);
    return stop.stop_requested() || engine.mask_within(height, budget) == nullptr ||
           has_bright_pixel(engine.coverage(), least_grey);
  });
}

// Adds the mesh's figures and warnings.
void inspect(const PlateModel& model, const std::string& prefix, ModelSummary& figures,
             std::vector<std::string>& warnings) {
  figures.repairs = model.model->repairs();
  for (const std::string& warning : mesh_warnings(model.model->turned_outwards(), figures.repairs))
    warnings.push_back(prefix + warning);
  figures.mesh = inspect_mesh(model.model->facets());
  const MeshReport& mesh = figures.mesh;
  if (!mesh.watertight) {
    warnings.push_back(
        prefix +
        fmt::format("the model is not watertight ({} open edges, {} turned against each other, {} of more "
                    "than two facets): gaps are closed where they show",
                    mesh.open_edges, mesh.flipped_edges, mesh.non_manifold_edges));
  }
}

}  // namespace

void refuse_size(const Bounds& bounds, const std::string& name, const BuildVolume& volume) {
  if (!std::isfinite(bounds.size_x() + bounds.size_y() + bounds.size_z()))
    throw JobRefused(name + " is too large: its coordinates leave the range of numbers");
  if (!(bounds.size_z() > 0)) throw JobRefused(name + " is flat: it has no height to print");
  // A thousandth of a millimetre: the rounding of float coordinates.
  if (bounds.size_z() > volume.height_mm + 1e-3) {
    throw JobRefused(
        fmt::format("{} is {:.2f} mm high, the machine can print {:.2f} mm (its travel less the lift)", name,
                    bounds.size_z(), volume.height_mm));
  }
}

void refuse_dark(const PlateModel& model, const std::string& name, const LightSearch& search,
                 const std::stop_token& stop) {
  if (lights_a_pixel(model, search, stop)) return;
  const Bounds& bounds = model.model->bounds();
  throw JobRefused(fmt::format(
      "nothing of {} would be printed: in {}, no pixel of {:g} mm reaches grey {} of 255; it measures "
      "{:.3g} x {:.3g} x {:.3g} mm{}",
      name, count_of(search.heights.size(), "layer", "layers"),
      to_millimeters(search.settings.display.pixel_pitch).count(),
      std::max(search.least_grey, search.settings.tone.threshold), bounds.size_x(), bounds.size_y(),
      bounds.size_z(), model.holes ? " less its drain holes" : ""));
}

void refuse_cracks(const ModelToPlace& model, const PrintLayers& layers, const BuildVolume& volume) {
  if (const MeshRepairs& repairs = model.model->repairs(); repairs.has_guesses()) {
    throw JobRefused(fmt::format("{} is cracked: its facets disagree with each other (repair: {}); {}",
                                 model.name, describe(repairs), kRepairIt));
  }
  const std::vector<Nanometers> heights = middles_of(layers.all());
  const CrackSurvey survey =
      survey_cracks(model.standing(), heights, to_millimeters(volume.display.pixel_pitch));
  if (!survey.first_open) return;
  const char* const fault = survey.cracks.turned_chains == 0 ? "contours do not close"
                            : survey.cracks.open_chains == 0 ? "facets are turned against each other"
                                                             : "contours do not close, or facets are turned,";
  throw JobRefused(
      fmt::format("{} is cracked: {} in {} of {} layers, first in layer {} at {:.3f} mm, "
                  "and the widest gap is {:.3f} mm; {}",
                  model.name, fault, survey.open_layers, heights.size(), *survey.first_open + 1,
                  to_millimeters(heights[static_cast<std::size_t>(*survey.first_open)]).count(),
                  survey.cracks.widest_gap.count(), kRepairIt));
}

void inspect_models(const JobContent& content, std::span<const PlateModel> models, JobSummary& summary) {
  for (std::size_t i = 0; i < content.models().size(); ++i) {
    const auto& [ticket, name, file, made_as] = content.models()[i];
    if (made_as != i) {
      summary.models[i].mesh = summary.models[made_as].mesh;
      summary.models[i].repairs = summary.models[made_as].repairs;
      continue;
    }
    const std::string prefix = summary.plate ? name + ": " : "";
    if (content.is_first_of_file(i)) {
      for (const std::string& warning : content.warnings(file))
        summary.warnings.push_back(prefix + warning);
    }
    inspect(models[i], prefix, summary.models[i], summary.warnings);
  }
}

}  // namespace contourd
