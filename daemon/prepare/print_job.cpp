#include "daemon/prepare/print_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numeric>
#include <system_error>
#include <utility>

#include "core/cure/stop_check.hpp"
#include "core/support/support_lift.hpp"
#include "daemon/config/sliced_settings.hpp"
#include "daemon/formats/model_versions.hpp"
#include "daemon/placement/drain_holes.hpp"
#include "daemon/placement/hollow_job_model.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/job_models.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/layer_choice.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/print/mask_ahead.hpp"
#include "daemon/print/mask_cost.hpp"
#include "daemon/print/rise_change.hpp"
#include "daemon/print/rise_forecast.hpp"
#include "daemon/system/memory_room.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using SteadyClock = std::chrono::steady_clock;

BuildVolume build_volume(const PrinterConfig& printer, const ResinProfile& resin) {
  // Every layer is peeled off by a lift, the last one too.
  return {{printer.display_width, printer.display_height, printer.pixel_pitch, printer.mirror_x,
           printer.mirror_y},
          to_millimeters(printer.travel - resin.motion.whole_lift()).count()};
}

void take_settings(const PrinterConfig& printer, const ResinProfile& resin, PrintPlan& plan) {
  plan.exposure = exposure_by(resin, printer.irradiance_mw_cm2);
  const double pitch_mm = to_millimeters(printer.pixel_pitch).count();
  plan.mask_budget = printer.mask_budget;
  plan.pixel_area_mm2 = pitch_mm * pitch_mm;
  plan.motion = resin.motion;
  if (resin.viscosity_mpa_s) plan.pressed = {*resin.viscosity_mpa_s / 1000, printer.stiffness_n_mm};
  plan.plate_shape_mm4 = press_shape_mm4(Millimeters{pitch_mm * printer.display_width.count()},
                                         Millimeters{pitch_mm * printer.display_height.count()});
  plan.travel_speed = printer.travel_speed;
  plan.homing_speed = printer.homing_speed;
  plan.tolerance = resin.tolerance;
  plan.force = printer.force;
  plan.warm_up = printer.real ? printer.real->warm_up : printer.simulated.projector.warm_up;
  if (printer.real) plan.home_height = printer.real->axis.switch_height;
}

void warn_of_rises(JobSummary& summary, std::string warning) {
  if (warning.empty()) return;
  summary.rise_warnings.push_back(warning);
  summary.warnings.push_back(std::move(warning));
}

void forget_rises(PreparedJob& job) {
  JobSummary& summary = job.summary;
  for (const std::string& warning : summary.rise_warnings)
    std::erase(summary.warnings, warning);
  summary.rise_warnings.clear();
  summary.continuous.reset();
  summary.resin.mode = job.settings.resin.mode;
  job.plan.rises.reset();
}

ContinuousSubject continuous_subject(const PreparedJob& job) {
  const std::vector<Nanometers>& layers = job.plan.expected_layers;
  return {job.display, layers.front(), std::accumulate(layers.begin(), layers.end(), Nanometers{})};
}

// True if a support meets the model: a contact lies within the box of one of its copies.
bool has_contact(const ModelToPlace& model, const std::vector<Point>& centers, const Supports& supports) {
  const Bounds& bounds = model.model->bounds();
  return std::ranges::any_of(centers, [&](const Point& center) {
    return std::ranges::any_of(supports.contacts, [&](const SupportContact& contact) {
      return std::abs(contact.place.x - center.x) <= bounds.size_x() / 2 &&
             std::abs(contact.place.y - center.y) <= bounds.size_y() / 2;
    });
  });
}

// Prepares one job: prepare_job() in steps.
class Preparation {
 public:
  Preparation(const JobFiles& files, const JobSettings& settings, const PrinterConfig& printer)
      : files_(files),
        settings_(settings),
        printer_(printer),
        volume_(build_volume(printer, settings.resin)),
        content_(files, settings.ticket, settings.supports == SupportPolicy::On) {
    job_.settings = settings;
    take_finished_layers();
  }

