#include "daemon/control/printer_metrics.hpp"

#include "tests/catch.hpp"

namespace {

PrinterMetrics idle_printer() {
  return {.printer = "p",
          .state = "idle",
          .print = {},
          .light_may_be_on = false,
          .ready = true,
          .held = false,
          .plate_occupied = false,
          .queued = 0,
          .ended = {},
          .lit = {},
          .late_steps = 0};
}

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

}  // namespace

TEST_CASE("The metrics of a running print contain its layer, its light and its time") {
  PrinterMetrics metrics = idle_printer();
  metrics.state = "exposing";
  metrics.print = {7, 120, 90'700ms};
  metrics.light_may_be_on = true;
  metrics.queued = 3;
  metrics.ended = {{"done", 12}, {"failed", 1}};
  metrics.lit = 1234'500ms;
  metrics.late_steps = 9;
  const std::string text = as_open_metrics(metrics);
  CHECK(has_line(text, "contourd_state{state=\"exposing\"} 1"));
  CHECK(has_line(text, "contourd_state{state=\"idle\"} 0"));
  CHECK(has_line(text, "contourd_layer 7"));
  CHECK(has_line(text, "contourd_layers 120"));
  CHECK(has_line(text, "contourd_time_left_seconds 90"));
  CHECK(has_line(text, "contourd_light_may_be_on 1"));
  CHECK(has_line(text, "contourd_queued_jobs 3"));
  CHECK(has_line(text, "contourd_jobs_total{outcome=\"done\"} 12"));
  CHECK(has_line(text, "contourd_light_seconds_total 1234.5"));
  CHECK(has_line(text, "contourd_late_steps_total 9"));
  CHECK(text.ends_with("\n# EOF\n"));
}

TEST_CASE("Without a print there are no metrics of a print") {
  const std::string text = as_open_metrics(idle_printer());
  CHECK(text.find("contourd_layer") == std::string::npos);
  CHECK(text.find("time_left") == std::string::npos);
  CHECK(has_line(text, "contourd_state{state=\"idle\"} 1"));
}

TEST_CASE("Any printer's name is escaped, so that it ends neither a label nor a line") {
  PrinterMetrics metrics = idle_printer();
  metrics.printer = "a\"} 7\nb\\c\xff";
  const std::string text = as_open_metrics(metrics);
  CHECK(text.find("printer=\"a\\\"} 7?b\\\\c\xef\xbf\xbd\"} 1\n") != std::string::npos);
}
