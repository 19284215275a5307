#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "daemon/ctl/models/analyze_page.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/report/rise_forecast_text.hpp"
#include "daemon/system/readable.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {
namespace {

struct AnalyzeOptions {
  PrintArgs print;
  bool json = false;
  std::optional<std::filesystem::path> html;  // one self-contained page
  double layer_time_s = 10;                   // without a configuration: the time of each layer
};

Duration parse_layer_time(double seconds) {
  constexpr double kLongestLayerS = 3600;
  // Negated, so that NaN is refused, too.
  if (!(seconds >= 0 && seconds <= kLongestLayerS))
    throw UsageError(fmt::format("--layer-time-s {}: expected 0 to {}", seconds, kLongestLayerS));
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

using Json = nlohmann::ordered_json;

// Each layer is timed this often, and the shortest time counts, to exclude interruptions by other processes.
constexpr int kRuns = 3;

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

// Replaces the areas, which are those of the layers, by those that are exposed if undersides are dimmed.
void expose_by_dose(const PrintSubject& subject, AnalyzedModel& model) {
  const std::unique_ptr<DimmedMasks> masks = subject.dimmed_masks();
  if (!masks) return;
  const double pixel_mm = to_millimeters(model.display.pixel_pitch).count();
  PrintFindings& found = model.findings;
  for (std::size_t layer = 0; layer < model.layers.size(); ++layer) {
    MaskBudget budget;
    if (const auto limit = subject.analysis.mask_budget)
      budget = MaskBudget(MaskBudget::Clock::now() + *limit);
    if (subject.engine->mask_within(model.layer_middles[layer], budget) == nullptr) continue;
    (void)masks->mask(layer, subject.engine->coverage());
    found.area_mm2[layer] = masks->light().lit_area() * pixel_mm * pixel_mm;
  }
  const auto largest = std::ranges::max_element(found.area_mm2);
  found.largest_area_mm2 = *largest;
  found.largest_area_layer = static_cast<std::int32_t>(largest - found.area_mm2.begin());
}

AnalyzedModel analyze(PrintSubject subject, Duration layer_time, bool with_picture) {
  AnalyzedModel model;
  model.size_mm = subject.size_mm;
  model.display = subject.settings.display;
  model.layers = subject.layers;
  model.warnings = subject.warnings;
  if (!subject.layer_durations) model.assumed_layer_time = layer_time;
  for (const PlateModel& each : subject.engine->models())
    model.facets += each.model->facets().size();
  model.layer_middles = middles_of(model.layers);
  const auto duration_of = [&](std::int32_t layer) {
    return subject.layer_durations ? (*subject.layer_durations)[static_cast<std::size_t>(layer)] : layer_time;
  };
  model.findings =
      analyze_print(*subject.engine, model.display, model.layers, duration_of, {}, subject.analysis).value();
  expose_by_dose(subject, model);
  model.supports = std::move(subject.supports);
  model.forecast = subject.forecast;
  model.continuous = std::move(subject.continuous);
  LayerStopwatch stopwatch;
  for (const Nanometers middle : model.layer_middles)
    model.measurements.push_back(measure(*subject.engine, middle, stopwatch));
  model.statistics = statistics_of(model.measurements);
  if (with_picture) model.picture = draw_job(*subject.engine, model.supports ? &*model.supports : nullptr);
  return model;
}

void print_continuous(const ContinuousForecast& forecast) {
  fmt::print("continuous    {}\ngel gap       {}\n", continuous_line(forecast), gel_line(forecast));
  for (const std::string& line : range_lines(forecast))
    fmt::print("  {}\n", line);
}

void print_findings(const AnalyzedModel& m) {
  const PrintFindings& found = m.findings;
  fmt::print("facets        {}\nsize          {:.6g} x {:.6g} x {:.6g} mm\n", m.facets, m.size_mm[0],
             m.size_mm[1], m.size_mm[2]);
  fmt::print("layers        {}\n", layers_text(m.layers));
  fmt::print("layer time    {}\n", layer_time_text(m));
  if (m.forecast) {
    for (const std::string& line : forecast_lines(*m.forecast))
      fmt::print("{}\n", line);
  }
  if (m.continuous) print_continuous(*m.continuous);
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
  json["forecast"] = m.forecast ? forecast_json(*m.forecast) : Json();
  json["continuous"] = m.continuous ? continuous_json(*m.continuous) : Json();
  json["supports"] = m.supports ? supports_json(*m.supports) : Json();
  json["model_warnings"] = m.warnings;
  json["statistics"] = statistics_json(m.statistics);
  json["area_mm2"] = m.findings.area_mm2;
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

int analyze(const AnalyzeOptions& options) {
  const Duration layer_time = parse_layer_time(options.layer_time_s);
  refuse_to_overwrite_model(options.print.model, "--html", options.html);
  PrintSubject subject = print_subject(options.print);
  AnalyzedModel model = analyze(std::move(subject), layer_time, options.html.has_value());
  model.name = options.print.model.filename().string();
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
  const Option& printer =
      add_print_options(command, options.print, "Layer height, um (default: the resin's, or 50)").printer;
  command.option("--json", options.json, "Print JSON");
  command.option("--html", options.html, "Write a page with plots and a picture");
  command.option("--layer-time-s", options.layer_time_s, "Time that the printer needs per layer, s")
      .excludes(printer);
  command.option("--mode", options.print.mode, "Print mode: layered, or continuous with its plan")
      .one_of({"layered", "continuous"})
      .needs(printer);
  command.run = [&options] { return analyze(options); };
}

}  // namespace contourd::ctl