  // Returns the prepared job, or nullopt if a stop was requested.
  std::optional<PreparedJob> run(const std::stop_token& stop) {
    try {
      return prepare(stop);
    } catch (const JobTooLarge&) {
      throw;
    } catch (const JobRefused& refused) {
      std::string sentence = refused.what();
      if (!summary_.unit_hint.empty()) sentence += "; " + summary_.unit_hint;
      if (content_.is_archive_plate())
        sentence += "; \"model\" in the ticket chooses models of the archive (contourctl submit --model)";
      throw JobRefused(sentence);
    }
  }

 private:
  std::optional<PreparedJob> prepare(const std::stop_token& stop) {
    take_printer();
    refuse_continuous();
    content_.read(volume_.display, memory_room(printer_.memory_limit_bytes), stop);
    summary_.reading = SteadyClock::now() - start_;
    models_ = make_models(content_, settings_, volume_, summary_, stop);
    if (stop.stop_requested()) return std::nullopt;
    leave_out_without_room();
    drill();
    lift(stop);
    hollow(stop);
    if (stop.stop_requested()) return std::nullopt;
    job_.plan.layers = choose_layers(settings_.ticket, printer_, models_, summary_);
    count_layers(job_.plan, summary_);
    const std::optional<Arrangement> arrangement = place(stop);
    if (!arrangement) return std::nullopt;
    warn(growth_warning(models_, *arrangement, volume_, summary_.resin.compensation.growth));
    const auto indexed = SteadyClock::now();
    summary_.indexing = indexed - start_ - summary_.reading - summary_.supporting;
    make_engines(*arrangement);
    summary_.first_mask = job_.first_mask_at - indexed;
    check_layers(stop);
    expect_shapes(stop);
    plan_rises(stop);
    if (stop.stop_requested()) return std::nullopt;
    for (std::size_t i = 0; i < models_.size(); ++i)
      summary_.models[i].centers = (*arrangement)[i];
    if (summary_.sliced) return std::move(job_);
    inspect_models(content_, job_.plan.engine->models(), summary_);
    find_wide_gaps();
    find_unmet_parts();
    return std::move(job_);
  }

  // Settles what finished layers cannot have, if the file holds them. Throws JobRefused.
  void take_finished_layers() {
    const SlicedArchive* const sliced = content_.sliced();
    if (sliced == nullptr) {
      if (!settings_.ticket.exposures_of_file) return;
      throw JobRefused(
          "the ticket takes the exposures from the file, and the file is a model, which has none: leave out "
          "exposure_from");
    }
    const SlicedSettings& file = sliced->settings();
    FileLayers layers{.thickness = file.layer_height, .outlines = sliced->has_outlines()};
    if (file.exposures)
      layers.exposures = {file.exposures->normal, file.exposures->first, file.exposures->first_layers,
                          file.exposures->fading};
    const std::string refusal = settle_for_layers(layers, printer_.irradiance_mw_cm2, settings_.ticket,
                                                  settings_.resin, settings_.overridden);
    if (!refusal.empty()) throw JobRefused(refusal);
    settings_.supports = SupportPolicy::Off;
    summary_.sliced = true;
    const Millimeters height =
        to_millimeters(file.layer_height * static_cast<std::int64_t>(sliced->layers()));
    if (height.count() > volume_.height_mm)
      throw JobRefused(
          fmt::format("the file's {} layers are {:.2f} mm high, and the machine can print {:.2f} mm (its "
                      "travel less the lift)",
                      sliced->layers(), height.count(), volume_.height_mm));
    warn(fmt::format(
        "the file holds finished {} of layers, which are printed as they are: without the measured "
        "height, {}, supports, undersides by dose, a continuous rise, and a comparison of the cured "
        "part with a model",
        layers.outlines ? "outlines" : "pictures",
        layers.outlines ? "shrinkage" : "compensation for the resin"));
    if (file.first_layer != file.layer_height)
      warn(fmt::format(
          "the first layer of the file is {:g} um thick, and is printed like the others, which are "
          "{:g} um thick: everything above it is {:g} um too {}",
          in_mm(file.first_layer) * 1000, in_mm(file.layer_height) * 1000,
          std::abs(in_mm(file.first_layer - file.layer_height)) * 1000,
          file.first_layer > file.layer_height ? "low" : "high"));
    if (file.gamma != 1 && !layers.outlines)
      warn(fmt::format(
          "the slicer corrected the pictures by a gamma of {:g}, and this printer's own gamma applies, too: "
          "grey edges get another light than is meant; slice with a gamma correction of 1",
          file.gamma));
    if (!file.display)
      warn(
          "the file does not say for which display its layers are (prusaslicer.ini or, for NanoDLP, "
          "options.json): check that the part is not mirrored, and measure it");
    else if (!file.display->mirrors_known)
      warn(
          "the file does not say whether its pictures are mirrored for their display, so they are shown as "
          "they are: check that the part is not mirrored");
  }

