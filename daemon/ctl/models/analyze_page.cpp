#include "daemon/ctl/models/analyze_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string_view>

#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/report/rise_forecast_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr std::string_view kAnalysisStyle = R"(
body { max-width: 74rem; }
.summary { opacity: .8; }
h2 small { font-weight: 400; opacity: .7; font-size: .85em; margin-left: .4em; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 2.5rem; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 0 2.5rem; margin-bottom: 2rem; }
.figures td, .figures th { font-variant-numeric: tabular-nums; }
.places { display: block; max-height: 16rem; overflow-y: auto; }
.places td, .places th { text-align: right; }
.columns th { white-space: nowrap; }
.plots svg text { font-size: 19px; }
.part { width: min(100%, 34rem); margin-top: 1rem; }
.shot .ring.void { stroke: #4db8ff; } .shot .ring.unheld { stroke: #fff; } .shot .ring:target { stroke-width: 6; }
)";

// Limit of rows in each table of islands, suction cups and resin traps: the largest are listed.
constexpr std::size_t kMaxRows = 50;

std::string facts(const AnalyzedModel& m) {
  const PrintFindings& found = m.findings;
  std::string rows;
  rows += table_row("Model", fmt::format("{} facets, {:.2f} x {:.2f} x {:.2f} mm", m.facets, m.size_mm[0],
                                         m.size_mm[1], m.size_mm[2]));
  rows += table_row("Layers", layers_text(m.layers));
  rows += table_row("Time of the layers", layer_time_text(m));
  if (m.continuous) {
    rows += table_row("Continuous", continuous_line(*m.continuous));
    rows += table_row("Gel gap", gel_line(*m.continuous));
  }
  rows += table_row("Resin", fmt::format("{:.2f} ml", found.resin_ml()));
  if (m.supports) rows += table_row("Supports", supports_line(counts_of(*m.supports)));
  rows += table_row("Largest area", fmt::format("{:.2f} mm², layer {}", found.largest_area_mm2,
                                                found.largest_area_layer + 1));
  rows += table_row("Islands", std::to_string(found.island_count));
  rows += table_row("Suction cups", std::to_string(found.suction_cup_count));
  rows += table_row("Resin traps", std::to_string(found.resin_trap_count));
  rows += table_row("Empty layers", std::to_string(found.empty_layers.size()));
  rows += table_row(
      "Cracks",
      found.cracked_layers.empty()
          ? "none"
          : fmt::format("{} gaps closed, {} open and {} turned chains on {} layers, the widest {:.3f} mm",
                        found.cracks.gaps_closed, found.cracks.open_chains, found.cracks.turned_chains,
                        found.cracked_layers.size(), found.cracks.widest_gap.count()));
  for (const std::string& warning : m.warnings)
    rows += table_row("Warning", warning);
  for (const std::string& warning : warnings_about(found))
    rows += table_row("Warning", warning);
  return rows;
}

// Returns the height at which a layer is cut.
double height_mm(const AnalyzedModel& m, std::int32_t layer) {
  return to_millimeters(m.layer_middles[static_cast<std::size_t>(layer)]).count();
}

// Returns the islands, the largest first.
std::vector<Island> islands_by_size(const AnalyzedModel& m) {
  std::vector<Island> islands = m.findings.islands;
  std::ranges::stable_sort(islands, std::ranges::greater{}, &Island::area_mm2);
  return islands;
}

// The beginning of a table of places, of which only the largest are listed.
struct PlacesTable {
  const char *title, *id, *columns;
  std::size_t shown;
  std::uint64_t count;
};

std::string start_of(const PlacesTable& table) {
  return fmt::format(
      "<h2>{}{}</h2>\n<table class=\"figures places\" id=\"{}\">\n<tr>{}</tr>\n", table.title,
      table.shown < table.count ? fmt::format(", the largest {} of {}", table.shown, table.count) : "",
      table.id, table.columns);
}

