#include "daemon/prepare/print_job.hpp"

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
#include "daemon/prepare/dark_models.hpp"
#include "daemon/prepare/drain_holes.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "daemon/prepare/model_turn.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/mask_cost.hpp"
#include "daemon/system/memory_room.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::string_view kRepairIt = "fix the model, or print it with \"cracks\": \"repair\" in its ticket";

EngineSettings engine_settings(const PrinterConfig& printer, const ResinProfile& resin,
                               const BuildVolume& volume) {
  return {volume.display, printer.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off, resin.compensation,
          printer.tone, printer.uniformity};
}

// Returns the height that models with `fit` leave free beneath them, since they may have to stand on
// supports, a whole number of layers high.
double room_for_supports_mm(const JobSettings& settings) {
  if (settings.supports == SupportPolicy::Off) return 0;
  return (settings.resin.supports.lift + to_millimeters(settings.resin.layer_height_max)).count();
}

BuildVolume build_volume(const PrinterConfig& printer, const ResinProfile& resin) {
  // Every layer is peeled off by a lift, the last one too.
  return {{printer.display_width, printer.display_height, printer.pixel_pitch, printer.mirror_x,
           printer.mirror_y},
          to_millimeters(printer.travel - resin.lift).count()};
}

// Returns the scale at which the model fills the display, as in the thesis's equations 3.6 to 3.19, but equal
// in all three directions, since a printed part must keep its shape, and no higher than the machine can
// print.
double scale_to_fit(const Bounds& bounds, const BuildVolume& volume, double beneath_mm) {
  const double pixels_per_mm = PixelMap::fit(volume.display, bounds).pixels_per_mm();
  // If the machine is hardly higher than the supports, the model gets half of its height.
  const double height_mm = std::max(volume.height_mm - beneath_mm, volume.height_mm / 2);
  return std::min(pixels_per_mm * volume.pitch_mm(), height_mm / bounds.size_z());
}