  void take_printer() {
    job_.display = volume_.display;
    job_.plan.job = files_.name;
    job_.plan.dry = summary_.dry = settings_.ticket.dry;
    summary_.confirm = settings_.ticket.confirm;
    summary_.plate = content_.is_plate();
    for (const std::string& note : content_.notes())
      warn(note);
    summary_.resin = settings_.resin;
    summary_.resin.supports.closed_gap = closed_gap(settings_.ticket, settings_.resin);
    summary_.overridden = settings_.overridden;
    summary_.irradiance_mw_cm2 = printer_.irradiance_mw_cm2;
    summary_.tone = tone_for(printer_, summary_.resin);
    summary_.pixel_light = printer_.pixel_light;
    summary_.grey_bits = printer_.grey_bits;
    summary_.uniformity_mask = printer_.uniformity.has_value();
    // The analysis yields the processor to the print, so its masks take longer.
    constexpr int kSlack = 4;
    job_.analysis = {summary_.resin.support, kSlack * printer_.mask_budget};
    take_settings(printer_, summary_.resin, job_.plan);
    warn(unwatched_way_down());
  }

  // Returns a warning if the force line watches no part of the plate's way down between two layers; empty if
  // it does, or if there is none.
  [[nodiscard]] std::string unwatched_way_down() const {
    const Nanometers lift = summary_.resin.motion.whole_lift();
    if (!printer_.force || printer_.force->contact_from < lift) return {};
    return fmt::format(
        "the force line does not watch the plate's way down between two layers: the plate is lifted by {:g} "
        "mm, and a force counts as resistance only from {:g} mm above a layer on "
        "(z_axis/force/contact_from_mm); lift higher, or measure a smaller contact_from_mm",
        in_mm(lift), in_mm(printer_.force->contact_from));
  }

  // Throws JobRefused if the job asks for a continuous print that is not possible whatever the model is.
  void refuse_continuous() const {
    const ResinProfile& resin = settings_.resin;
    if (resin.mode == PrintWay::Layered) return;
    const std::string refusal = continuous_refusal(resin, continuous_machine(printer_));
    if (!refusal.empty()) throw JobRefused(printable(refusal));
    const auto refuse = [](const std::string& what) {
      throw JobRefused("a continuous print cannot have " + what +
                       ", or print in layers (\"mode\": \"layered\")");
    };
    if (settings_.ticket.adaptive) refuse("adaptive layers: leave out adaptive_layers");
    if (resin.undersides == Undersides::Dose) refuse("undersides by dose: set undersides to plain");
    if (printer_.splits_exposures())
      refuse("split exposures, which the printer's grey_bits ask for: use a panel of 8 bits");
  }

  // Plans the rises of a continuous print. A stop leaves them unplanned.
  void plan_rises(const std::stop_token& stop) {
    const ResinProfile& resin = summary_.resin;
    if (resin.mode == PrintWay::Layered || job_.plan.expected_layers.empty()) return;
    StopCheck stopped([&stop] { return stop.stop_requested(); });
    try {
      job_.slabs = std::make_shared<const std::vector<RiseSlab>>(continuous_slabs(
          *job_.plan.engine, continuous_subject(job_), resin, continuous_machine(printer_), stopped));
    } catch (const ComputationStopped&) {
      return;
    }
    plan_rises_of(job_, printer_);
  }

  void warn(const std::string& warning) {
    if (!warning.empty()) summary_.warnings.push_back(warning);
  }

