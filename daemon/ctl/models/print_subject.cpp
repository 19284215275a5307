#include "daemon/ctl/models/print_subject.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "core/layers/print_layers.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/prepare/resin_temperature.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr Duration kNoHurry = std::chrono::seconds(60);  // for a mask that is computed ahead

constexpr double kLayerHeightUm = 50;  // without a resin

void add(std::string warning, PrintSubject& subject) {
  if (!warning.empty()) subject.warnings.push_back(std::move(warning));
}

// Throws ModelError if the option asks for undersides that the print would expose plainly.
void refuse_plain_undersides(const PrintArgs& args, const PrintSubject& subject) {
  if (args.undersides != "dose" || subject.resin.value().undersides == Undersides::Dose) return;
  throw ModelError(fmt::format("undersides cannot be exposed by dose: {}",
                               printable(missing_for_dimming(*subject.resin))));
}

// Reads the resin's profile, with the layer height and the undersides of the options.
ResinProfile read_resin(const PrintArgs& args) {
  ResinProfile resin = load_resin_profile(*args.resin, {});
  if (args.layer_height_um) resin.layer_height = parse_um("--layer-height-um", *args.layer_height_um, 1);
  if (args.undersides) resin.undersides = undersides_of(*args.undersides);
  return resin;
}

// The curve's exposures are in proportion to the irradiance, so that the doses are the same for any.
constexpr double kAnyIrradiance = 10;

void take_resin(const PrintArgs& args, PrintSubject& subject) {
  ResinProfile& resin = subject.resin.emplace(read_resin(args));
  for (const std::string& problem :
       layer_height_problems(resin, resin.layer_height, kAnyIrradiance, Irradiance::Assumed))
    throw ModelError(fmt::format("{}: {}", printable(resin.name), problem));
  add(settle_undersides(resin), subject);
  refuse_plain_undersides(args, subject);
  subject.settings.compensation = resin.compensation;
  subject.analysis.support = resin.support;
}

SupportedModel stand(std::shared_ptr<const HeightIndex> model, const PrintArgs& args,
                     const PrintSubject& subject, Nanometers layer) {
  const EngineSettings& settings = subject.settings;
  if (!args.supports || *args.supports == "off") {
    const PixelMap map = PixelMap::true_scale(settings.display, model->bounds().center());
    return lay_on_plate(std::move(model), map);
  }
  return support_model(std::move(model), {.display = settings.display,
                                          .layer = layer,
                                          .compensation = settings.compensation,
                                          .anti_aliasing = settings.anti_aliasing,
                                          .threshold = settings.tone.threshold,
                                          .policy = support_policy(*args.supports)});
}

void warn_about_size(const Bounds& bounds, PrintSubject& subject) {
  const DisplayGeometry& display = subject.settings.display;
  if (subject.layers.empty())
    add(fmt::format("the model is {:.6g} mm high, too thin for a layer: nothing would be printed",
                    bounds.size_z()),
        subject);
  if (bounds.size_x() > display.width_mm() || bounds.size_y() > display.height_mm())
    add("the model is larger than the display: parts outside are not counted", subject);
}

// Prepares the model in the middle of a display, without a printer's configuration.
PrintSubject subject_alone(const PrintArgs& args) {
  const std::optional<UpOption> up = parse_up(args.up);
  PrintSubject subject;
  subject.settings = {
      parse_display(args.display), parse_anti_aliasing(args.display), {}, args.tone, args.uniformity};
  Nanometers layer = parse_um("--layer-height-um", args.layer_height_um.value_or(kLayerHeightUm), 1);
  if (args.resin) {
    take_resin(args, subject);
    layer = subject.resin->layer_height;
  }
  Model model = read_turned_model(args.model, up, args.size);
  std::ranges::move(model.warnings, std::back_inserter(subject.warnings));
  const auto made = std::make_shared<const HeightIndex>(std::move(model.facets));
  std::ranges::move(mesh_warnings(made->turned_outwards(), made->repairs()),
                    std::back_inserter(subject.warnings));
  SupportedModel supported = stand(made, args, subject, layer);
  subject.layers = print_layers(supported.model, layer, {}).all();
  if (subject.resin) subject.doses = layer_doses(*subject.resin, subject.layers, kAnyIrradiance);
  const Bounds bounds = made->bounds();
  subject.size_mm = {bounds.size_x(), bounds.size_y(), bounds.size_z()};
  warn_about_size(bounds, subject);
  subject.engine = std::make_unique<ContourEngine>(supported.engine(subject.settings));
  add(unmet_parts_warning(subject.engine->models().front(), subject.settings.display,
                          middles_of(subject.layers), kLongestMask),
      subject);
  std::ranges::move(supported.warnings(), std::back_inserter(subject.warnings));
  subject.supports = std::move(supported.supports);
  return subject;
}