// Turns and scales the facets. Returns the scale without the resin's shrinkage.
Scale turn_to_size(std::vector<Facet>& facets, const ModelTicket& ticket, const BuildVolume& volume,
                   const JobSettings& settings) {
  turn_and_scale(facets, ticket, settings.resin.shrinkage_factors);
  if (!ticket.fit) return ticket.scale.value_or(Scale{});
  const Scale scale{scale_to_fit(bounds_of(facets), volume, room_for_supports_mm(settings))};
  enlarge(facets, scale);
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

// Settings for making a job's models, and the request to stop.
struct MakingContext {
  const JobSettings& settings;
  const BuildVolume& volume;
  const std::stop_token& stop;
};

OrientationLimits orientation_limits(const MakingContext& making) {
  const ResinProfile& resin = making.settings.resin;
  const BuildVolume& volume = making.volume;
  return {{Millimeters{volume.width_mm()}, Millimeters{volume.depth_mm()}, Millimeters{volume.height_mm}},
          resin.shrinkage_factors,
          resin.orientation,
          making.settings.supports == SupportPolicy::Off ? Millimeters{} : resin.supports.lift,
          resin.supports.bridge};
}

// Chooses the model's orientation if its ticket leaves that to contourd, and sets it in the ticket.
void find_up(JobContent& content, std::span<const Facet> facets, ModelTicket& ticket,
             const MakingContext& making, ModelSummary& figures) {
  if (!ticket.orientation || facets.empty()) return;
  content.require_room_to_repair(facets);  // orienting takes no more memory than repairing
  figures.orientation = find_orientation(facets, ticket, orientation_limits(making), making.stop);
  if (figures.orientation) ticket.up = figures.orientation->choice.chosen().up;
}

// Takes the model's facets from `content`, turns and scales them, and sets `made` to their height index.
ModelSummary make_model(JobContent& content, std::size_t number, const MakingContext& making,
                        std::shared_ptr<const HeightIndex>& made) {
  const auto& [given, name, file, made_as] = content.models()[number];
  ModelTicket ticket = given;
  ModelSummary figures;
  figures.file = ticket.file;
  figures.format = content.format(file);
  figures.rotation_deg = ticket.rotation;
  std::vector<Facet> facets = content.take_facets(number);
  find_up(content, facets, ticket, making, figures);
  figures.up = ticket.up;
  figures.scale = turn_to_size(facets, ticket, making.volume, making.settings);
  const Bounds bounds = bounds_of(facets);
  check_size(bounds, name, making.volume);
  figures.size_x_mm = bounds.size_x();
  figures.size_y_mm = bounds.size_y();
  figures.size_z_mm = bounds.size_z();
  content.require_room_to_repair(facets);
  made = std::make_shared<const HeightIndex>(std::move(facets));
  return figures;
}

// Makes the job's models; fewer if a stop was requested.
std::vector<ModelToPlace> make_models(JobContent& content, const MakingContext& making, JobSummary& summary) {
  std::vector<ModelToPlace> models;
  for (std::size_t i = 0; i < content.models().size() && !making.stop.stop_requested(); ++i) {
    const auto& [ticket, name, file, made_as] = content.models()[i];
    // A single model without a position stands in the middle.
    const std::optional<PlateOffset> position =
        summary.plate ? ticket.position : ticket.position.value_or(PlateOffset{});
    models.push_back({name, nullptr, position, ticket.copies});
    if (made_as == i) {
      summary.models.push_back(make_model(content, i, making, models[i].model));
    } else {
      models[i].model = models[made_as].model;
      summary.models.push_back(ModelSummary(summary.models[made_as]));
    }
  }
  return models;
}

// Lifts the models that stand on supports, by whole layers, and sets the print's height. With adaptive
// layers, the layers beneath a lifted model have the maximum thickness.
void lift(std::vector<ModelToPlace>& models, const JobSettings& settings, const BuildVolume& volume,
          JobSummary& summary) {
  const JobTicket& ticket = settings.ticket;
  const ResinProfile& resin = summary.resin;
  if (settings.supports == SupportPolicy::Auto) {
    const Nanometers layer = ticket.adaptive ? ticket.adaptive->thickest.value_or(resin.layer_height_max)
                                             : ticket.layer_height.value_or(resin.layer_height);
    lift_models(models, resin.supports, layer, volume);
  }
  for (const ModelToPlace& model : models)
    summary.height_mm = std::max(summary.height_mm, model.standing().top().count());
}

// Arranges the models and generates their supports; nullopt if a stop was requested.
std::optional<Arrangement> place(const std::vector<ModelToPlace>& models, const JobSettings& settings,
                                 const BuildVolume& volume, const JobContent& content, JobSummary& summary,
                                 const std::stop_token& stop) {
  if (settings.supports == SupportPolicy::Off) {
    Arrangement arrangement = arrange(models, volume);
    check_arrangement(models, arrangement, volume, summary.layers.thinnest);
    return arrangement;
  }
  const auto start = SteadyClock::now();
  const PlateHolding holding(models, volume, summary.resin.supports, content);
  std::optional<HeldPlate> held = holding.hold(summary.layers.thinnest, stop);
  if (!held) return std::nullopt;
  summary.supporting = SteadyClock::now() - start;
  if (const std::string unheld = unheld_sentence(held->supports.unheld); !unheld.empty())
    summary.warnings.push_back(unheld);
  summary.supports = std::move(held->supports);
  return std::move(held->arrangement);
}

// Warns if contours grow beyond the display. Only a warning, so that a part that fills the display is not
// refused for some micrometres.
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

// Drain holes of each model.
using Cylinders = std::vector<std::vector<Frustum>>;

// Gives the models their tickets' drain holes.
Cylinders drill(std::vector<ModelToPlace>& models, const JobContent& content, JobSummary& summary) {
  Cylinders cylinders;
  for (std::size_t i = 0; i < models.size(); ++i) {
    ModelTicket ticket = content.models()[i].ticket;
    ticket.up = summary.models[i].up;
    cylinders.push_back(drain_cylinders(ticket, summary.models[i].scale, summary.resin.shrinkage_factors));
    models[i].holes = holes_of(cylinders[i]);
    summary.models[i].drain_holes = cylinders[i].size();
  }
  return cylinders;
}

void check_holes(const JobContent& content, const Cylinders& cylinders, const PrintPlan& plan,
                 EngineSettings settings) {
  settings.anti_aliasing = AntiAliasing::On;  // so that the smallest cut shows
  const HoleSearch search{std::move(settings), middles_of(plan.expected_layers),
                          MaskBudget::Clock::now() + kLongestHoleSearch};
  for (std::size_t i = 0; i < cylinders.size(); ++i) {
    const NamedModel& model = content.models()[i];
    refuse_holes_beside({plan.engine->models()[i], model.ticket, cylinders[i]}, model.name, search);
  }
}

void refuse_dark_models(const JobContent& content, std::span<const PlateModel> models,
                        const LightSearch& search, const std::stop_token& stop) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (lights_a_pixel(models[i], search, stop)) continue;
    const Bounds& bounds = models[i].model->bounds();
    throw JobRefused(fmt::format(
        "nothing of {} would be printed: in {}, no pixel of {:g} mm reaches grey {} of 255; it measures "
        "{:.3g} x {:.3g} x {:.3g} mm{}",
        content.models()[i].name, count_of(search.heights.size(), "layer", "layers"),
        to_millimeters(search.settings.display.pixel_pitch).count(),
        std::max(search.least_grey, search.settings.tone.threshold), bounds.size_x(), bounds.size_y(),
        bounds.size_z(), models[i].holes ? " less its drain holes" : ""));
  }
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
        "adaptive layers need a resin with a working curve: the exposure times of {} are valid only "
        "for its layer height of {:g} um",
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