  // Gives the models their tickets' drain holes.
  void drill() {
    for (std::size_t i = 0; i < models_.size(); ++i) {
      ModelTicket ticket = content_.models()[i].ticket;
      ModelSummary& figures = summary_.models[i];
      ticket.up = figures.up;
      cylinders_.push_back(drain_cylinders(ticket, figures.scale, summary_.resin.shrinkage_factors));
      models_[i].holes = holes_of(cylinders_[i]);
      figures.drain_holes = cylinders_[i].size();
    }
  }

  // Lifts the models that stand on supports, by whole layers, and sets the print's height.
  void lift(const std::stop_token& stop) {
    const ResinProfile& resin = summary_.resin;
    if (settings_.supports != SupportPolicy::Off) {
      for (ModelToPlace& model : models_)
        model.own_supports = find_own_supports(model.model, resin.supports, settings_.supports, stop);
      for (std::size_t i = 0; i < models_.size(); ++i)
        if (summary_.models[i].carries_supports) models_[i].own_supports = OwnSupports::Kept;
      lift_models(models_, resin.supports, layer_beneath(settings_.ticket, resin), volume_);
    }
    for (std::size_t i = 0; i < models_.size() && !summary_.sliced; ++i)
      find_tilt(i);
    for (const ModelToPlace& model : models_) {
      warn(own_supports_sentence(model.name, model.own_supports, "contourd"));
      summary_.height_mm = std::max(summary_.height_mm, model.standing().top().count());
    }
  }

  // Hollows the models as their tickets say.
  void hollow(const std::stop_token& stop) {
    for (std::size_t i = 0; i < models_.size() && !stop.stop_requested(); ++i) {
      const NamedModel& model = content_.models()[i];
      // A model that is wider than the plate, and not only by rounding, is refused when it is placed.
      constexpr double kRoundingMm = 1;
      const Bounds& bounds = models_[i].model->bounds();
      if (!model.ticket.hollow || bounds.size_x() > volume_.width_mm() + kRoundingMm ||
          bounds.size_y() > volume_.depth_mm() + kRoundingMm)
        continue;
      const Millimeters pixel = to_millimeters(printer_.pixel_pitch);
      content_.require_room_to_hollow(bounds, pixel);
      const std::optional<HollowedModel> hollowed = hollow_job_model(
          {models_[i], *model.ticket.hollow, cylinders_[i], pixel, summary_.resin.supports}, stop);
      if (!hollowed) return;
      models_[i].holes = hollowed->removed;
      hollowed_bytes_ += hollowed->memory;
      for (const std::string& warning : hollow_warnings(*hollowed, *model.ticket.hollow))
        warn(prefix_of(model, summary_) + warning);
      summary_.models[i].hollow = HollowSummary{*model.ticket.hollow, hollowed->cavities,
                                                hollowed->volume_mm3, hollowed->cell, hollowed->holes};
    }
  }

  // Adds a warning if the model stands on supports or on an edge, although it has a nearly level base.
  void find_tilt(std::size_t number) {
    const auto& [ticket, name, path, file, made_as] = content_.models()[number];
    const ModelToPlace& model = models_[number];
    const Nanometers layer = layer_beneath(settings_.ticket, summary_.resin);
    if (ticket.orientation || made_as != number || model.own_supports == OwnSupports::Kept ||
        !content_.has_room_to_repair(model.model->facets().size()) ||
        support_lift(*model.model, summary_.resin.supports, layer) == Nanometers{})
      return;
    warn(
        tilted_base_sentence(model.name, *model.model, summary_.resin.supports, layer,
                             "\"up\": \"auto\" in its ticket turns it, and \"contourctl orient\" shows how"));
  }

