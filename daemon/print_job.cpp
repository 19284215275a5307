#include "daemon/print_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "core/contour/crack_survey.hpp"
#include "core/model/placement.hpp"
#include "daemon/config/printable.hpp"
#include "daemon/job_content.hpp"
#include "daemon/mask_cost.hpp"
#include "daemon/memory_room.hpp"
#include "daemon/mesh_repair_text.hpp"

namespace contourd {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::string_view kRepairIt =
    "mend the model, or print it with \"cracks\": \"repair\" in its ticket";

EngineSettings engine_settings(const PrinterConfig& printer, const ResinProfile& resin,
                               const BuildVolume& volume) {
  return {volume.display, printer.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off, resin.compensation,
          printer.tone, printer.uniformity};
}

BuildVolume build_volume(const PrinterConfig& printer, const ResinProfile& resin) {
  // Every layer is peeled off by a lift, the last one too.
  return {{printer.display_width, printer.display_height, printer.pixel_pitch, printer.mirror_x,
           printer.mirror_y},
          to_millimeters(printer.travel - resin.lift).count()};
}

// As large as the thesis's equations 3.6 to 3.19 draw it, but in all three directions alike, and no higher
// than the machine: a part that is to be printed must keep its shape.
double scale_to_fit(const Bounds& bounds, const BuildVolume& volume) {
  const double pixels_per_mm = PixelMap::fit(volume.display, bounds).pixels_per_mm();
  return std::min(pixels_per_mm * volume.pitch_mm(), volume.height_mm / bounds.size_z());
}

// Turns and scales the facets; the scale that the owner asked for comes back.
Scale turn_and_scale(std::vector<Facet>& facets, const ModelTicket& ticket, const BuildVolume& volume,
                     const Scale& shrinkage) {
  Orientation turn{ticket.rotation.x, ticket.rotation.y, ticket.rotation.z, shrinkage, ticket.up};
  Scale scale = ticket.scale.value_or(Scale{});
  if (ticket.fit) {
    orient(facets, turn);
    scale = Scale{scale_to_fit(bounds_of(facets), volume)};
    turn = Orientation{};
    turn.scale = scale;
  } else {
    turn.scale = scale * shrinkage;
  }
  orient(facets, turn);
  return scale;
}

void check_size(const Bounds& bounds, const std::string& name, const BuildVolume& volume) {
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

// Takes the facets.
ModelSummary make_model(JobContent& content, std::size_t number, const BuildVolume& volume,
                        const ResinProfile& resin, std::shared_ptr<const HeightIndex>& made) {
  const auto& [ticket, name, file, made_as] = content.models()[number];
  ModelSummary figures;
  figures.file = ticket.file;
  figures.format = content.format(file);
  figures.rotation_deg = ticket.rotation;
  figures.up = ticket.up;
  std::vector<Facet> facets = content.take_facets(number);
  figures.scale = turn_and_scale(facets, ticket, volume, resin.shrinkage_factors);
  const Bounds bounds = bounds_of(facets);
  check_size(bounds, name, volume);
  figures.size_x_mm = bounds.size_x();
  figures.size_y_mm = bounds.size_y();
  figures.size_z_mm = bounds.size_z();
  content.require_room_to_repair(facets);
  made = std::make_shared<const HeightIndex>(std::move(facets));
  return figures;
}

std::vector<ModelToPlace> make_ready(JobContent& content, const JobFiles& files, const BuildVolume& volume,
                                     JobSummary& summary) {
  std::vector<ModelToPlace> models;
  for (std::size_t i = 0; i < content.models().size(); ++i) {
    const auto& [ticket, name, file, made_as] = content.models()[i];
    // A model alone stands in the middle.
    const std::optional<PlateOffset> position =
        files.plate ? ticket.position : ticket.position.value_or(PlateOffset{});
    models.push_back({name, nullptr, position, ticket.copies});
    if (made_as == i) {
      summary.models.push_back(make_model(content, i, volume, summary.resin, models[i].model));
    } else {
      models[i].model = models[made_as].model;
      summary.models.push_back(ModelSummary(summary.models[made_as]));
    }
    summary.height_mm = std::max(summary.height_mm, models[i].standing().top().count());
  }
  return models;
}

// A part that fills the display is not refused for some micrometres that it grows by.
void warn_if_grown_beyond(const std::vector<ModelToPlace>& models, const Arrangement& arrangement,
                          const BuildVolume& volume, JobSummary& summary) {
  const double growth_mm = to_millimeters(summary.resin.compensation.growth).count();
  double beyond = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Bounds& bounds = models[i].model->bounds();
    for (const Point& center : arrangement[i]) {
      const double reach_x = std::fabs(center.x) + bounds.size_x() / 2;
      const double reach_y = std::fabs(center.y) + bounds.size_y() / 2;
      beyond = std::max(
          {beyond, reach_x + growth_mm - volume.width_mm() / 2, reach_y + growth_mm - volume.depth_mm() / 2});
    }
  }
  // A micrometre: the rounding of float coordinates.
  if (growth_mm <= 0 || beyond <= 1e-3) return;
  summary.warnings.push_back(
      fmt::format("the resin's growth_um moves contours {:.0f} um beyond the display, where they are cut off",
                  beyond * 1000));
}

std::vector<PlateModel> stand_on_plate(const std::vector<ModelToPlace>& models,
                                       const Arrangement& arrangement, const BuildVolume& volume) {
  std::vector<PlateModel> standing;
  for (std::size_t i = 0; i < models.size(); ++i) {
    PlateModel& model = standing.emplace_back(PlateModel{models[i].standing(), {}});
    const Point middle = model.model->bounds().center();
    for (const Point& center : arrangement[i]) {
      // The point of the model that comes to lie on the display's centre.
      model.copies.push_back(
          PixelMap::true_scale(volume.display, {middle.x - center.x, middle.y - center.y}));
    }
  }
  return standing;
}

void check_layer_height(Nanometers thickness, const ResinProfile& resin, const PrinterConfig& printer) {
  const auto problems = layer_height_problems(resin, thickness, printer.irradiance_mw_cm2);
  if (problems.empty()) return;
  std::string reasons;
  for (const std::string& problem : problems)
    reasons += (reasons.empty() ? "" : "; ") + problem;
  throw JobRefused(fmt::format("the layer height cannot be printed: {}", reasons));
}

AdaptiveLayers adaptive_limits(const AdaptiveTicket& ticket, const ResinProfile& resin,
                               const PrinterConfig& printer) {
  if (std::holds_alternative<FixedExposure>(resin.exposure)) {
    throw JobRefused(fmt::format(
        "adaptive layers need a resin with a working curve: the exposure times of {} hold for its "
        "layer height of {:g} um only",
        in_quotes(resin.name), to_millimeters(resin.layer_height).count() * 1000));
  }
  const AdaptiveLayers limits{ticket.thinnest.value_or(resin.layer_height_min),
                              ticket.thickest.value_or(resin.layer_height_max), ticket.cusp};
  for (const Nanometers thickness : {limits.thinnest, limits.thickest})
    check_layer_height(thickness, resin, printer);
  if (limits.thinnest > limits.thickest) {
    throw JobRefused(fmt::format(
        "the thinnest adaptive layer, {:g} um, is thicker than the thickest, {:g} um",
        to_millimeters(limits.thinnest).count() * 1000, to_millimeters(limits.thickest).count() * 1000));
  }
  return limits;
}

PrintLayers choose_layers(const JobTicket& ticket, const PrinterConfig& printer,
                          const std::vector<ModelToPlace>& models, JobSummary& summary) {
  const ResinProfile& resin = summary.resin;
  if (ticket.adaptive) {
    summary.layers.adaptive = adaptive_limits(*ticket.adaptive, resin, printer);
    summary.layers.thinnest = summary.layers.adaptive->thinnest;
    std::vector<StandingModel> standing;
    for (const ModelToPlace& model : models)
      standing.push_back(model.standing());
    return {std::move(standing), *summary.layers.adaptive};
  }
  const Nanometers thickness = ticket.layer_height.value_or(resin.layer_height);
  check_layer_height(thickness, resin, printer);
  summary.layers.thinnest = thickness;
  return PrintLayers(layers_for(Millimeters{summary.height_mm}, thickness));
}

// Asks for every layer beforehand, for the estimates. Refuses a print without any.
void count_layers(PrintPlan& plan, JobSummary& summary) {
  plan.expected_layers = plan.layers.all();
  if (plan.expected_layers.empty())
    throw JobRefused(fmt::format("the model is {:.6g} mm high, too thin for a layer", summary.height_mm));
  summary.layers.count = static_cast<std::int32_t>(plan.expected_layers.size());
  const auto [thinnest, thickest] =
      std::minmax_element(plan.expected_layers.begin(), plan.expected_layers.end());
  summary.layers.thinnest = *thinnest;
  summary.layers.thickest = *thickest;
}

void inspect(const PlateModel& model, const std::string& prefix, ModelSummary& figures,
             std::vector<std::string>& warnings) {
  if (model.model->turned_outwards()) warnings.push_back(prefix + std::string(kTurnedOutwardsWarning));
  figures.repairs = model.model->repairs();
  if (figures.repairs != MeshRepairs{}) warnings.push_back(prefix + repair_warning(figures.repairs));
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

Duration warm_up_of(const PrinterConfig& printer) {
  if (!printer.real) return printer.simulated.projector.warm_up;
  // Its table's is at least the configuration's.
  return printer.real->projector ? printer.real->projector->table.warm_up : printer.real->warm_up;
}

void take_settings(const PrinterConfig& printer, const ResinProfile& resin, PrintPlan& plan) {
  plan.exposure = [resin, irradiance = printer.irradiance_mw_cm2](std::int32_t layer, Nanometers thickness) {
    return exposure_time(resin, thickness, layer, irradiance);
  };
  const double pitch_mm = to_millimeters(printer.pixel_pitch).count();
  plan.mask_budget = printer.mask_budget;
  plan.pixel_area_mm2 = pitch_mm * pitch_mm;
  plan.lift = resin.lift;
  plan.lift_speed = resin.lift_speed;
  plan.retract_speed = resin.retract_speed;
  plan.travel_speed = printer.travel_speed;
  plan.homing_speed = printer.homing_speed;
  plan.settle = resin.settle;
  plan.rest = resin.rest;
  plan.tolerance = resin.tolerance;
  plan.warm_up = warm_up_of(printer);
  if (printer.real) plan.home_height = printer.real->axis.switch_height;
}

// Every layer is cut, before any is exposed: a guess is not to be printed, not even in the last one.
void refuse_guesses(const ModelToPlace& model, const PrintLayers& layers, const BuildVolume& volume) {
  if (const MeshRepairs& repairs = model.model->repairs(); repairs.has_guesses()) {
    throw JobRefused(fmt::format("{} is cracked: its facets disagree with each other (to print it: {}); {}",
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

// At each file and each model once, however often it stands on the plate.
void look_at_models(const JobContent& content, const ContourEngine& engine, JobSummary& summary) {
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
    inspect(engine.models()[i], prefix, summary.models[i], summary.warnings);
  }
}

PreparedJob prepare(const JobFiles& files, const JobSettings& settings, const PrinterConfig& printer) {
  const auto start = SteadyClock::now();
  const JobTicket& ticket = settings.ticket;
  PreparedJob job;
  job.settings = settings;
  JobSummary& summary = job.summary;
  summary.plate = files.plate;
  summary.resin = settings.resin;
  summary.overridden = settings.overridden;
  summary.irradiance_mw_cm2 = printer.irradiance_mw_cm2;
  const BuildVolume volume = build_volume(printer, summary.resin);
  JobContent content(files.model, files.plate, files.links, ticket);
  content.read(volume.display, memory_room(printer.memory_limit_bytes));
  const auto read = SteadyClock::now();
  summary.tone = printer.tone;
  summary.uniformity_mask = printer.uniformity.has_value();
  const std::vector<ModelToPlace> models = make_ready(content, files, volume, summary);
  const Arrangement arrangement = arrange(models, volume);
  PrintPlan& plan = job.plan;
  plan.job = files.name;
  plan.layers = choose_layers(ticket, printer, models, summary);
  check_arrangement(models, arrangement, volume, summary.layers.thinnest);
  warn_if_grown_beyond(models, arrangement, volume, summary);
  const auto indexed = SteadyClock::now();
  std::vector<PlateModel> standing = stand_on_plate(models, arrangement, volume);
  content.require_room_for_masks(standing, summary.resin.compensation != Compensation{});
  plan.engine =
      std::make_unique<ContourEngine>(std::move(standing), engine_settings(printer, summary.resin, volume));
  // Computed for its time, and to have the engine's memory grown before the print needs it.
  const std::optional<Nanometers> first = plan.layers.thickness_at(Nanometers{});
  MaskBudget budget(MaskBudget::Clock::now() + kSampledBudgets * printer.mask_budget);
  if (first) (void)plan.engine->mask_within(*first / 2, budget);
  job.first_mask_at = SteadyClock::now();
  job.analysis_engine = std::make_unique<ContourEngine>(*plan.engine);
  job.display = volume.display;
  summary.reading = read - start;
  summary.indexing = indexed - read;
  summary.first_mask = job.first_mask_at - indexed;
  count_layers(plan, summary);
  refuse_costly_masks(*plan.engine, plan.expected_layers, printer.mask_budget);
  if (ticket.cracks == CrackPolicy::Refuse) {
    for (std::size_t i = 0; i < models.size(); ++i)
      if (content.models()[i].made_as == i) refuse_guesses(models[i], plan.layers, volume);
  }
  // It gives way to the print: its masks take longer by the clock.
  constexpr int kSlack = 4;
  job.analysis = {summary.resin.support, kSlack * printer.mask_budget};
  take_settings(printer, summary.resin, plan);
  for (std::size_t i = 0; i < models.size(); ++i)
    summary.models[i].centers = arrangement[i];
  look_at_models(content, *plan.engine, summary);
  return job;
}

}  // namespace

PreparedJob prepare_job(const JobFiles& files, const JobSettings& settings, const PrinterConfig& printer) {
  try {
    return prepare(files, settings, printer);
  } catch (const JobRefused&) {
    throw;
  } catch (const TooManyLayers& error) {
    throw JobRefused(error.what());
  } catch (const std::system_error& error) {
    throw JobRefused(printable(error.what()));
  } catch (const std::range_error& error) {
    throw JobRefused(error.what());
  } catch (const std::bad_alloc&) {
    throw JobRefused("the model does not fit into this machine's memory");
  } catch (const std::exception& error) {
    throw JobRefused(fmt::format("the job cannot be prepared: {}", error.what()));
  }
}

}  // namespace contourd
