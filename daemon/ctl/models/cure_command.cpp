#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr std::chrono::seconds kNoHurry{60};  // for a mask that is computed ahead

struct CureOptions {
  std::filesystem::path model;
  bool json = false;
  SizeArgs size;
  std::optional<std::string> supports;    // default: as configured; without a configuration none
  std::optional<std::string> undersides;  // default: as the resin's profile says

  // Configuration and ticket of a print by contourd.
  std::optional<std::filesystem::path> printer, ticket;
  // Without a configuration: the resin, the direction that points up, and the display.
  std::optional<std::filesystem::path> resin;
  std::optional<std::string> up;
  DisplayArgs display;
  std::optional<double> layer_height_um;  // default: the resin's
};

using Json = nlohmann::ordered_json;

// A print to be cured.
struct CureSubject {
  std::unique_ptr<ContourEngine> engine;
  EngineSettings settings;
  std::string resin;  // name of the profile
  Undersides undersides = Undersides::Plain;
  CureSettings cure;
  bool memory_is_measured = false;
  std::vector<LayerDose> layers;
  std::optional<Supports> supports;
  std::optional<Duration> mask_budget;
  std::vector<std::string> warnings;
};

CureSettings cure_of(const ResinProfile& resin) {
  if (resin.cure) return *resin.cure;
  throw ModelError(fmt::format(
      "the resin {} has no working_curve, so the part that its light cures is not known; measure the "
      "penetration depth and the critical energy, or take them from the resin's data sheet, and add them to "
      "its profile",
      printable(resin.name)));
}

void take_resin(const ResinProfile& resin, const CureOptions& options, CureSubject& subject) {
  subject.resin = resin.name;
  subject.cure = cure_of(resin);
  subject.memory_is_measured = resin.peel_memory_measured;
  subject.undersides = resin.undersides;
  if (options.undersides) subject.undersides = undersides_of(*options.undersides);
  const std::string missing = missing_for_dimming(resin);
  if (subject.undersides == Undersides::Plain || missing.empty()) return;
  if (options.undersides)
    throw ModelError(fmt::format("undersides cannot be exposed by dose: {}", printable(missing)));
  subject.undersides = Undersides::Plain;  // as in a print
}

// Prepares the model in the middle of a display, without a printer's configuration.
CureSubject subject_alone(const CureOptions& options) {
  if (!options.resin) throw UsageError("cure needs --printer, or --resin with the resin's profile");
  const std::optional<UpOption> up = parse_up(options.up);
  const EngineSettings engine{parse_display(options.display), parse_anti_aliasing(options.display)};
  ResinProfile resin = load_resin_profile(*options.resin, {});
  CureSubject subject;
  take_resin(resin, options, subject);
  if (options.layer_height_um)
    resin.layer_height = parse_um("--layer-height-um", *options.layer_height_um, 1);
  // The curve's exposures are in proportion to the irradiance, so that the doses are the same for any.
  constexpr double kAnyIrradiance = 10;
  for (const std::string& problem : layer_height_problems(resin, resin.layer_height, kAnyIrradiance))
    throw ModelError(fmt::format("{}: {}", printable(resin.name), problem));
  Model model = read_turned_model(options.model, up, parse_size(options.size));
  subject.warnings = std::move(model.warnings);
  const auto made = std::make_shared<const HeightIndex>(std::move(model.facets));
  SupportedModel supported =
      options.supports && *options.supports != "off"
          ? support_model(made, {.display = engine.display,
                                 .layer = resin.layer_height,
                                 .compensation = resin.compensation,
                                 .anti_aliasing = engine.anti_aliasing,
                                 .policy = support_policy(*options.supports)})
          : lay_on_plate(made, PixelMap::true_scale(engine.display, made->bounds().center()));
  EngineSettings compensated = engine;
  compensated.compensation = resin.compensation;
  subject.layers =
      layer_doses(resin, print_layers(supported.model, resin.layer_height, {}).all(), kAnyIrradiance);
  subject.settings = compensated;
  subject.engine = std::make_unique<ContourEngine>(supported.engine(compensated));
  if (std::string own = own_supports_sentence("the model", supported.own_supports, "contourctl");
      !own.empty())
    subject.warnings.push_back(std::move(own));
  subject.supports = std::move(supported.supports);
  return subject;
}