std::optional<SplitPrint> split_of(const PreparedJob& job, const PrinterConfig& printer) {
  if (!printer.splits_exposures()) return std::nullopt;
  const PrintPlan& plan = job.plan;
  SplitPrint split{{printer.grey_bits, job.summary.tone.gamma}, {}};
  for (std::size_t i = 0; i < plan.expected_layers.size(); ++i)
    split.shortest.push_back(
        SplitExposure::shortest_share(plan.exposure(static_cast<std::int32_t>(i), plan.expected_layers[i]),
                                      printer.simulated.display.frame));
  return split;
}

// Prepares the model as contourd prints it.
PrintSubject subject_of_printer(const PrintArgs& args) {
  const PrinterConfig printer = load_printer_config(*args.printer, Places::Elsewhere);
  // Reads the model first, so that a bad file gives the same message as with other commands.
  const std::vector<std::string> names = models_named_in(args.ticket);
  if (!holds_layers(args.model, names)) (void)read_model(args.model, names);
  AskedOfJob asked{.unit = parse_unit(args.size.unit),
                   .scale = parse_size({std::nullopt, args.size.scale}),
                   .hollow_wall = parse_hollow(args.hollow_mm)};
  if (args.supports) asked.supports = support_policy(*args.supports);
  if (args.undersides) asked.undersides = undersides_of(*args.undersides);
  if (args.mode) asked.mode = print_way_of(*args.mode);
  PreparedJob job =
      prepare_model({model_stem(args.model.filename().string()), args.model, args.ticket}, printer, asked);
  if (args.follows_temperature) follow_temperature(job, printer);
  PrintSubject subject;
  subject.pixel_light = printer.pixel_light;
  subject.settings = engine_settings(printer, job.summary.resin);
  subject.copies = copies_of(job.summary, "");
  subject.layers = job.plan.expected_layers;
  subject.doses = layer_doses(job.summary.resin, subject.layers, printer.irradiance_mw_cm2);
  if (!subject.layers.empty()) {
    const ResinProfile& resin = job.summary.resin;
    const Nanometers layer = subject.layers.front();
    subject.exposures = {job.plan.exposure(0, layer),
                         job.plan.exposure(resin.bottom_layers + resin.fade_layers, layer)};
  }
  subject.split = split_of(job, printer);
  subject.layer_durations = layer_durations(job.plan, printer);
  if (!subject.layers.empty()) subject.forecast = forecast_of(job.plan, printer);
  subject.continuous = std::move(job.summary.continuous);
  subject.resin = std::move(job.summary.resin);
  refuse_plain_undersides(args, subject);
  subject.engine = std::move(job.analysis_engine);
  subject.supports = std::move(job.summary.supports);
  subject.analysis = job.analysis;
  const ModelSummary& model = job.summary.models.front();
  subject.size_mm = {model.size_x_mm, model.size_y_mm, model.size_z_mm};
  subject.warnings = std::move(job.summary.warnings);
  return subject;
}

}  // namespace

std::unique_ptr<UndersideDimming> PrintSubject::dimming() const {
  if (!resin || resin->undersides == Undersides::Plain || layers.empty()) return nullptr;
  return std::make_unique<UndersideDimming>(
      engine->models(), supports ? supports->structure : nullptr, settings,
      UndersideCure{doses, resin->cure.value(), analysis.mask_budget.value_or(kNoHurry)});
}

std::unique_ptr<DimmedMasks> PrintSubject::dimmed_masks() const {
  std::unique_ptr<UndersideDimming> undersides = dimming();
  if (!undersides) return nullptr;
  return std::make_unique<DimmedMasks>(std::move(undersides), settings.tone, settings.uniformity);
}

std::unique_ptr<GivenLight> PrintSubject::given_light() const {
  return split ? std::make_unique<GivenLight>(split->panel, split->shortest) : nullptr;
}

PrintSubject print_subject(const PrintArgs& args) {
  (void)parse_size(args.size);
  (void)parse_hollow(args.hollow_mm);
  if (args.undersides && !args.printer && !args.resin)
    throw UsageError("--undersides needs --printer, or --resin with the resin's profile");
  return args.printer ? subject_of_printer(args) : subject_alone(args);
}

PrintOptions add_print_options(Command& command, PrintArgs& args, const char* layer_height_help) {
  command.option("MODEL", args.model, "Model file").required().allow_empty();
  const Option& printer = command.option("--printer", args.printer, kLikePrinterHelp);
  command.option("--ticket", args.ticket, "Ticket of the job").needs(printer);
  command.option("--hollow", args.hollow_mm, kHollowHelp).needs(printer);
  const Option& resin =
      command.option("--resin", args.resin, "Profile of the resin, without --printer").excludes(printer);
  command
      .option("--supports", args.supports,
              "Supports: auto, on, off, or \"in the file\": the model carries them (default: as configured, "
              "or off)")
      .one_of({"auto", "on", "off", "in the file"});
  command.option("--undersides", args.undersides, kUndersidesHelp).one_of({"plain", "dose"});
  add_size_options(command, args.size);
  command.option("--up", args.up, kUpHelp).suggests(up_presets).excludes(printer);
  command.option("--layer-height-um", args.layer_height_um, layer_height_help).excludes(printer);
  add_display_options(command, args.display, &printer);
  return {printer, resin};
}

}  // namespace contourd::ctl
