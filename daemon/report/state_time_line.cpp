#include "daemon/report/state_time_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "daemon/report/first_items.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

constexpr double kWidth = 860, kHeight = 132, kLeft = 10, kRight = 10;
constexpr double kBarTop = 26, kBarHeight = 66;
// Limits on the marks of pauses and of interruptions, and on the bytes of a mark's text.
constexpr std::size_t kMaxMarks = 100, kMaxTitle = 100;

double share(Duration part, Duration whole) {
  return in_seconds(part) / in_seconds(whole);
}

double place(Duration at, Duration whole) {
  return kLeft + std::clamp(share(at, whole), 0.0, 1.0) * (kWidth - kLeft - kRight);
}

// Returns the time between two labels, for at most about six labels.
double label_step_s(double total_s) {
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400;
  constexpr double kSteps[] = {0.01,         0.02,     0.05,        0.1,         0.2,
                               0.5,          1,        2,           5,           10,
                               30,           kMinute,  2 * kMinute, 5 * kMinute, 10 * kMinute,
                               30 * kMinute, kHour,    2 * kHour,   6 * kHour,   12 * kHour,
                               kDay,         2 * kDay, 5 * kDay,    10 * kDay,   30 * kDay};
  const auto* const found = std::ranges::find_if(kSteps, [&](double step) { return total_s / step <= 6; });
  return found != std::end(kSteps) ? *found : total_s / 6;
}

std::string label(double at_s, double step_s) {
  if (at_s == 0) return "0";
  if (step_s >= 86400) return fmt::format("{:.4g} d", at_s / 86400);
  if (step_s >= 3600) return fmt::format("{:.4g} h", at_s / 3600);
  if (step_s >= 60) return fmt::format("{:.4g} min", at_s / 60);
  return fmt::format("{:.4g} s", at_s);
}

std::string labels(Duration total) {
  const double step = label_step_s(in_seconds(total));
  std::string svg;
  for (int i = 0; i * step <= in_seconds(total); ++i) {
    const double x = kLeft + i * step / in_seconds(total) * (kWidth - kLeft - kRight);
    const char* const anchor = i == 0 ? "start" : x > kWidth - 60 ? "end" : "middle";
    svg += fmt::format(
        "<line class=\"tick\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"{4}\">{5}</text>\n",
        x, kBarTop + kBarHeight, kBarTop + kBarHeight + 5, kBarTop + kBarHeight + 26, anchor,
        label(i * step, step));
  }
  return svg;
}

// Draws an activity as one shape, whose height in each slice is the activity's share of that slice.
std::string shape_of(const StateTimes& states, std::size_t activity) {
  std::string path;
  const auto slices = states.slices();
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (slices[i][activity] == Duration{}) continue;
    Duration beneath{}, whole{};
    for (std::size_t other = 0; other < kPrintActivities; ++other) {
      if (other < activity) beneath += slices[i][other];
      whole += slices[i][other];
    }
    const double x = place(states.slice_width() * static_cast<std::int64_t>(i), states.total());
    const double end = place(states.slice_width() * static_cast<std::int64_t>(i + 1), states.total());
    const double height = share(slices[i][activity], whole) * kBarHeight;
    const double bottom = kBarTop + kBarHeight - share(beneath, whole) * kBarHeight;
    path += fmt::format("M{:.2f} {:.2f}H{:.2f}V{:.2f}H{:.2f}Z", x, bottom, end, bottom - height, x);
  }
  if (path.empty()) return "";
  const std::string_view name = name_of(static_cast<PrintActivity>(activity));
  return fmt::format("<path class=\"{0}\" d=\"{1}\"><title>{0}</title></path>\n", name, path);
}

std::string mark(const char* name, double x, const std::string& what) {
  return fmt::format("<path class=\"{}\" d=\"M{:.1f} {}l-6 -13h12z\"><title>{}</title></path>\n", name, x,
                     kBarTop - 3, escaped(shortened(what, kMaxTitle)));
}

std::string marks(const PrintReport& report) {
  const Duration total = report.states.total();
  std::string svg;
  for (const PrintPause& pause : first_items(report.stops.pauses, kMaxMarks)) {
    svg += mark("pause", place(pause.at, total),
                fmt::format("layer {}: stopped for {}", pause.layer + 1, readable(pause.lasted)));
  }
  for (const PrintInterruption& each : first_items(report.stops.interruptions, kMaxMarks)) {
    svg +=
        mark("interruption", place(each.at, total), fmt::format("layer {}: {}", each.layer + 1, each.what));
  }
  return svg;
}

}  // namespace

std::string state_time_line(const PrintReport& report) {
  const Duration total = report.states.total();
  if (total <= Duration{}) return "";
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"The printer's activity from the start of the "
      "print "
      "to its end; the table has the figures\">\n",
      kWidth, kHeight);
  for (std::size_t activity = 0; activity < kPrintActivities; ++activity)
    svg += shape_of(report.states, activity);
  return svg + labels(total) + marks(report) + "</svg>\n";
}

std::string state_table(const StateTimes& states) {
  if (states.total() <= Duration{}) return "";
  std::string rows;
  for (std::size_t activity = 0; activity < kPrintActivities; ++activity) {
    const auto drawn_as = static_cast<PrintActivity>(activity);
    for (const auto& [state, time] : states.totals()) {
      if (state == kIdle || state.activity != drawn_as || time == Duration{}) continue;
      rows +=
          fmt::format("<tr><td><span class=\"swatch {}\"></span>{}</td><td>{}</td><td>{:.1f} %</td></tr>\n",
                      name_of(drawn_as), state.name, readable(time), 100 * share(time, states.total()));
    }
  }
  return "<table class=\"figures\">\n<tr><th>State</th><th>Time</th><th>Share</th></tr>\n" + rows +
         "</table>\n";
}

}  // namespace contourd