// Prepares the model as contourd prints it.
CureSubject subject_of_printer(const CureOptions& options) {
  const PrinterConfig printer = load_printer_config(*options.printer, Places::Elsewhere);
  (void)read_model(options.model);  // a bad file gives the same message as with other commands
  AskedOfJob asked{.supports = {}, .scale = parse_size(options.size)};
  if (options.supports) asked.supports = support_policy(*options.supports);
  PreparedJob job =
      prepare_model({options.model.stem().string(), options.model, options.ticket}, printer, asked);
  CureSubject subject;
  const ResinProfile& resin = job.summary.resin;
  take_resin(resin, options, subject);
  subject.engine = std::move(job.analysis_engine);
  subject.settings = {job.display, printer.anti_aliasing ? AntiAliasing::On : AntiAliasing::Off,
                      resin.compensation, printer.tone, printer.uniformity};
  subject.layers = layer_doses(resin, job.plan.expected_layers, printer.irradiance_mw_cm2);
  subject.supports = std::move(job.summary.supports);
  subject.mask_budget = job.analysis.mask_budget;
  subject.warnings = std::move(job.summary.warnings);
  return subject;
}

std::vector<std::string> warnings_of(const CureSubject& subject, const CuredPart& part) {
  std::vector<std::string> warnings = subject.warnings;
  if (!subject.memory_is_measured)
    warnings.push_back(
        "the resin's peel_memory was not measured: all light is taken to be remembered, so undersides are "
        "the lowest that they can be");
  if (part.weakest_bond > 0 && part.weakest_bond < 1)
    warnings.push_back(fmt::format(
        "layer {} does not cure down to the layer beneath, which gets {:.2f} of the dose at which resin gels",
        part.weakest_bond_layer + 1, part.weakest_bond));
  if (part.abandoned_layers > 0)
    warnings.push_back(
        fmt::format("{} masks exceeded their time budget and count as dark", part.abandoned_layers));
  return warnings;
}

std::string place_text(const CurePlace& place) {
  return fmt::format("at {:.2f}, {:.2f} mm, {:.2f} mm above the plate", place.plate_mm.x, place.plate_mm.y,
                     place.height_mm);
}

void print_distances(const char* name, const SurfaceDistances& distances) {
  if (distances.places + distances.missing == 0) {
    fmt::print("{:<13} none\n", name);
    return;
  }
  fmt::print("{:<13} ", name);
  if (distances.places > 0)
    fmt::print("median {:+.0f} um, 95 % within {:.0f} um, worst {:+.0f} um {}", distances.median_um,
               distances.p95_um, distances.worst_um, place_text(distances.worst));
  if (distances.missing > 0)
    fmt::print("{}{:.2f} % missing", distances.places > 0 ? ", " : "",
               100.0 * static_cast<double>(distances.missing) /
                   static_cast<double>(distances.missing + distances.places));
  fmt::print("\n");
}

void print_text(const CureSubject& subject, const CuredPart& part) {
  const CureFigures& found = part.figures;
  std::vector<Nanometers> thicknesses;
  for (const LayerDose& layer : subject.layers)
    thicknesses.push_back(layer.thickness);
  fmt::print("layers        {}\n", layers_text(thicknesses));
  fmt::print("resin         {}: Dp {:.4g} um, Ec {:.4g} mJ/cm², memory {:.3g}\n", printable(subject.resin),
             subject.cure.curve.penetration_depth.count(), subject.cure.curve.critical_dose.count(),
             subject.cure.peel_memory);
  print_distances("undersides", found.undersides);
  print_distances("tops", found.tops);
  print_distances("walls", found.walls);
  fmt::print("volume        {:.2f} mm³; {:.2f} mm³ too much, {:.2f} mm³ missing\n", found.model_mm3,
             found.too_much_mm3, found.too_little_mm3);
  if (found.closed_mm2 > 0)
    fmt::print("closed gaps   {:.2f} mm², the tallest {:.3f} mm {}\n", found.closed_mm2,
               found.tallest_closed_mm, place_text(found.closed));
  if (part.weakest_bond > 0)
    fmt::print("weakest bond  {:.2f} of the dose at which resin gels, layer {}\n", part.weakest_bond,
               part.weakest_bond_layer + 1);
  for (const std::string& warning : warnings_of(subject, part))
    fmt::print("warning       {}\n", printable(warning));
}

