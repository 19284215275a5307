#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/analysis/print_analysis.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/models/analyze_page.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/system/readable.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {
namespace {

struct AnalyzeOptions {
  std::filesystem::path model;
  bool json = false;
  std::optional<std::filesystem::path> html;  // one self-contained page
  std::optional<std::string> supports;        // default: as configured; without a configuration none
  SizeArgs size;

  // Configuration and ticket of a print by contourd.
  std::optional<std::filesystem::path> printer, ticket;
  // Without a configuration: the direction that points up, the display, and the time of each layer.
  std::optional<std::string> up;
  DisplayArgs display;
  double layer_height_um = 50, layer_time_s = 10;
};

// The settings of a print without a configuration.
struct PrintAlone {
  std::optional<UpOption> up;
  EngineSettings engine;
  Nanometers layer_height;
  Duration layer_time;
};

PrintAlone parse_alone(const AnalyzeOptions& options) {
  constexpr double kLongestLayerS = 3600;
  PrintAlone print{.up = parse_up(options.up),
                   .engine = {parse_display(options.display), parse_anti_aliasing(options.display)},
                   .layer_height = parse_um("--layer-height-um", options.layer_height_um, 1),
                   .layer_time = {}};
  // Negated, so that NaN is refused, too.
  if (!(options.layer_time_s >= 0 && options.layer_time_s <= kLongestLayerS))
    throw UsageError(
        fmt::format("--layer-time-s {}: expected 0 to {}", options.layer_time_s, kLongestLayerS));
  print.layer_time =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.layer_time_s));
  return print;
}

using Json = nlohmann::ordered_json;

// Each layer is timed this often, and the shortest time counts, to exclude interruptions by other processes.
constexpr int kRuns = 3;

// The time for each mask in the search for parts that no layer has.
constexpr Duration kLongestMask = std::chrono::seconds(5);

struct AnalysisSubject {
  std::unique_ptr<ContourEngine> engine;
  std::vector<Duration> layer_durations;  // by layer
  AnalysisOptions analysis;
  AnalyzedModel model;
};

// Prepares the model in the middle of a display, without a printer's configuration.
AnalysisSubject subject_alone(const AnalyzeOptions& options, const PrintAlone& print) {
  AnalysisSubject subject;
  Model model = read_turned_model(options.model, print.up, parse_size(options.size));
  std::vector<std::string>& warnings = subject.model.warnings = std::move(model.warnings);
  const auto made = std::make_shared<const HeightIndex>(std::move(model.facets));
  std::ranges::move(mesh_warnings(made->turned_outwards(), made->repairs()), std::back_inserter(warnings));
  const Bounds bounds = made->bounds();
  const DisplayGeometry& display = print.engine.display;
  SupportedModel supported = options.supports && *options.supports != "off"
                                 ? support_model(made, {.display = display,
                                                        .layer = print.layer_height,
                                                        .anti_aliasing = print.engine.anti_aliasing,
                                                        .policy = support_policy(*options.supports)})
                                 : lay_on_plate(made, PixelMap::true_scale(display, bounds.center()));
  subject.model.layers = print_layers(supported.model, print.layer_height, {}).all();
  if (subject.model.layers.empty()) {
    warnings.push_back(fmt::format(
        "the model is {:.6g} mm high, too thin for a layer: nothing would be printed", bounds.size_z()));
  }
  subject.layer_durations.assign(subject.model.layers.size(), print.layer_time);
  subject.model.assumed_layer_time = print.layer_time;
  subject.model.display = display;
  subject.model.size_mm = {bounds.size_x(), bounds.size_y(), bounds.size_z()};
  if (bounds.size_x() > display.width_mm() || bounds.size_y() > display.height_mm())
    warnings.emplace_back("the model is larger than the display: parts outside are not counted");
  subject.engine = std::make_unique<ContourEngine>(supported.engine(print.engine));
  std::string unmet = unmet_parts_warning(subject.engine->models().front(), display,
                                          middles_of(subject.model.layers), kLongestMask);
  if (!unmet.empty()) warnings.push_back(std::move(unmet));
  subject.model.supports = std::move(supported.supports);
  if (std::string own = own_supports_sentence("the model", supported.own_supports, "contourctl");
      !own.empty())
    warnings.push_back(std::move(own));
  if (subject.model.supports) {
    if (std::string unheld = unheld_sentence(subject.model.supports->unheld); !unheld.empty())
      warnings.push_back(std::move(unheld));
  }
  return subject;
}

// Prepares the model as contourd prints it.
AnalysisSubject subject_of_printer(const AnalyzeOptions& options) {
  const PrinterConfig printer = load_printer_config(*options.printer, Places::Elsewhere);
  // Reads the model first, so that a bad file gives the same message as with other commands.
  (void)read_model(options.model);
  AskedOfJob asked{.supports = {}, .scale = parse_size(options.size)};
  if (options.supports) asked.supports = support_policy(*options.supports);
  PreparedJob job =
      prepare_model({options.model.stem().string(), options.model, options.ticket}, printer, asked);
  AnalysisSubject subject;
  const PrintPlan& plan = job.plan;
  subject.layer_durations = layer_durations(plan, printer);
  subject.engine = std::move(job.analysis_engine);
  subject.model.warnings = std::move(job.summary.warnings);
  subject.model.layers = plan.expected_layers;
  subject.model.display = job.display;
  subject.model.supports = std::move(job.summary.supports);
  subject.analysis = job.analysis;
  const ModelSummary& model = job.summary.models.front();
  subject.model.size_mm = {model.size_x_mm, model.size_y_mm, model.size_z_mm};
  return subject;
}

