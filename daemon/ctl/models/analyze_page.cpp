#include "daemon/ctl/models/analyze_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/ctl/models/analyze_page_text.hpp"
#include "daemon/ctl/models/statistics_text.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

// Limit of rows in each table of islands, suction cups and resin traps: the largest are listed.
constexpr std::size_t kMaxRows = 50;
// Limit of contacts in the picture.
constexpr std::size_t kMaxContacts = 5000;

// Replaces each {{name}} in the template by the value of that name. Values are not searched for names.
std::string filled(std::string_view text, const std::map<std::string, std::string, std::less<>>& values) {
  std::string page;
  while (true) {
    const std::size_t begin = text.find("{{");
    page += text.substr(0, begin);
    if (begin == std::string_view::npos) return page;
    const std::size_t end = text.find("}}", begin);
    page += values.at(std::string(text.substr(begin + 2, end - begin - 2)));
    text.remove_prefix(end + 2);
  }
}

std::string row(const std::string& name, const std::string& value) {
  return fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escaped(value));
}

std::string facts(const AnalyzedModel& m) {
  const PrintFindings& found = m.findings;
  std::string rows;
  rows += row("Model", fmt::format("{} facets, {:.2f} x {:.2f} x {:.2f} mm", m.facets, m.size_x_mm,
                                   m.size_y_mm, m.size_z_mm));
  rows += row("Layers", layers_text(m.layers));
  rows += row("Time of the layers", layer_time_text(m));
  rows += row("Resin", fmt::format("{:.2f} ml", found.resin_ml()));
  if (m.supports) rows += row("Supports", supports_line(counts_of(*m.supports)));
  rows += row("Largest area",
              fmt::format("{:.2f} mm2, layer {}", found.largest_area_mm2, found.largest_area_layer + 1));
  rows += row("Islands", std::to_string(found.island_count));
  rows += row("Suction cups", std::to_string(found.suction_cup_count));
  rows += row("Resin traps", std::to_string(found.resin_trap_count));
  rows += row("Empty layers", std::to_string(found.empty_layers.size()));
  rows +=
      row("Cracks",
          found.cracked_layers.empty()
              ? "none"
              : fmt::format("{} gaps closed, {} open and {} turned chains on {} layers, the widest {:.3f} mm",
                            found.cracks.gaps_closed, found.cracks.open_chains, found.cracks.turned_chains,
                            found.cracked_layers.size(), found.cracks.widest_gap.count()));
  for (const std::string& warning : m.warnings)
    rows += row("Warning", warning);
  for (const std::string& warning : warnings_about(found))
    rows += row("Warning", warning);
  return rows;
}

// Returns the height at which a layer is cut.
double height_mm(const AnalyzedModel& m, std::int32_t layer) {
  return to_millimeters(m.layer_middles[static_cast<std::size_t>(layer)]).count();
}

// Returns the islands, the largest first.
std::vector<Island> islands_by_size(const AnalyzedModel& m) {
  std::vector<Island> islands = m.findings.islands;
  std::ranges::stable_sort(islands, [](const Island& a, const Island& b) { return a.area_mm2 > b.area_mm2; });
  return islands;
}

