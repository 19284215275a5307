#include "daemon/report/rise_forecast_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostLines = 25;

double mm_h(MillimetersPerSecond speed) {
  constexpr double kSecondsPerHour = 3600;
  return speed.count() * kSecondsPerHour;
}

double seconds(Duration time) {
  return std::chrono::duration<double>(time).count();
}

std::string_view name_of(RiseLimit limit) {
  switch (limit) {
    case RiseLimit::Cure:
      return "cure";
    case RiseLimit::Refill:
      return "refill";
    case RiseLimit::Oxygen:
      return "oxygen";
    case RiseLimit::Machine:
      return "machine";
  }
  return "";
}

std::string_view name_of(const ContinuousRange& range) {
  return range.limit ? name_of(*range.limit) : "layers";
}

Duration time_of(const ContinuousForecast& forecast, bool in_layers) {
  Duration time{};
  for (const ContinuousRange& range : forecast.ranges)
    if (range.limit.has_value() != in_layers) time += range.time;
  return time;
}

struct Rests {
  std::uint64_t count = 0;
  Duration time{};
};
Rests rests_of(const ContinuousForecast& forecast) {
  Rests rests;
  for (const ContinuousRange& range : forecast.ranges) {
    if (range.rest > Duration{}) ++rests.count;
    rests.time += range.rest;
  }
  return rests;
}

// The speeds of all rises.
struct Speeds {
  MillimetersPerSecond slowest, fastest;
};
std::optional<Speeds> speeds_of(const ContinuousForecast& forecast) {
  std::optional<Speeds> speeds;
  for (const ContinuousRange& range : forecast.ranges) {
    if (!range.limit) continue;
    if (!speeds) speeds = {range.slowest, range.fastest};
    speeds->slowest = std::min(speeds->slowest, range.slowest);
    speeds->fastest = std::max(speeds->fastest, range.fastest);
  }
  return speeds;
}

// The consequences of a speed.
struct Gel {
  double margin, gap_um, through_um;
};
Gel gel_at(const ContinuousForecast& forecast, MillimetersPerSecond speed) {
  const LitResin& lit = forecast.bounds.lit;
  const double margin = margin_at(lit, speed);
  return {margin, gel_gap(lit, margin).count(), print_through(lit.curve, margin).count()};
}

// Returns "9.2 to 55.3", or one number if both have the same digits.
std::string from_to(double low, double high) {
  const std::string first = fmt::format("{:.3g}", low), last = fmt::format("{:.3g}", high);
  return first == last ? first : first + " to " + last;
}

// The consequences of a slowest and of a fastest speed; at the slowest, resin cures furthest.
struct GelRange {
  Gel slowest, fastest;

  [[nodiscard]] std::string margin() const { return from_to(fastest.margin, slowest.margin); }
  [[nodiscard]] std::string gap_um() const { return from_to(slowest.gap_um, fastest.gap_um); }
  [[nodiscard]] std::string through_um() const { return from_to(fastest.through_um, slowest.through_um); }
};
GelRange gel_between(const ContinuousForecast& forecast, const Speeds& speeds) {
  return {gel_at(forecast, speeds.slowest), gel_at(forecast, speeds.fastest)};
}
GelRange gel_of(const ContinuousForecast& forecast, const ContinuousRange& range) {
  return gel_between(forecast, {range.slowest, range.fastest});
}

void add_gel(const GelRange& gel, Json& json) {
  json["margin"] = {gel.fastest.margin, gel.slowest.margin};
  json["gel_gap_um"] = {gel.slowest.gap_um, gel.fastest.gap_um};
  json["print_through_um"] = {gel.fastest.through_um, gel.slowest.through_um};
}

Json range_json(const ContinuousForecast& forecast, const ContinuousRange& range) {
  Json json{{"bottom_mm", in_mm(range.bottom)},
            {"top_mm", in_mm(range.top)},
            {"limit", range.limit ? Json(name_of(*range.limit)) : Json()},
            {"time_s", seconds(range.time)}};
  if (range.limit) {
    json["speed_mm_h"] = {mm_h(range.slowest), mm_h(range.fastest)};
    add_gel(gel_of(forecast, range), json);
  }
  json["rest_s"] = seconds(range.rest);
  return json;
}

// Returns the cells with the speeds of a rise and their consequences.
std::string rise_cells(const ContinuousForecast& forecast, const ContinuousRange& range) {
  const GelRange gel = gel_of(forecast, range);
  return fmt::format("<td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
                     from_to(mm_h(range.slowest), mm_h(range.fastest)), gel.margin(), gel.gap_um(),
                     gel.through_um());
}

}  // namespace

