#include "daemon/prepare/model_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/analysis/erased_parts.hpp"
#include "core/analysis/unmet_parts.hpp"
#include "core/contour/crack_survey.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Units in which models are drawn, the most frequent first.
constexpr std::array kUsualUnits{LengthUnit::Millimeter, LengthUnit::Meter, LengthUnit::Inch,
                                 LengthUnit::Centimeter, LengthUnit::Micrometer};

// A part that is smaller in all directions is hardly meant.
constexpr double kSmallestPartMm = 2;

// Parts that are drawn in micrometres are larger than this: a smaller one would be drawn up to 5 m large.
constexpr double kSmallestInUmMm = 5;

// Steps of coordinates of at least a tenth of a usual pixel show in the part.
constexpr double kCoarsestStepMm = 0.005;

// A model farther from the origin than this many times its size loses digits by its place, not by its size.
constexpr double kFarInSizes = 4;

bool is_plausible(SizeMm size, SizeMm room) {
  std::ranges::sort(size);
  std::ranges::sort(room);
  return size[2] >= kSmallestPartMm && size[0] <= room[0] && size[1] <= room[1] && size[2] <= room[2];
}

SizeMm times(SizeMm size, double factor) {
  for (double& length : size)
    length *= factor;
  return size;
}

// Returns the size with four significant digits, and without an exponent if it is large.
std::string size_text(const SizeMm& size) {
  const auto text = [](double length) {
    return length < 1000 ? fmt::format("{:.4g}", length) : fmt::format("{:.0f}", length);
  };
  return fmt::format("{} x {} x {} mm", text(size[0]), text(size[1]), text(size[2]));
}

// Returns the hint for a model whose file has this unit, and is likely in the other one.
std::string wrong_in_file(LengthUnit named, LengthUnit likely, const SizeMm& size, double factor) {
  return fmt::format(
      "the model measures {} in the unit that its file names, {}: in {}, it would measure {}; if "
      "that is right, set \"scale\": {:.6g} in its ticket (contourctl submit --scale {:.6g})",
      size_text(size), plural_of(named), plural_of(likely), size_text(times(size, factor)), factor, factor);
}

std::string in_unit(LengthUnit unit, const SizeMm& size) {
  return fmt::format(
      "in {}, the model would measure {}; if that is right, set \"unit\": \"{}\" in its ticket "
      "(contourctl submit --unit {})",
      plural_of(unit), size_text(size), name_of(unit), name_of(unit));
}

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

// Returns the place of a vertex of the model's first copy.
std::string place_of(const Vertex& vertex, const PlateModel& model, const Point& center) {
  const Bounds& bounds = model.model->bounds();
  const Point middle = bounds.center();
  return fmt::format("{} mm from the plate's centre at a height of {} mm",
                     coordinates({vertex.x - middle.x + center.x, vertex.y - middle.y + center.y}),
                     coordinates({vertex.z + model.elevation.lift(bounds).count()}));
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

// Adds the report of the model's shells, and warnings about them. `figures` has the report of its mesh.
void look_at_shells(const PlateModel& model, const std::string& prefix, ModelSummary& figures,
                    std::vector<std::string>& warnings) {
  const bool one_shell = figures.mesh.parts < 2 && figures.mesh.non_manifold_edges == 0;
  if (one_shell) return;
  figures.shells = inspect_shells(model.model->facets());
  const auto place = [&](const Vertex& vertex) { return place_of(vertex, model, figures.centers.front()); };
  for (const std::string& warning : shell_warnings(figures.shells, place))
    warnings.push_back(prefix + warning);
}

}  // namespace

bool applies_unit(std::string_view format) {
  return format == "3mf" || format == "amf";
}

std::string unit_conflict(const ModelUnit& unit) {
  if (!unit.is_applied || !unit.asked || !unit.named || *unit.asked == *unit.named) return "";
  return fmt::format(
      "the unit that was asked for, {}, is ignored, because the file names its own, {}: to enlarge "
      "the model, set \"scale\" in its ticket",
      plural_of(*unit.asked), plural_of(*unit.named));
}

std::string unit_hint(const SizeMm& size, const ModelUnit& unit, const SizeMm& room) {
  const LengthUnit read_in = unit.is_applied && unit.named ? *unit.named : LengthUnit::Millimeter;
  const LengthUnit now = unit.is_applied ? read_in : unit.asked.value_or(read_in);
  const auto size_in = [&](LengthUnit other) {
    return times(size, millimeters_in(other) / millimeters_in(now));
  };
  if (unit.named && !unit.asked && !unit.is_applied) {
    if (*unit.named == now) return "";
    return fmt::format("the model's file names {} as its unit and is read in millimetres: {}",
                       plural_of(*unit.named), in_unit(*unit.named, size_in(*unit.named)));
  }
  if (is_plausible(size, room)) return "";
  const auto is_likely = [&](LengthUnit other) {
    // A huge model is rather too large than drawn in micrometres, unless it is larger than any.
    const bool is_meant =
        other != LengthUnit::Micrometer || std::ranges::max(size_in(other)) >= kSmallestInUmMm;
    return other != now && is_meant && is_plausible(size_in(other), room);
  };
  const auto* const likely = std::ranges::find_if(kUsualUnits, is_likely);
  if (likely == kUsualUnits.end()) return "";
  if (unit.is_applied)
    return wrong_in_file(now, *likely, size, millimeters_in(*likely) / millimeters_in(now));
  return fmt::format("the model measures {} if it is drawn in {}: {}", size_text(size), plural_of(now),
                     in_unit(*likely, size_in(*likely)));
}