  // Leaves out the models of an archive that have no room on the plate beside the others and their supports.
  void leave_out_without_room() {
    const Millimeters gap =
        adds_supports(settings_.supports) ? gap_for_supports(settings_.resin.supports) : kCopyGap;
    std::vector<std::string> left_out;
    while (content_.is_archive_plate()) {
      try {
        (void)arrange(models_, volume_, gap);
        break;
      } catch (const NoRoomOnPlate& refusal) {
        if (models_.size() == 1) throw;
        left_out.push_back(content_.models()[refusal.model()].path);
        leave_out(refusal.model());
      }
    }
    if (left_out.empty()) return note_plate();
    summary_.left_out = fmt::format(
        "{} of the {} models of the archive have no room on the plate ({:.2f} x {:.2f} mm) beside the others "
        "and are left out: {}; \"model\" in a ticket chooses models or a folder for a plate of their own "
        "(contourctl submit --model)",
        left_out.size(), left_out.size() + models_.size(), volume_.width_mm(), volume_.depth_mm(),
        names_text({left_out.begin(), left_out.end()}));
    warn(summary_.left_out);
  }

  void note_plate() {
    if (!content_.is_archive_plate() || !settings_.ticket.models.front().entries.empty()) return;
    std::vector<std::string_view> paths;
    for (const NamedModel& model : content_.models())
      paths.emplace_back(model.path);
    warn(fmt::format(
        "the {} models of the archive are printed together, as one plate: {}; \"model\" in the ticket "
        "chooses some of them (contourctl submit --model)",
        paths.size(), names_text(paths)));
  }

  void leave_out(std::size_t number) {
    const auto at = static_cast<std::ptrdiff_t>(number);
    content_.leave_out(number);
    models_.erase(models_.begin() + at);
    summary_.models.erase(summary_.models.begin() + at);
  }

  // Arranges the models and generates their supports; nullopt if a stop was requested.
  std::optional<Arrangement> place(const std::stop_token& stop) {
    const Nanometers layer = summary_.layers.thinnest;
    if (settings_.supports == SupportPolicy::Off) {
      Arrangement arrangement = arrange(models_, volume_);
      check_arrangement(models_, arrangement, volume_, layer);
      return arrangement;
    }
    const auto start = SteadyClock::now();
    const PrintedLayers printed{job_.plan.expected_layers, summary_.resin.compensation,
                                printer_.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off,
                                std::max(summary_.resin.support.least_grey, printer_.tone.threshold)};
    std::optional<HeldPlate> held =
        hold_plate({models_, volume_, summary_.resin.supports, content_, printed, layer}, stop);
    if (!held) return std::nullopt;
    summary_.supporting = SteadyClock::now() - start;
    for (const std::string& warning : supports_warnings(held->supports))
      warn(warning);
    summary_.supports = std::move(held->supports);
    doubt_supports(held->arrangement);
    return std::move(held->arrangement);
  }