std::string continuous_line(const ContinuousForecast& forecast) {
  const Rests rests = rests_of(forecast);
  std::string line = fmt::format("{}: {} rising, {} in layers", readable(forecast.time()),
                                 readable(time_of(forecast, false)), readable(time_of(forecast, true)));
  if (rests.count > 0)
    line += fmt::format(", {}, {}", count_of(rests.count, "rest", "rests"), readable(rests.time));
  return line;
}

std::string gel_line(const ContinuousForecast& forecast) {
  const std::optional<Speeds> speeds = speeds_of(forecast);
  if (!speeds)
    return fmt::format("none: nowhere can the plate rise a millimetre at {:.3g} mm/h or faster",
                       mm_h(forecast.bounds.slowest));
  const GelRange gel = gel_between(forecast, *speeds);
  return fmt::format("{} um wide, cured {} um through undersides (margin {})", gel.gap_um(), gel.through_um(),
                     gel.margin());
}

std::vector<std::string> range_lines(const ContinuousForecast& forecast) {
  std::vector<std::string> lines;
  for (const ContinuousRange& range : forecast.ranges) {
    const std::string speeds = range.limit ? from_to(mm_h(range.slowest), mm_h(range.fastest)) + " mm/h" : "";
    if (lines.size() == kMostLines) {
      lines.push_back(fmt::format("and {} more; --json has all", forecast.ranges.size() - kMostLines));
      break;
    }
    lines.push_back(fmt::format("{:8.2f} to {:8.2f} mm  {:7}  {:20}  {}{}", in_mm(range.bottom),
                                in_mm(range.top), name_of(range), speeds, readable(range.time),
                                range.rest > Duration{} ? ", then a rest of " + readable(range.rest) : ""));
    if (!range.limit) continue;
    const GelRange gel = gel_of(forecast, range);
    lines.back() += fmt::format("; margin {}, cured {} um through", gel.margin(), gel.through_um());
  }
  return lines;
}

std::string ranges_table(const ContinuousForecast& forecast, std::span<const std::optional<Duration>> took) {
  std::string table =
      "<table class=\"figures\" id=\"ranges\">\n<tr><th>from, mm</th><th>to, mm</th><th>limit</th>"
      "<th>speed, mm/h</th><th>margin</th><th>gel gap, um</th><th>cured through undersides, um</th>"
      "<th>planned</th>";
  table += took.empty() ? "<th>rest</th></tr>\n" : "<th>took</th><th>rest</th></tr>\n";
  const std::size_t shown = std::min(forecast.ranges.size(), kMostLines);
  for (std::size_t i = 0; i < shown; ++i) {
    const ContinuousRange& range = forecast.ranges[i];
    table += fmt::format("<tr><td>{:.2f}</td><td>{:.2f}</td><td>{}</td>", in_mm(range.bottom),
                         in_mm(range.top), name_of(range));
    table += range.limit ? rise_cells(forecast, range) : "<td></td><td></td><td></td><td></td>";
    table += fmt::format("<td>{}</td>", readable(range.time));
    if (!took.empty()) table += fmt::format("<td>{}</td>", took[i] ? readable(*took[i]) : "");
    table += fmt::format("<td>{}</td></tr>\n", range.rest > Duration{} ? readable(range.rest) : "");
  }
  table += "</table>\n";
  if (shown < forecast.ranges.size())
    table += fmt::format("<p>And {} more.</p>\n", forecast.ranges.size() - shown);
  return table;
}

nlohmann::ordered_json continuous_json(const ContinuousForecast& forecast,
                                       std::span<const std::optional<Duration>> took) {
  Json json{{"time_s", seconds(forecast.time())},
            {"rising_s", seconds(time_of(forecast, false))},
            {"layers_s", seconds(time_of(forecast, true))},
            {"rests", rests_of(forecast).count},
            {"rests_s", seconds(rests_of(forecast).time)}};
  if (const std::optional<Speeds> speeds = speeds_of(forecast)) {
    json["speed_mm_h"] = {mm_h(speeds->slowest), mm_h(speeds->fastest)};
    add_gel(gel_between(forecast, *speeds), json);
  }
  json["ranges"] = Json::array();
  for (std::size_t i = 0; i < forecast.ranges.size(); ++i) {
    json["ranges"].push_back(range_json(forecast, forecast.ranges[i]));
    if (!took.empty()) json["ranges"].back()["took_s"] = took[i] ? Json(seconds(*took[i])) : Json();
  }
  return json;
}

}  // namespace contourd