std::string island_table(const AnalyzedModel& m) {
  if (m.findings.islands.empty()) return "";
  const std::vector<Island> islands = islands_by_size(m);
  const std::size_t shown = std::min(islands.size(), kMaxRows);
  std::string table = fmt::format(
      "<h2>Islands{}</h2>\n<table class=\"figures places\" id=\"islands\">\n<tr><th>layer</th><th>height "
      "mm</th><th>x "
      "mm</th><th>y mm</th><th>area mm²</th></tr>\n",
      shown < m.findings.island_count ? fmt::format(", the largest {} of {}", shown, m.findings.island_count)
                                      : "");
  for (std::size_t i = 0; i < shown; ++i) {
    table += fmt::format(
        "<tr "
        "data-mark=\"{}\"><td>{}</td><td>{:.3f}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.4g}</td></tr>\n",
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
  std::string table = fmt::format(
      "<h2>{}{}</h2>\n<table class=\"figures places\" id=\"{}\">\n<tr><th>layers</th><th>widest "
      "mm</th><th>x mm</th><th>y mm</th><th>area mm²</th><th>volume mm³</th></tr>\n",
      kind.title, shown < kind.count ? fmt::format(", the largest {} of {}", shown, kind.count) : "",
      kind.id);
  for (std::size_t i = 0; i < shown; ++i) {
    const PrintVoid& each = kind.voids[i];
    table += fmt::format(
        "<tr data-mark=\"{}\"><td>{} to {}{}</td><td>{:.3f}</td><td>{:.2f}</td><td>{:.2f}</td>"
        "<td>{:.4g}</td><td>{:.4g}</td></tr>\n",
        kind.first_mark + i, each.first_layer + 1, each.last_layer + 1, each.on_plate ? ", on the plate" : "",
        height_mm(m, each.widest_layer), each.plate_mm.x, each.plate_mm.y, each.area_mm2, each.volume_mm3);
  }
  return table + "</table>\n";
}

std::string void_tables(const AnalyzedModel& m) {
  std::string tables;
  for (const VoidsShown& kind : voids_shown(m))
    tables += void_table(m, kind);
  return tables;
}

template <typename Value>
std::string plot_of(const AnalyzedModel& m, const std::string& title, Value&& value) {
  std::vector<PlotPoint> points;
  for (std::size_t i = 0; i < m.measurements.size(); ++i)
    points.push_back({m.measurements[i].z.count(), static_cast<double>(value(i))});
  return "<div>" + svg_plot(title, points) + "</div>\n";
}

// Returns a plot's title with mean and standard deviation (thesis, tables 4.1 to 4.4 and 4.6).
std::string titled(const char* name, const MeanAndDeviation& v) {
  return fmt::format("{} <small>mean {:.4g}, SD {:.4g}</small>", name, v.mean, v.deviation);
}

std::string plots(const AnalyzedModel& m) {
  const LayerStatistics& s = m.statistics;
  const auto& layers = m.measurements;
  return plot_of(m, titled("Slicing time, ms", s.slicing_ms),
                 [&](std::size_t i) { return layers[i].slicing_ms; }) +
         plot_of(m, titled("Contour time, ms", s.contour_ms),
                 [&](std::size_t i) { return layers[i].contour_ms; }) +
         plot_of(m, titled("Total time, ms", s.total_ms),
                 [&](std::size_t i) { return layers[i].total_ms(); }) +
         plot_of(m, titled("Intersecting facets", s.intersecting_facets),
                 [&](std::size_t i) { return layers[i].intersecting_facets; }) +
         plot_of(m, titled("Contour loops", s.loop_count),
                 [&](std::size_t i) { return layers[i].loop_count; }) +
         plot_of(m, "Exposed area, mm²", [&](std::size_t i) { return m.findings.area_mm2[i]; });
}

std::string correlations(const AnalyzedModel& m) {
  return fmt::format(
      "<tr><th>Contour time and contour loops</th><td>{:.4f}</td></tr>\n"
      "<tr><th>Contour time and intersecting facets</th><td>{:.4f}</td></tr>\n",
      m.statistics.contour_time_vs_loop_count, m.statistics.contour_time_vs_intersecting_facets);
}

Json quantity(const char* name, const char* unit, std::vector<double> values) {
  return {{"name", name}, {"unit", unit}, {"values", std::move(values)}};
}

// Returns the quantities that the colours of the layers can show.
Json quantities(const AnalyzedModel& m) {
  const auto of = [&m](auto&& value) {
    std::vector<double> values;
    for (const std::int32_t layer : m.contours.layers)
      values.push_back(static_cast<double>(value(static_cast<std::size_t>(layer))));
    return values;
  };
  const auto& layers = m.measurements;
  return {
      quantity("Contour time", "ms", of([&](std::size_t i) { return layers[i].contour_ms; })),
      quantity("Slicing time", "ms", of([&](std::size_t i) { return layers[i].slicing_ms; })),
      quantity("Total time", "ms", of([&](std::size_t i) { return layers[i].total_ms(); })),
      quantity("Intersecting facets", "", of([&](std::size_t i) { return layers[i].intersecting_facets; })),
      quantity("Contour loops", "", of([&](std::size_t i) { return layers[i].loop_count; })),
      quantity("Exposed area", "mm²", of([&](std::size_t i) { return m.findings.area_mm2[i]; }))};
}

// Returns an array [cause, x, y, z, load, held] for each contact.
Json contacts_json(const AnalyzedModel& m) {
  Json contacts = Json::array();
  if (!m.supports) return contacts;
  const auto add = [&contacts](const SupportContact& contact, bool held) {
    if (contacts.size() >= kMaxContacts) return;
    contacts.push_back(
        {name_of(contact.cause), contact.place.x, contact.place.y, contact.place.z, contact.load_mm2, held});
  };
  for (const UnheldPlace& place : m.supports->unheld)
    add(place.contact, false);
  for (const SupportContact& contact : m.supports->contacts)
    add(contact, true);
  return contacts;
}

Json picture_data(const AnalyzedModel& m) {
  const ContourStack& stack = m.contours;
  std::vector<double> heights;
  for (const std::int32_t layer : stack.layers)
    heights.push_back(height_mm(m, layer));
  Json islands = Json::array();
  for (const Island& island : islands_by_size(m)) {
    islands.push_back({island.layer + 1, island.plate_mm.x, island.plate_mm.y, height_mm(m, island.layer),
                       island.area_mm2});
  }
  Json voids = Json::array();
  for (const VoidsShown& kind : voids_shown(m)) {
    for (const PrintVoid& each : kind.voids) {
      voids.push_back({each.widest_layer + 1, each.plate_mm.x, each.plate_mm.y,
                       height_mm(m, each.widest_layer), each.area_mm2});
    }
  }
  return {{"layers", stack.layers},
          {"heights_mm", heights},
          {"top_mm", m.top_mm},
          {"min_mm", {stack.min_x_mm, stack.min_y_mm}},
          {"size_mm", stack.size_mm},
          {"quantities", quantities(m)},
          {"islands", islands},
          {"voids", voids},
          {"contacts", contacts_json(m)},
          {"loops", base64(stack.words)},
          {"support_loops", base64(stack.support_words)}};
}

// Escapes JSON for the content of a script element, so that it cannot end the element.
std::string json_in_html(const Json& json) {
  std::string safe;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
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
  return filled(analyze_page_html, {{"name", escaped(model.name)},
                                    {"style", std::string(kPageStyle) + std::string(analyze_page_style)},
                                    {"summary", escaped(findings_line(model.findings))},
                                    {"facts", facts(model)},
                                    {"islands", island_table(model)},
                                    {"voids", void_tables(model)},
                                    {"plots", plots(model)},
                                    {"correlations", correlations(model)},
                                    {"data", json_in_html(picture_data(model))},
                                    {"script", std::string(analyze_page_script)}});
}

}  // namespace contourd::ctl