std::string precision_warning(const Bounds& coordinates, double millimeters) {
  if (coordinates.empty()) return "";
  const Bounds& b = coordinates;
  const auto farthest =
      static_cast<float>(std::max({std::fabs(b.min_x), std::fabs(b.min_y), std::fabs(b.min_z),
                                   std::fabs(b.max_x), std::fabs(b.max_y), std::fabs(b.max_z)}));
  const double size = std::max({b.size_x(), b.size_y(), b.size_z()});
  const double step_mm = (double{std::nextafter(farthest, HUGE_VALF)} - farthest) * millimeters;
  if (!(step_mm >= kCoarsestStepMm) || farthest < kFarInSizes * size) return "";
  return fmt::format(
      "the model lies {:.0f} m from the origin, where the file's numbers are {:.3g} mm apart: "
      "finer detail is lost; move the model to the origin and export it again",
      farthest * millimeters / 1000, step_mm);
}

void refuse_infinite(const Bounds& bounds, const std::string& name) {
  if (!std::isfinite(bounds.size_x() + bounds.size_y() + bounds.size_z()))
    throw JobRefused(name + " is too large: its coordinates leave the range of numbers");
}

void refuse_size(const Bounds& bounds, const std::string& name, const BuildVolume& volume) {
  refuse_infinite(bounds, name);
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

std::string erased_sentence(const std::vector<PlateModel>& models, const LightSearch& search,
                            const std::stop_token& stop) {
  const ErasedParts erased = find_erased_parts(
      models, {search.settings, search.heights, search.least_grey, search.mask_budget}, stop);
  if (!erased.largest) return "";
  const ErasedPart& part = *erased.largest;
  return fmt::format(
      "the compensation moves outlines by {:.0f} um in layer {} and erases walls and pins thinner than twice "
      "that: "
      "nothing is left at {} mm from the plate's centre ({:.3g} mm²){}; thicken them, or "
      "reduce growth_um or elephant_foot_um",
      search.settings.compensation.offset_at(search.heights[static_cast<std::size_t>(part.layer)]).count(),
      part.layer + 1, coordinates({part.plate_mm.x, part.plate_mm.y}), part.area_mm2,
      erased.count > 1 ? fmt::format(", and {} more", erased.count - 1) : "");
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

std::string wide_gaps_sentence(const ModelToPlace& model, std::span<const Nanometers> heights,
                               Millimeters pixel) {
  // A share of the layers is enough to judge, and bounds the time.
  constexpr std::size_t kMostLayers = 200;
  constexpr int kManyPercent = 10;
  const std::size_t apart = heights.size() / kMostLayers + 1;
  std::vector<Nanometers> some;
  for (std::size_t i = apart / 2; i < heights.size(); i += apart)
    some.push_back(heights[i]);
  const CrackSurvey survey = survey_cracks(model.standing(), some, pixel);
  const std::size_t percent =
      some.empty() ? 0 : 100 * static_cast<std::size_t>(survey.wide_layers) / some.size();
  if (percent < kManyPercent) return "";
  return fmt::format(
      "much of the surface of {} is missing: in {} % of its layers, gaps of up to {:.2f} mm are bridged by a "
      "guess",
      model.name, percent, survey.cracks.widest_gap.count());
}

std::string unmet_parts_warning(const PlateModel& model, const DisplayGeometry& display,
                                std::span<const Nanometers> heights, Duration mask_budget) {
  constexpr double kSmallestPartMm2 = 0.1;
  const std::vector<UnmetPart> parts =
      find_unmet_parts(model, display, heights, kSmallestPartMm2, mask_budget);
  if (parts.empty()) return "";
  const UnmetPart& first = parts.front();
  return fmt::format(
      "parts of the model are thinner than a layer, lie between two layers and are not printed, at {}: the "
      "first "
      "is {:.3g} mm thick, at {} mm from the plate's centre at a height of {:.3f} mm ({:.3g} "
      "mm²); "
      "make them thicker, or print thinner layers",
      count_of(parts.size(), "height", "heights"), first.thickness.count(),
      coordinates({first.plate_mm.x, first.plate_mm.y}), in_mm(first.height), first.area_mm2);
}

std::string prefix_of(const NamedModel& model, const JobSummary& summary) {
  return summary.plate ? model.name + ": " : "";
}

void inspect_models(const JobContent& content, std::span<const PlateModel> models, JobSummary& summary) {
  for (std::size_t i = 0; i < content.models().size(); ++i) {
    const auto& [ticket, name, path, file, made_as] = content.models()[i];
    if (made_as != i) {
      summary.models[i].mesh = summary.models[made_as].mesh;
      summary.models[i].repairs = summary.models[made_as].repairs;
      summary.models[i].shells = summary.models[made_as].shells;
      continue;
    }
    const std::string prefix = prefix_of(content.models()[i], summary);
    if (content.is_first_of_file(i)) {
      for (const std::string& warning : content.warnings(file))
        summary.warnings.push_back(prefix + warning);
    }
    inspect(models[i], prefix, summary.models[i], summary.warnings);
    // The memory that repairs need.
    if (content.has_room_to_repair(models[i].model->facets().size()))
      look_at_shells(models[i], prefix, summary.models[i], summary.warnings);
  }
}

}  // namespace contourd