  // Asks about a model that gets supports although its name says that it carries some in its file.
  void doubt_supports(const Arrangement& arrangement) {
    // Any other policy is the ticket's answer.
    if (settings_.supports != SupportPolicy::Auto) return;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const std::string& path = content_.models()[i].path;
      if (models_[i].own_supports != OwnSupports::None ||
          !says_supported(path.empty() ? files_.name : path) ||
          !has_contact(models_[i], arrangement[i], *summary_.supports))
        continue;
      summary_.supports_question = fmt::format(
          "the name of {} says that it carries supports in its file, but contourd recognises none there and "
          "adds its own: \"supports\": \"in the file\" in the ticket prints the model as it is drawn, and "
          "\"on\" supports it (contourctl submit --supports)",
          models_[i].name);
      return warn(summary_.supports_question);
    }
  }

  void make_engines(const Arrangement& arrangement) {
    PrintPlan& plan = job_.plan;
    std::vector<PlateModel> standing = stand_on_plate(models_, arrangement, volume_.display);
    const EngineSettings settings = engine_settings(printer_, summary_.resin);
    const std::optional<UndersideCure> cure = dimmed_undersides();
    content_.require_room_for_masks(
        standing, summary_.resin.compensation != Compensation{},
        hollowed_bytes_ + (cure ? UndersideDimming::most_memory(settings.display, *cure) : 0) +
            (printer_.splits_exposures() ? SplitExposure::memory(settings.display) : 0) +
            (summary_.resin.mode == PrintWay::Continuous ? MaskAhead::memory(settings.display) : 0));
    if (printer_.splits_exposures())
      plan.split = std::make_unique<SplitExposure>(PanelTone{printer_.grey_bits, summary_.tone.gamma},
                                                   settings.display.width, settings.display.height);
    const auto supports = summary_.supports ? summary_.supports->structure : nullptr;
    plan.engine = std::make_unique<ContourEngine>(std::move(standing), settings, supports);
    // Computes the first mask to measure the time, and to make the engine allocate its memory before the
    // print.
    const std::optional<Nanometers> first = plan.layers.thickness_at(Nanometers{});
    MaskBudget budget(MaskBudget::Clock::now() + kSampledBudgets * printer_.mask_budget);
    if (first) (void)plan.engine->mask_within(*first / 2, budget);
    job_.first_mask_at = SteadyClock::now();
    job_.analysis_engine = std::make_unique<ContourEngine>(*plan.engine);
    if (!cure) return;
    auto undersides = std::make_unique<UndersideDimming>(plan.engine->models(), supports, settings, *cure);
    // Computes the masks ahead now, for the second layer; the first one stands on the plate.
    if (cure->layers.size() > 1) (void)undersides->dimmed(1);
    plan.undersides =
        std::make_unique<DimmedMasks>(std::move(undersides), settings.tone, settings.uniformity);
  }

  // Returns the light by which undersides are to be dimmed; nullopt if they are exposed as all else.
  std::optional<UndersideCure> dimmed_undersides() {
    warn(settle_undersides(summary_.resin));
    const ResinProfile& resin = summary_.resin;
    if (resin.undersides == Undersides::Plain) return std::nullopt;
    return UndersideCure{layer_doses(resin, job_.plan.expected_layers, printer_.irradiance_mw_cm2),
                         *resin.cure, printer_.mask_budget};
  }

  void check_layers(const std::stop_token& stop) {
    refuse_costly_masks(*job_.plan.engine, job_.plan.expected_layers, printer_.mask_budget);
    const std::vector<Nanometers> heights = middles_of(job_.plan.expected_layers);
    check_holes(heights);
    const LightSearch search{engine_settings(printer_, summary_.resin), heights,
                             summary_.resin.support.least_grey, printer_.mask_budget};
    for (std::size_t i = 0; i < models_.size(); ++i)
      refuse_dark(job_.plan.engine->models()[i], models_[i].name, search, stop);
    const std::span<const PlateModel> models = job_.plan.engine->models();
    warn(erased_sentence({models.begin(), models.end()}, search, stop));
    if (settings_.ticket.cracks != CrackPolicy::Refuse) return;
    for (std::size_t i = 0; i < models_.size(); ++i)
      if (content_.models()[i].made_as == i) refuse_cracks(models_[i], job_.plan.layers, volume_);
  }

  // Finds how much resin layers press out, for the time left, from some of the layers.
  void expect_shapes(const std::stop_token& stop) {
    PrintPlan& plan = job_.plan;
    if (!plan.pressed) return;
    constexpr std::size_t kSampled = 32;
    const std::vector<Nanometers> heights = middles_of(plan.expected_layers);
    const std::size_t step = (heights.size() + kSampled - 1) / kSampled;
    double shape = 0;
    for (std::size_t layer = 0; layer < heights.size() && !stop.stop_requested(); ++layer) {
      MaskBudget budget(MaskBudget::Clock::now() + printer_.mask_budget);
      const std::size_t middle = std::min(layer + step / 2, heights.size() - 1);
      if (layer % step == 0 && plan.engine->mask_within(heights[middle], budget) != nullptr)
        shape = press_shape_mm4(plan.engine->coverage(), printer_.pixel_pitch);
      plan.expected_shapes.push_back(shape);
    }
  }

  // A ticket that asks for the repair accepts all gaps.
  void find_wide_gaps() {
    if (settings_.ticket.cracks) return;
    const std::vector<Nanometers> heights = middles_of(job_.plan.expected_layers);
    for (std::size_t i = 0; i < models_.size() && summary_.wide_gaps.empty(); ++i) {
      const NamedModel& named = content_.models()[i];
      if (named.made_as != i) continue;
      if (content_.lacks_facets(named.file))
        summary_.wide_gaps = fmt::format(
            "the file of {} has fewer facets than its header says, so a part of it may be missing: copy "
            "or export it again",
            named.name);
      else if (!summary_.models[i].mesh.watertight)
        summary_.wide_gaps = wide_gaps_sentence(models_[i], heights, to_millimeters(printer_.pixel_pitch));
    }
    warn(summary_.wide_gaps);
  }

  void find_unmet_parts() {
    const std::vector<Nanometers> heights = middles_of(job_.plan.expected_layers);
    for (std::size_t i = 0; i < models_.size(); ++i) {
      if (content_.models()[i].made_as != i) continue;
      const std::string warning =
          unmet_parts_warning(job_.plan.engine->models()[i], volume_.display, heights, printer_.mask_budget);
      if (!warning.empty()) warn(prefix_of(content_.models()[i], summary_) + warning);
    }
  }

  void check_holes(const std::vector<Nanometers>& heights) {
    EngineSettings settings = engine_settings(printer_, summary_.resin);
    settings.anti_aliasing = AntiAliasing::On;  // so that the smallest cut shows
    const HoleSearch search{std::move(settings), heights, MaskBudget::Clock::now() + kLongestHoleSearch};
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const NamedModel& model = content_.models()[i];
      refuse_holes_beside({job_.plan.engine->models()[i], model.ticket, cylinders_[i]}, model.name, search);
    }
  }

  const SteadyClock::time_point start_ = SteadyClock::now();
  const JobFiles& files_;
  JobSettings settings_;  // settings for finished layers if the file holds them
  const PrinterConfig& printer_;
  BuildVolume volume_;
  JobContent content_;
  PreparedJob job_;
  JobSummary& summary_ = job_.summary;
  std::vector<ModelToPlace> models_;
  std::vector<std::vector<Frustum>> cylinders_;  // the models' drain holes
  std::uint64_t hollowed_bytes_ = 0;             // memory of the models' cavities
};

}  // namespace

