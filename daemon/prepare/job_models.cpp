#include "daemon/prepare/job_models.hpp"

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/model/placement.hpp"
#include "daemon/placement/model_turn.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/prepare/model_orientation.hpp"

namespace contourd {
namespace {

// Settings for making a job's models, and the request to stop.
struct MakingContext {
  const JobSettings& settings;
  const BuildVolume& volume;
  const std::stop_token& stop;
};

OrientationLimits orientation_limits(const MakingContext& making) {
  const ResinProfile& resin = making.settings.resin;
  const BuildVolume& volume = making.volume;
  OrientationLimits limits{
      {Millimeters{volume.width_mm()}, Millimeters{volume.depth_mm()}, Millimeters{volume.height_mm}},
      resin.shrinkage_factors,
      resin.orientation,
      resin.supports};
  if (!adds_supports(making.settings.supports)) limits.supports.lift = Millimeters{};
  limits.keep_own_supports = making.settings.supports != SupportPolicy::On;
  return limits;
}

// Chooses the model's orientation if its ticket leaves that to contourd, and sets it in the ticket.
void find_up(JobContent& content, std::span<const Facet> facets, ModelTicket& ticket,
             const MakingContext& making, ModelSummary& figures) {
  if (!ticket.orientation || facets.empty()) return;
  if (figures.carries_supports) {
    // The supports hold the model as it is drawn.
    ticket.orientation.reset();
    return;
  }
  // Orienting takes no more memory than repairing, and a sweep for supports.
  content.require_room_to_repair(facets);
  figures.orientation = find_orientation(facets, ticket, orientation_limits(making), making.stop);
  if (figures.orientation) ticket.up = figures.orientation->choice.chosen().up;
}

// Converts the facets of a file, of which `unit` is known, to millimetres.
void convert(std::span<Facet> facets, const NamedModel& model, const ModelUnit& unit, JobSummary& summary) {
  if (const std::string conflict = unit_conflict(unit); !conflict.empty())
    summary.warnings.push_back(prefix_of(model, summary) + conflict);
  const LengthUnit read_in =
      unit.is_applied ? LengthUnit::Millimeter : unit.asked.value_or(LengthUnit::Millimeter);
  const double factor = millimeters_in(read_in);
  const std::string warning = precision_warning(bounds_of(facets), factor);
  if (!warning.empty()) summary.warnings.push_back(prefix_of(model, summary) + warning);
  enlarge(facets, Scale{factor});
  refuse_infinite(bounds_of(facets), model.name);
}

// Adds a warning if the model's size shows that its file is in another unit.
void doubt_unit(const ModelSummary& figures, const NamedModel& model, const MakingContext& making,
                const ModelUnit& unit, JobSummary& summary) {
  // The size of a model that is scaled is meant.
  if (model.ticket.fit || model.ticket.scale) return;
  const std::string hint =
      unit_hint({figures.size_x_mm, figures.size_y_mm, figures.size_z_mm}, unit, making.volume.size_mm());
  if (hint.empty()) return;
  summary.warnings.push_back(prefix_of(model, summary) + hint);
  if (summary.unit_hint.empty()) summary.unit_hint = summary.warnings.back();
  // A ticket's unit is the answer, if it has an effect.
  if ((unit.is_applied || !model.ticket.unit) && summary.unit_question.empty())
    summary.unit_question = summary.warnings.back();
}

// Takes the model's facets from `content`, turns and scales them, and sets `made` to their height index.
ModelSummary make_model(JobContent& content, std::size_t number, const MakingContext& making,
                        JobSummary& summary, std::shared_ptr<const HeightIndex>& made) {
  const auto& [given, name, path, file, made_as] = content.models()[number];
  ModelTicket ticket = given;
  ModelSummary figures;
  figures.file = path;
  figures.format = content.format(file);
  figures.mesh.watertight = summary.sliced;
  figures.rotation_deg = ticket.rotation;
  const SupportPolicy policy = making.settings.supports;
  figures.carries_supports =
      policy == SupportPolicy::InFile || (content.is_supported(file) && policy != SupportPolicy::On);
  if (figures.carries_supports && ticket.orientation)
    summary.warnings.push_back(name + " is not turned: the supports in its file hold it as it is drawn");
  std::vector<Facet> facets = content.take_facets(number);
  const ModelUnit unit{ticket.unit, content.unit(file), applies_unit(figures.format)};
  convert(facets, content.models()[number], unit, summary);
  if (content.y_is_up(file) && !ticket.up && !ticket.orientation) {
    constexpr Direction kY{0, 1, 0};
    if (ticket.rotation == RotationDegrees{})
      ticket.up = kY;
    else
      orient(facets, {.up = kY});  // the ticket turns the model that stands
  }
  find_up(content, facets, ticket, making, figures);
  figures.up = ticket.up;
  figures.scale = turn_to_size(facets, ticket, making.volume, making.settings);
  const Bounds bounds = bounds_of(facets);
  figures.size_x_mm = bounds.size_x();
  figures.size_y_mm = bounds.size_y();
  figures.size_z_mm = bounds.size_z();
  doubt_unit(figures, content.models()[number], making, unit, summary);
  refuse_size(bounds, name, making.volume);
  content.require_room_to_repair(facets);
  made = std::make_shared<const HeightIndex>(std::move(facets));
  return figures;
}

}  // namespace

std::vector<ModelToPlace> make_models(JobContent& content, const JobSettings& settings,
                                      const BuildVolume& volume, JobSummary& summary,
                                      const std::stop_token& stop) {
  const MakingContext making{settings, volume, stop};
  std::vector<ModelToPlace> models;
  for (std::size_t i = 0; i < content.models().size() && !stop.stop_requested(); ++i) {
    const auto& [ticket, name, path, file, made_as] = content.models()[i];
    // A single model without a position stands in the middle.
    const std::optional<PlateOffset> position =
        summary.plate ? ticket.position : ticket.position.value_or(PlateOffset{});
    models.push_back({name, nullptr, position, ticket.copies});
    models.back().pictures = content.finished_layers().pictures;
    models.back().outlines = content.finished_layers().outlines;
    if (made_as == i) {
      summary.models.push_back(make_model(content, i, making, summary, models[i].model));
    } else {
      models[i].model = models[made_as].model;
      summary.models.push_back(ModelSummary(summary.models[made_as]));
    }
  }
  return models;
}

}  // namespace contourd
