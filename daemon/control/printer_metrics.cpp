#include "daemon/control/printer_metrics.hpp"

#include <fmt/format.h>

#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/print/print_modes.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns the text escaped for a quoted label value.
std::string escaped(std::string_view text) {
  std::string value;
  for (const char c : printable(text)) {
    if (c == '\\' || c == '"') value += '\\';
    value += c;
  }
  return value;
}

// Returns all states. Each is exported, because a monitoring system cannot know a state that is left out.
std::vector<std::string_view> all_states() {
  std::vector<std::string_view> states;
  for (const PrintState& state : print_states())
    states.push_back(state.name);
  states.insert(states.end(), {"preparing", "finishing"});
  return states;
}

class Exposition {
 public:
  // Begins a metric family; the next samples belong to it. `name` comes without "contourd_"; the names of a
  // counter's samples end with "_total".
  void begin(std::string_view name, std::string_view type, std::string_view help,
             std::string_view unit = {}) {
    name_ = fmt::format("contourd_{}", name);
    suffix_ = type == "counter" ? "_total" : "";
    add("# TYPE {} {}\n", name_, type);
    if (!unit.empty()) add("# UNIT {} {}\n", name_, unit);
    add("# HELP {} {}\n", name_, help);
  }
  void sample(double value) { add("{}{} {}\n", name_, suffix_, value); }
  void sample(const std::string& labels, double value) {
    add("{}{}{{{}}} {}\n", name_, suffix_, labels, value);
  }
  // Adds a metric family with one sample.
  void gauge(std::string_view name, std::string_view help, double value) {
    begin(name, "gauge", help);
    sample(value);
  }
  std::string end() && {
    add("# EOF\n");
    return std::move(text_);
  }

 private:
  template <typename... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  std::string text_, name_, suffix_;
};

void add_print(Exposition& text, const PrinterMetrics::Print& print) {
  text.gauge("layer", "The current layer, from 1.", print.layer);
  text.gauge("layers", "The layers of the current print.", print.layers);
  text.begin("time_left_seconds", "gauge", "The time until the current print ends.", "seconds");
  text.sample(in_seconds(std::chrono::floor<std::chrono::seconds>(print.time_left)));
}

void add_state(Exposition& text, const PrinterMetrics& metrics) {
  text.begin("state", "gauge", "1 for the state that the printer is in, 0 for the others.");
  for (const std::string_view state : all_states())
    text.sample(fmt::format("state=\"{}\"", escaped(state)), state == metrics.state ? 1 : 0);
  if (metrics.print) add_print(text, *metrics.print);
  text.gauge("light_may_be_on", "1 from the light's command until it is confirmed off.",
             metrics.light_may_be_on);
  text.gauge("ready", "0 while the machine cannot print.", metrics.ready);
  text.gauge("queued_jobs", "Jobs in the queue.", static_cast<double>(metrics.queued));
  text.gauge("queue_held", "1 while the queue is held and waits for the user.", metrics.held);
  text.gauge("plate_occupied", "1 while the build plate holds a part.", metrics.plate_occupied);
}

void add_counters(Exposition& text, const PrinterMetrics& metrics) {
  text.begin("jobs", "counter", "Jobs that have ended since contourd started.");
  for (const auto& [outcome, count] : metrics.ended)
    text.sample(fmt::format("outcome=\"{}\"", escaped(outcome)), static_cast<double>(count));
  text.begin("light_seconds", "counter", "Upper bound of the light in prints since contourd started.",
             "seconds");
  text.sample(in_seconds(metrics.lit));
  text.begin("late_steps", "counter", "Motor steps that came late since contourd started.");
  text.sample(static_cast<double>(metrics.late_steps));
}

namespace fs = std::filesystem;

// The lowest priority: any other work comes first.
constexpr int kMetricsNiceness = 19;

// Replaces the file atomically. Returns the reason for a failure; empty on success.
std::string replace(const fs::path& path, const std::string& text) {
  try {
    remove_unfinished_files(path.parent_path());
    NewFile file(path.parent_path());
    file.let_all_read();
    file.write(text);
    file.replace_for_now(path.filename().string());
  } catch (const std::system_error& error) {
    return error.code().message();
  }
  return "";
}

}  // namespace

std::string as_open_metrics(const PrinterMetrics& metrics) {
  Exposition text;
  text.begin("build_info", "gauge", "The version of contourd and the name of the printer.");
  text.sample(
      fmt::format("version=\"{}\",printer=\"{}\"", escaped(CONTOURD_VERSION), escaped(metrics.printer)), 1);
  add_state(text, metrics);
  add_counters(text, metrics);
  return std::move(text).end();
}

MetricsFile::MetricsFile(EventLoop& loop, const Log& log, fs::path path, std::function<std::string()> make,
                         Duration interval)
    : loop_(loop),
      log_(log),
      path_(std::move(path)),
      make_(std::move(make)),
      interval_(interval),
      exists_(std::make_shared<bool>(false)),
      worker_(loop, "contourd-metric", kMetricsNiceness) {
  timer_ = loop_.at(std::chrono::steady_clock::now(), "the metrics' timer", [this] { update(); });
}

MetricsFile::~MetricsFile() {
  worker_.run(
      [path = path_, exists = exists_] {
        std::error_code error;
        return *exists && fs::remove(path, error);
      },
      [](bool) {});
}

void MetricsFile::update() {
  timer_ = loop_.at(std::chrono::steady_clock::now() + interval_, "the metrics' timer", [this] { update(); });
  if (writing_) return;  // the disk is slow: try at the next interval
  const std::string text = make_();
  if (text != written_) write(text);
}

void MetricsFile::write(const std::string& text) {
  writing_ = true;
  worker_.run(
      [path = path_, exists = exists_, text] {
        std::string trouble = replace(path, text);
        *exists = *exists || trouble.empty();
        return trouble;
      },
      [this, text](const std::string& trouble) {
        writing_ = false;
        if (trouble.empty()) written_ = text;
        report(trouble);
      });
}

void MetricsFile::report(const std::string& trouble) {
  if (std::exchange(trouble_, trouble) == trouble) return;
  const std::string path = printable(path_.string());
  if (trouble.empty())
    log_.info("metrics", fmt::format("{} is written again", path));
  else
    log_.warning("metrics", fmt::format("{} cannot be written and is tried again: {}", path, trouble));
}

}  // namespace contourd