void plan_rises_of(PreparedJob& job, const PrinterConfig& printer) {
  if (!job.slabs) return;
  forget_rises(job);
  JobSummary& summary = job.summary;
  PrintPlan& plan = job.plan;
  const ResinProfile& resin = summary.resin;
  const ContinuousResin& continuous = resin.continuous.value();
  const ContinuousMachine machine = continuous_machine(printer);
  const ContinuousSubject subject = continuous_subject(job);
  const std::string refusal = continuous_refusal(resin, machine);
  std::vector<RisePlan> rises;
  if (refusal.empty()) rises = rises_through(*job.slabs, subject.layer, resin, machine);
  if (rises.empty()) {
    warn_of_rises(summary, refusal.empty()
                               ? why_no_rise(subject, resin)
                               : fmt::format("the print is layered, not continuous: {}", refusal));
    summary.resin.mode = PrintWay::Layered;
    return;
  }
  const RiseBounds bounds = rise_bounds(resin, machine);
  plan.rises = PlannedRises{.each = rises_between(std::move(rises), plan.expected_layers,
                                                  layer_durations(plan, printer), continuous),
                            .mask_step = Nanometers{std::llround(continuous.mask_step.count() * 1000)},
                            .missed = continuous.missed,
                            .slowest = continuous.slowest,
                            .slabs = job.slabs,
                            .bounds = bounds,
                            .gamma = summary.tone.gamma,
                            .settings = planned_settings(bounds)};
  summary.continuous = ContinuousForecast{bounds, ranges_of(plan, layer_durations(plan, printer))};
  warn_of_rises(summary, layered_parts_sentence(*summary.continuous, continuous.layered));
}

std::function<Duration(std::int32_t layer, Nanometers thickness)> exposure_by(const ResinProfile& resin,
                                                                              double irradiance_mw_cm2) {
  return [resin, irradiance_mw_cm2](std::int32_t layer, Nanometers thickness) {
    return exposure_time(resin, thickness, layer, irradiance_mw_cm2);
  };
}

EngineSettings engine_settings(const PrinterConfig& printer, const ResinProfile& resin) {
  ToneCurve tone = tone_for(printer, resin);
  if (printer.splits_exposures()) tone.gamma = 1;  // undone by the pictures of the exposure
  return {build_volume(printer, resin).display, printer.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off,
          resin.compensation, tone, printer.uniformity};
}

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
