#include "daemon/report/time_causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<TimeCause, kTimeCauses> kCauses = [] {
  std::array<TimeCause, kTimeCauses> causes{};
  for (std::size_t i = 0; i < kTimeCauses; ++i)
    causes[i] = static_cast<TimeCause>(i);
  return causes;
}();

double seconds_of(Duration time) {
  return std::chrono::duration<double>(time).count();
}

// Returns the mean time of the layers and slices that a print exposed, without what is not of layers.
TimeByCause mean_layer_time(const PrintReport& report) {
  TimeByCause mean;
  const auto layers = static_cast<std::int64_t>(report.layers.size());
  if (layers == 0) return mean;
  const TimeByCause took = time_by_cause(report.states);
  for (const TimeCause cause : kCauses) {
    const bool is_of_print = cause == TimeCause::WarmingUp || cause == TimeCause::Homing ||
                             cause == TimeCause::Stopped || cause == TimeCause::Parking;
    if (!is_of_print) mean[cause] = took[cause] / layers;
  }
  return mean;
}

std::string cell(Duration time) {
  return fmt::format("<td>{}</td>", time == Duration{} ? "" : readable(time));
}

std::string layer_heading(const char* kind, const LayerTime& layer) {
  return fmt::format("<th>{} layer, {}</th>", kind, layer.layer + 1);
}

Json layer_time_json(const LayerTime& layer) {
  return {{"layer", layer.layer + 1},
          {"time_s", seconds_of(layer.time.total())},
          {"causes_s", causes_json(layer.time)}};
}

// Returns "+12 s", "-3 min 20 s".
std::string signed_text(Duration time) {
  return (time < Duration{} ? "-" : "+") + readable(std::max(time, -time));
}

}  // namespace

std::vector<TimeCause> differing_causes(const PrintReport& report) {
  std::vector<TimeCause> causes;
  if (report.outcome != PrintOutcome::Done) return causes;
  const TimeByCause took = time_by_cause(report.states);
  const Duration most = std::max<Duration>(report.forecast.time.total() / 50, std::chrono::seconds{5});
  for (const TimeCause cause : kCauses) {
    const Duration difference = took[cause] - report.forecast.time[cause];
    if (std::max(difference, -difference) > most) causes.push_back(cause);
  }
  return causes;
}

std::string causes_line(const TimeByCause& time) {
  std::array<TimeCause, kTimeCauses> causes = kCauses;
  std::ranges::stable_sort(causes, std::ranges::greater{}, [&](TimeCause cause) { return time[cause]; });
  std::string line = readable(time.total());
  const char* before = ": ";
  for (const TimeCause cause : causes) {
    if (time[cause] <= Duration{}) break;
    line += fmt::format("{}{} {}", before, readable(time[cause]), name_of(cause));
    before = ", ";
  }
  return line;
}

std::vector<std::string> forecast_lines(const PrintForecast& forecast) {
  return {fmt::format("print time    {}", causes_line(forecast.time)),
          fmt::format("typical layer {}, layer {}", causes_line(forecast.typical.time),
                      forecast.typical.layer + 1),
          fmt::format("longest layer {}, layer {}", causes_line(forecast.longest.time),
                      forecast.longest.layer + 1)};
}

nlohmann::ordered_json causes_json(const TimeByCause& time) {
  Json json = Json::object();
  for (const TimeCause cause : kCauses)
    json[std::string(name_of(cause))] = seconds_of(time[cause]);
  return json;
}

nlohmann::ordered_json forecast_json(const PrintForecast& forecast) {
  return {{"time_s", seconds_of(forecast.time.total())},
          {"causes_s", causes_json(forecast.time)},
          {"typical_layer", layer_time_json(forecast.typical)},
          {"longest_layer", layer_time_json(forecast.longest)}};
}

nlohmann::ordered_json times_json(const PrintReport& report) {
  Json differs = Json::array();
  for (const TimeCause cause : differing_causes(report))
    differs.push_back(name_of(cause));
  return {{"forecast", forecast_json(report.forecast)},
          {"took_s", causes_json(time_by_cause(report.states))},
          {"took_a_layer_s", causes_json(mean_layer_time(report))},
          {"differs", std::move(differs)}};
}

std::string forecast_table(const PrintForecast& forecast) {
  std::string table = "<table class=\"figures\" id=\"causes\">\n<tr><th>Cause</th><th>print</th>" +
                      layer_heading("typical", forecast.typical) +
                      layer_heading("longest", forecast.longest) + "</tr>\n";
  const auto row = [&](std::string_view name, Duration print, Duration typical, Duration longest) {
    table += fmt::format("<tr><td>{}</td>{}{}{}</tr>\n", name, cell(print), cell(typical), cell(longest));
  };
  for (const TimeCause cause : kCauses)
    if (forecast.time[cause] != Duration{})
      row(name_of(cause), forecast.time[cause], forecast.typical.time[cause], forecast.longest.time[cause]);
  row("sum", forecast.time.total(), forecast.typical.time.total(), forecast.longest.time.total());
  return table + "</table>\n";
}

std::string times_table(const PrintReport& report) {
  const PrintForecast& forecast = report.forecast;
  if (forecast.time.total() == Duration{}) return "";
  const TimeByCause took = time_by_cause(report.states), mean = mean_layer_time(report);
  const std::vector<TimeCause> differing = differing_causes(report);
  std::string table =
      "<div class=\"wide\">\n<table class=\"figures\" "
      "id=\"causes\">\n<tr><th>Cause</th><th>planned</th><th>took</th>"
      "<th>difference</th>" +
      layer_heading("planned: typical", forecast.typical) +
      layer_heading("planned: longest", forecast.longest) + "<th>took: mean layer</th></tr>\n";
  for (const TimeCause cause : kCauses) {
    if (forecast.time[cause] == Duration{} && took[cause] == Duration{}) continue;
    const bool differs = std::ranges::find(differing, cause) != differing.end();
    table += fmt::format("<tr><td>{}</td>{}{}<td{}>{}</td>{}{}{}</tr>\n", name_of(cause),
                         cell(forecast.time[cause]), cell(took[cause]), differs ? " class=\"differs\"" : "",
                         signed_text(took[cause] - forecast.time[cause]) + (differs ? " !" : ""),
                         cell(forecast.typical.time[cause]), cell(forecast.longest.time[cause]),
                         cell(mean[cause]));
  }
  table += fmt::format("<tr><td>sum</td>{}{}<td>{}</td>{}{}{}</tr>\n</table>\n</div>\n",
                       cell(forecast.time.total()), cell(took.total()),
                       signed_text(took.total() - forecast.time.total()), cell(forecast.typical.time.total()),
                       cell(forecast.longest.time.total()), cell(mean.total()));
  std::string marked;
  for (const TimeCause cause : differing)
    marked += fmt::format("{}{}", marked.empty() ? "" : ", ", name_of(cause));
  if (!marked.empty())
    table += fmt::format(
        "<p>Marked with !: {}. The print differs from its forecast in this by more than a fiftieth of the "
        "expected time.</p>\n",
        marked);
  return table;
}

}  // namespace contourd