// Times slicing and joining of a layer (thesis, section 3.5).
LayerMeasurement measure(const ContourEngine& engine, Nanometers height, LayerStopwatch& stopwatch) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  LayerMeasurement best{to_millimeters(height), kNever, kNever, 0, 0};
  for (int run = 0; run < kRuns; ++run) {
    LayerMeasurement sum;
    for (const PlateModel& each : engine.models()) {
      const LayerMeasurement one = stopwatch.measure(*each.model, each.z_at(height), engine.join_tolerance());
      sum.slicing_ms += one.slicing_ms;
      sum.contour_ms += one.contour_ms;
      sum.intersecting_facets += one.intersecting_facets;
      sum.loop_count += one.loop_count;
    }
    best = {best.z, std::min(best.slicing_ms, sum.slicing_ms), std::min(best.contour_ms, sum.contour_ms),
            sum.intersecting_facets, sum.loop_count};
  }
  return best;
}

AnalyzedModel analyze(AnalysisSubject subject, bool with_picture) {
  AnalyzedModel model = std::move(subject.model);
  for (const PlateModel& each : subject.engine->models())
    model.facets += each.model->facets().size();
  model.layer_middles = middles_of(model.layers);
  const auto duration_of = [&](std::int32_t layer) {
    return subject.layer_durations[static_cast<std::size_t>(layer)];
  };
  model.findings =
      analyze_print(*subject.engine, model.display, model.layers, duration_of, {}, subject.analysis).value();
  LayerStopwatch stopwatch;
  for (const Nanometers middle : model.layer_middles)
    model.measurements.push_back(measure(*subject.engine, middle, stopwatch));
  model.statistics = statistics_of(model.measurements);
  if (with_picture) model.picture = draw_job(*subject.engine, model.supports ? &*model.supports : nullptr);
  return model;
}

void print_findings(const AnalyzedModel& m) {
  const PrintFindings& found = m.findings;
  fmt::print("facets        {}\nsize          {:.6g} x {:.6g} x {:.6g} mm\n", m.facets, m.size_mm[0],
             m.size_mm[1], m.size_mm[2]);
  fmt::print("layers        {}\n", layers_text(m.layers));
  fmt::print("layer time    {}\n", layer_time_text(m));
  fmt::print("resin         {:.3f} ml\n", found.resin_ml());
  if (m.supports) fmt::print("supports      {}\n", supports_line(counts_of(*m.supports)));
  fmt::print("largest area  {:.2f} mm², layer {}\n", found.largest_area_mm2, found.largest_area_layer + 1);
  fmt::print("islands       {}\nsuction cups  {}\nresin traps   {}\nempty layers  {}\n", found.island_count,
             found.suction_cup_count, found.resin_trap_count, found.empty_layers.size());
  fmt::print("cracks        {} gaps closed, the widest {:.3f} mm, {} open chains, {} turned, on {} layers\n",
             found.cracks.gaps_closed, found.cracks.widest_gap.count(), found.cracks.open_chains,
             found.cracks.turned_chains, found.cracked_layers.size());
  for (const std::string& warning : m.warnings)
    fmt::print("warning       {}\n", printable(warning));
  for (const std::string& warning : warnings_about(found))
    fmt::print("warning       {}\n", warning);
  fmt::print("\n");
  print_statistics(m.statistics);
}

void print_json(const AnalyzedModel& m) {
  Json json{{"facets", m.facets}, {"size_mm", m.size_mm}};
  const auto [thinnest, thickest] = std::minmax_element(m.layers.begin(), m.layers.end());
  json["layer_height_um"] = m.layers.empty() ? 0.0 : to_millimeters(*thinnest).count() * 1000;
  json["layer_height_max_um"] = m.layers.empty() ? 0.0 : to_millimeters(*thickest).count() * 1000;
  json.update(findings_json(m.findings));
  json["assumed_layer_time_s"] =
      m.assumed_layer_time ? Json(std::chrono::duration<double>(*m.assumed_layer_time).count()) : Json();
  json["supports"] = m.supports ? supports_json(*m.supports) : Json();
  json["model_warnings"] = m.warnings;
  json["statistics"] = statistics_json(m.statistics);
  json["area_mm2"] = m.findings.area_mm2;
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

int analyze(const AnalyzeOptions& options) {
  const PrintAlone alone = parse_alone(options);
  (void)parse_size(options.size);
  refuse_to_overwrite_model(options.model, "--html", options.html);
  AnalysisSubject subject = options.printer ? subject_of_printer(options) : subject_alone(options, alone);
  subject.model.name = options.model.filename().string();
  const AnalyzedModel model = analyze(std::move(subject), options.html.has_value());
  if (options.html) write_text(*options.html, analysis_page(model));
  if (options.json) {
    print_json(model);
  } else {
    print_findings(model);
  }
  return kOk;
}

}  // namespace

void add_analyze(Command& program) {
  Command& command = program.add("analyze", "Forecast a whole print: resin, areas, islands, times");
  auto& options = command.arguments<AnalyzeOptions>();
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--json", options.json, "Print JSON");
  command.option("--html", options.html, "Write a page with plots and a picture");
  const Option& printer = command.option("--printer", options.printer, kLikePrinterHelp);
  command.option("--ticket", options.ticket, "Ticket of the job").needs(printer);
  command
      .option("--supports", options.supports,
              "Generate supports: auto, on or off (default: as configured, or off)")
      .one_of({"auto", "on", "off"});
  add_size_options(command, options.size);
  command.option("--up", options.up, kUpHelp).suggests(up_presets).excludes(printer);
  command.option("--layer-height-um", options.layer_height_um, "Layer height, um").excludes(printer);
  command.option("--layer-time-s", options.layer_time_s, "Time that the printer needs per layer, s")
      .excludes(printer);
  add_display_options(command, options.display, &printer);
  command.run = [&options] { return analyze(options); };
}

}  // namespace contourd::ctl