std::string island_table(const AnalyzedModel& m) {
  if (m.findings.islands.empty()) return "";
  const std::vector<Island> islands = islands_by_size(m);
  const std::size_t shown = std::min(islands.size(), kMaxRows);
  std::string table = start_of({"Islands", "islands",
                                "<th>layer</th><th>height mm</th><th>x mm</th><th>y mm</th><th>area mm²</th>",
                                shown, m.findings.island_count});
  for (std::size_t i = 0; i < shown; ++i) {
    table += fmt::format(
        "<tr><td><a href=\"#mark-{}\">{}</a></td><td>{:.3f}</td><td>{:.2f}</td><td>{:.2f}</td>"
        "<td>{:.4g}</td></tr>\n",
        i, islands[i].layer + 1, height_mm(m, islands[i].layer), islands[i].plate_mm.x, islands[i].plate_mm.y,
        islands[i].area_mm2);
  }
  return table + "</table>\n";
}

// The voids of one kind.
struct VoidsShown {
  const char* title;
  const char* id;
  std::size_t first_mark;
  std::uint64_t count;
  std::vector<PrintVoid> voids;  // the largest first
};

// Returns the kinds of voids in the order of the picture's marks.
std::vector<VoidsShown> voids_shown(const AnalyzedModel& m) {
  const PrintFindings& found = m.findings;
  std::vector<VoidsShown> shown{
      {"Suction cups", "cups", found.islands.size(), found.suction_cup_count, found.suction_cups},
      {"Resin traps", "traps", found.islands.size() + found.suction_cups.size(), found.resin_trap_count,
       found.resin_traps}};
  std::ranges::stable_sort(shown[0].voids, std::ranges::greater{}, &PrintVoid::area_mm2);
  std::ranges::stable_sort(shown[1].voids, std::ranges::greater{}, &PrintVoid::volume_mm3);
  return shown;
}

std::string void_table(const AnalyzedModel& m, const VoidsShown& kind) {
  if (kind.voids.empty()) return "";
  const std::size_t shown = std::min(kind.voids.size(), kMaxRows);
  std::string table = start_of({kind.title, kind.id,
                                "<th>layers</th><th>widest mm</th><th>x mm</th><th>y mm</th><th>area mm²</th>"
                                "<th>volume mm³</th>",
                                shown, kind.count});
  for (std::size_t i = 0; i < shown; ++i) {
    const PrintVoid& each = kind.voids[i];
    table += fmt::format(
        "<tr><td><a href=\"#mark-{}\">{} to {}</a>{}</td><td>{:.3f}</td><td>{:.2f}</td><td>{:.2f}</td>"
        "<td>{:.4g}</td><td>{:.4g}</td></tr>\n",
        kind.first_mark + i, each.first_layer + 1, each.last_layer + 1, each.on_plate ? ", on the plate" : "",
        height_mm(m, each.widest_layer), each.plate_mm.x, each.plate_mm.y, each.area_mm2, each.volume_mm3);
  }
  return table + "</table>\n";
}

// Returns a plot of a value of the layers. The title has mean and standard deviation (thesis, tables 4.1 to
// 4.4 and 4.6).
template <typename Value>
std::string plot_of(const AnalyzedModel& m, const char* name, const MeanAndDeviation& v, Value value) {
  std::vector<PlotPoint> points;
  for (const LayerMeasurement& layer : m.measurements)
    points.push_back({layer.z.count(), static_cast<double>(std::invoke(value, layer))});
  return "<div>" +
         svg_plot(fmt::format("{} <small>mean {:.4g}, SD {:.4g}</small>", name, v.mean, v.deviation),
                  points) +
         "</div>\n";
}

std::string plots(const AnalyzedModel& m) {
  const LayerStatistics& s = m.statistics;
  std::vector<PlotPoint> areas;
  for (std::size_t i = 0; i < m.measurements.size(); ++i)
    areas.push_back({m.measurements[i].z.count(), m.findings.area_mm2[i]});
  return plot_of(m, "Slicing time, ms", s.slicing_ms, &LayerMeasurement::slicing_ms) +
         plot_of(m, "Contour time, ms", s.contour_ms, &LayerMeasurement::contour_ms) +
         plot_of(m, "Total time, ms", s.total_ms, &LayerMeasurement::total_ms) +
         plot_of(m, "Intersecting facets", s.intersecting_facets, &LayerMeasurement::intersecting_facets) +
         plot_of(m, "Contour loops", s.loop_count, &LayerMeasurement::loop_count) + "<div>" +
         svg_plot("Exposed area, mm²", areas) + "</div>\n";
}