Json place_json(const CurePlace& place) {
  return {place.plate_mm.x, place.plate_mm.y, place.height_mm};
}

Json distances_json(const SurfaceDistances& distances) {
  Json json{{"places", distances.places}, {"missing", distances.missing}};
  if (distances.places == 0) return json;
  json["median_um"] = distances.median_um;
  json["p95_um"] = distances.p95_um;
  json["worst_um"] = distances.worst_um;
  json["worst_mm"] = place_json(distances.worst);
  return json;
}

void print_json(const CureSubject& subject, const CuredPart& part) {
  const CureFigures& found = part.figures;
  Json json{{"layers", subject.layers.size()},
            {"resin",
             {{"name", subject.resin},
              {"penetration_depth_um", subject.cure.curve.penetration_depth.count()},
              {"critical_energy_mj_cm2", subject.cure.curve.critical_dose.count()},
              {"peel_memory", subject.cure.peel_memory},
              {"peel_memory_measured", subject.memory_is_measured}}},
            {"undersides", distances_json(found.undersides)},
            {"tops", distances_json(found.tops)},
            {"walls", distances_json(found.walls)},
            {"model_mm3", found.model_mm3},
            {"too_much_mm3", found.too_much_mm3},
            {"missing_mm3", found.too_little_mm3},
            {"closed_gaps_mm2", found.closed_mm2},
            {"tallest_closed_gap_mm", found.tallest_closed_mm}};
  if (found.closed_mm2 > 0) json["tallest_closed_gap_at_mm"] = place_json(found.closed);
  json["weakest_bond"] = part.weakest_bond;
  json["weakest_bond_layer"] = part.weakest_bond > 0 ? Json(part.weakest_bond_layer + 1) : Json();
  json["warnings"] = warnings_of(subject, part);
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

int cure(const CureOptions& options) {
  (void)parse_size(options.size);
  CureSubject subject = options.printer ? subject_of_printer(options) : subject_alone(options);
  std::optional<UndersideDimming> undersides;
  if (subject.undersides == Undersides::Dose)
    undersides.emplace(subject.engine->models(), subject.supports ? subject.supports->structure : nullptr,
                       subject.settings,
                       UndersideCure{subject.layers, subject.cure, subject.mask_budget.value_or(kNoHurry)});
  const CuredPart part = cure_part(*subject.engine, subject.settings.display,
                                   {subject.layers, subject.cure, {}, undersides ? &*undersides : nullptr},
                                   subject.supports ? &*subject.supports : nullptr, subject.mask_budget);
  if (options.json) {
    print_json(subject, part);
  } else {
    print_text(subject, part);
  }
  return kOk;
}

}  // namespace

void add_cure(Command& program) {
  Command& command =
      program.add("cure", "Compute the part that the light cures, and its distance from the model");
  auto& options = command.arguments<CureOptions>();
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--json", options.json, "Print JSON");
  const Option& printer = command.option("--printer", options.printer, kLikePrinterHelp);
  command.option("--ticket", options.ticket, "Ticket of the job").needs(printer);
  command.option("--resin", options.resin, "Profile of the resin, without --printer").excludes(printer);
  command
      .option("--supports", options.supports,
              "Generate supports: auto, on or off (default: as configured, or off)")
      .one_of({"auto", "on", "off"});
  command.option("--undersides", options.undersides, kUndersidesHelp).one_of({"plain", "dose"});
  add_size_options(command, options.size);
  command.option("--up", options.up, kUpHelp).suggests(up_presets).excludes(printer);
  command.option("--layer-height-um", options.layer_height_um, "Layer height, um (default: the resin's)")
      .excludes(printer);
  add_display_options(command, options.display, &printer);
  command.run = [&options] { return cure(options); };
}

}  // namespace contourd::ctl
