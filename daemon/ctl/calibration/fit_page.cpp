#include "daemon/ctl/calibration/fit_page.hpp"

#include <fmt/format.h>

#include "daemon/report/html_page.hpp"

namespace contourd::ctl {
namespace {

constexpr const char* kFitStyle =
    ".figures td, .figures th { font-variant-numeric: tabular-nums; } .shot { max-width: 44rem; }\n"
    ".shot circle { fill: #fff; stroke: #000; stroke-width: 1.5; }\n";

std::string values_table(const FitResult& result, const nlohmann::ordered_json& before) {
  std::string table =
      "<table class=\"figures\">\n<tr><th>figure</th><th>value</th><th>+-</th><th>now</th></tr>\n";
  for (const CalibratedValue& each : result.values)
    table +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escaped(each.key.substr(1)),
                    escaped(each.value.is_null() ? "removed" : each.value.dump()),
                    each.uncertainty ? fmt::format("{:.3g}", *each.uncertainty) : "",
                    escaped(present_value(before, each.key)));
  return table + "</table>\n";
}

std::string points_table(const FitResult& result) {
  if (result.points.empty()) return "";
  const auto heading = [&result](const char* name) { return escaped(with_unit(name, result.unit, " ")); };
  std::string table = fmt::format(
      "<h2>Measurements</h2>\n<table "
      "class=\"figures\">\n<tr><th>{}</th><th>{}</th><th>{}</th><th>{}</th></tr>\n",
      escaped(result.given_heading), heading("measured"), heading("fitted"), heading("difference"));
  for (const auto& [given, measured, fitted] : result.points)
    table += fmt::format("<tr><td>{:.5g}</td><td>{:.5g}</td><td>{:.4g}</td><td>{:.2g}</td></tr>\n",
                         fmt::join(given, ", "), measured, fitted, result.without_noise(measured - fitted));
  return table + "</table>\n";
}

}  // namespace

std::string with_unit(const std::string& name, const std::string& unit, const char* between) {
  return unit.empty() ? name : name + between + unit;
}

std::string present_value(const nlohmann::ordered_json& file, const std::string& key) {
  const nlohmann::ordered_json::json_pointer place(key);
  return file.contains(place) ? file.at(place).dump() : "absent";
}

std::string fit_page(const FitResult& result, const std::string& file, const nlohmann::ordered_json& before) {
  const std::string title = escaped(fmt::format("Calibration: {}", result.kind));
  std::string page =
      page_start(title, kFitStyle) + fmt::format("<h1>{}</h1>\n<p>For {}</p>\n{}<h2>Fit</h2>\n{}", title,
                                                 escaped(file), values_table(result, before), result.figure);
  page += points_table(result);
  if (!result.notes.empty()) page += "<h2>Notes</h2>\n<ul>\n";
  for (const std::string& note : result.notes)
    page += fmt::format("<li>{}</li>\n", escaped(note));
  return page + (result.notes.empty() ? "</html>\n" : "</ul>\n</html>\n");
}

}  // namespace contourd::ctl