std::string correlations(const AnalyzedModel& m) {
  return fmt::format(
      "<tr><th>Contour time and contour loops</th><td>{:.4f}</td></tr>\n"
      "<tr><th>Contour time and intersecting facets</th><td>{:.4f}</td></tr>\n",
      m.statistics.contour_time_vs_loop_count, m.statistics.contour_time_vs_intersecting_facets);
}

// Returns a ring in the picture around a place on the plate.
std::string ring(const AnalyzedModel& m, const char* kind, const PreviewPlace& place,
                 const std::string& title, const std::string& id = "") {
  const PixelPoint at = m.picture.at(place);
  return fmt::format(
      "<circle class=\"ring {}\"{} cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\"><title>{}</title></circle>\n", kind,
      id, at.x, at.y, escaped(title));
}

// Returns the picture of the part: the places of the tables and those that are not held in rings, and the
// contacts of supports as dots.
std::string marked_picture(const AnalyzedModel& m) {
  const Supports* const supports = m.supports ? &*m.supports : nullptr;
  std::string rings;
  std::size_t mark = 0;
  const auto id_of = [](std::size_t number) { return fmt::format(" id=\"mark-{}\"", number); };
  for (const Island& island : islands_by_size(m)) {
    if (mark < kMaxRows) {
      rings += ring(m, "island", {island.plate_mm.x, island.plate_mm.y, height_mm(m, island.layer)},
                    fmt::format("island, layer {}", island.layer + 1), id_of(mark));
    }
    ++mark;
  }
  for (const VoidsShown& kind : voids_shown(m)) {
    for (std::size_t i = 0; i < std::min(kind.voids.size(), kMaxRows); ++i) {
      const PrintVoid& each = kind.voids[i];
      rings +=
          ring(m, "void", {each.plate_mm.x, each.plate_mm.y, height_mm(m, each.widest_layer)},
               fmt::format("{}, layer {}", kind.title, each.widest_layer + 1), id_of(kind.first_mark + i));
    }
  }
  for (const UnheldPlace& place : supports != nullptr ? supports->unheld : std::vector<UnheldPlace>()) {
    const PlatePoint& at = place.contact.place;
    rings += ring(m, "unheld", {at.x, at.y, at.z}, "not held: " + place.why);
  }
  return picture_figure(encode_picture(m.picture, supports), "The part as printed, shaded", rings);
}

}  // namespace

std::string layer_time_text(const AnalyzedModel& model) {
  std::string text = readable(model.findings.layer_time);
  if (model.assumed_layer_time) {
    text += fmt::format(", at {:g} s each (--printer uses a printer's times)",
                        std::chrono::duration<double>(*model.assumed_layer_time).count());
  }
  return text;
}

std::string analysis_page(const AnalyzedModel& model) {
  const std::string name = escaped(model.name);
  std::string tables = island_table(model);
  if (model.forecast) tables += "<h2>Time by cause</h2>\n" + forecast_table(*model.forecast);
  if (model.continuous) tables += "<h2>Rises</h2>\n" + ranges_table(*model.continuous);
  for (const VoidsShown& kind : voids_shown(model))
    tables += void_table(model, kind);
  return page_start(name + ": analysis", kAnalysisStyle) +
         fmt::format("<h1>{}</h1>\n<div class=\"summary\">{}</div>\n", name,
                     escaped(findings_line(model.findings))) +
         marked_picture(model) +
         fmt::format(
             "<div class=\"columns\">\n<div>\n<h2>The print</h2>\n<table>\n{}</table>\n</div>\n<div>\n"
             "<h2>Normalized correlation</h2>\n<table class=\"figures\">\n{}</table>\n{}</div>\n</div>\n"
             "<div class=\"plots\">\n{}</div>\n</html>\n",
             facts(model), correlations(model), tables, plots(model));
}

}  // namespace contourd::ctl