// Computes all layers in advance, for the estimates. Throws JobRefused if there are none.
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

// Adds the mesh's figures and warnings.
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
  plan.warm_up = printer.real ? printer.real->warm_up : printer.simulated.projector.warm_up;
  if (printer.real) plan.home_height = printer.real->axis.switch_height;
}

// Throws JobRefused if any layer needs a guess to close its contours. Cuts all layers before the first one is
// exposed, since even a guess in the last layer must not be printed.
void refuse_guesses(const ModelToPlace& model, const PrintLayers& layers, const BuildVolume& volume) {
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

// Inspects each file and each model once, however often the plate contains it.
void inspect_models(const JobContent& content, const ContourEngine& engine, JobSummary& summary) {
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

// Prepares one job: prepare_job() in steps.
class Preparation {
 public:
  Preparation(const JobFiles& files, const JobSettings& settings, const PrinterConfig& printer)
      : files_(files),
        settings_(settings),
        printer_(printer),
        volume_(build_volume(printer, settings.resin)),
        content_(files.model, files.plate, files.links, settings.ticket) {}

  // Returns the prepared job, or nullopt if a stop was requested.
  std::optional<PreparedJob> run(const std::stop_token& stop) {
    take_printer();
    content_.read(volume_.display, memory_room(printer_.memory_limit_bytes));
    summary_.reading = SteadyClock::now() - start_;
    models_ = make_models(content_, {settings_, volume_, stop}, summary_);
    if (stop.stop_requested()) return std::nullopt;
    cylinders_ = drill(models_, content_, summary_);
    lift(models_, settings_, volume_, summary_);
    job_.plan.layers = choose_layers(settings_.ticket, printer_, models_, summary_);
    const std::optional<Arrangement> arrangement =
        place(models_, settings_, volume_, content_, summary_, stop);
    if (!arrangement) return std::nullopt;
    warn_if_grown_beyond(models_, *arrangement, volume_, summary_);
    const auto indexed = SteadyClock::now();
    summary_.indexing = indexed - start_ - summary_.reading - summary_.supporting;
    make_engines(*arrangement);
    summary_.first_mask = job_.first_mask_at - indexed;
    check_layers(stop);
    if (stop.stop_requested()) return std::nullopt;
    for (std::size_t i = 0; i < models_.size(); ++i)
      summary_.models[i].centers = (*arrangement)[i];
    inspect_models(content_, *job_.plan.engine, summary_);
    return std::move(job_);
  }

 private:
  void take_printer() {
    job_.settings = settings_;
    job_.display = volume_.display;
    job_.plan.job = files_.name;
    summary_.plate = files_.plate;
    summary_.resin = settings_.resin;
    summary_.overridden = settings_.overridden;
    summary_.irradiance_mw_cm2 = printer_.irradiance_mw_cm2;
    summary_.tone = printer_.tone;
    summary_.uniformity_mask = printer_.uniformity.has_value();
    // The analysis yields the processor to the print, so its masks take longer.
    constexpr int kSlack = 4;
    job_.analysis = {summary_.resin.support, kSlack * printer_.mask_budget};
    take_settings(printer_, summary_.resin, job_.plan);
  }

  void make_engines(const Arrangement& arrangement) {
    PrintPlan& plan = job_.plan;
    std::vector<PlateModel> standing = stand_on_plate(models_, arrangement, volume_.display);
    content_.require_room_for_masks(standing, summary_.resin.compensation != Compensation{});
    plan.engine = std::make_unique<ContourEngine>(std::move(standing),
                                                  engine_settings(printer_, summary_.resin, volume_),
                                                  summary_.supports ? summary_.supports->structure : nullptr);
    // Computes the first mask to measure the time, and to make the engine allocate its memory before the
    // print.
    const std::optional<Nanometers> first = plan.layers.thickness_at(Nanometers{});
    MaskBudget budget(MaskBudget::Clock::now() + kSampledBudgets * printer_.mask_budget);
    if (first) (void)plan.engine->mask_within(*first / 2, budget);
    job_.first_mask_at = SteadyClock::now();
    job_.analysis_engine = std::make_unique<ContourEngine>(*plan.engine);
  }

  void check_layers(const std::stop_token& stop) {
    const EngineSettings settings = engine_settings(printer_, summary_.resin, volume_);
    count_layers(job_.plan, summary_);
    refuse_costly_masks(*job_.plan.engine, job_.plan.expected_layers, printer_.mask_budget);
    check_holes(content_, cylinders_, job_.plan, settings);
    const std::vector<Nanometers> heights = middles_of(job_.plan.expected_layers);
    refuse_dark_models(content_, job_.plan.engine->models(),
                       {settings, heights, summary_.resin.support.least_grey, printer_.mask_budget}, stop);
    if (settings_.ticket.cracks != CrackPolicy::Refuse) return;
    for (std::size_t i = 0; i < models_.size(); ++i)
      if (content_.models()[i].made_as == i) refuse_guesses(models_[i], job_.plan.layers, volume_);
  }

  const SteadyClock::time_point start_ = SteadyClock::now();
  const JobFiles& files_;
  const JobSettings& settings_;
  const PrinterConfig& printer_;
  BuildVolume volume_;
  JobContent content_;
  PreparedJob job_;
  JobSummary& summary_ = job_.summary;
  std::vector<ModelToPlace> models_;
  Cylinders cylinders_;  // the models' drain holes
};

}  // namespace

PreparedJob prepare_job(const JobFiles& files, const JobSettings& settings, const PrinterConfig& printer) {
  return *prepare_job(files, settings, printer, std::stop_token{});
}

std::optional<PreparedJob> prepare_job(const JobFiles& files, const JobSettings& settings,
                                       const PrinterConfig& printer, const std::stop_token& stop) {
  try {
    return Preparation(files, settings, printer).run(stop);
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
