#include "daemon/ctl/watch/watch_view.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = WatchedPrinter::Json;

// Importance of lines, the most important first: if there are too few rows, lines of the last rank go first.
enum Rank {
  kHow,
  kTrouble,
  kLight,
  kStopped,
  kPhase,
  kTime,
  kLayer,
  kName,
  kNext,
  kWarning,
  kWait,
  kQueueBlock,
  kResin,
  kByHand,
  kLast,
  kReminder,
  kUnprinted,
  kHeader,
  kBlank
};

constexpr std::size_t kLabelColumns = 10, kNarrow = 30;
constexpr std::size_t kMostListed = 50;

struct Block {
  Rank rank;
  std::vector<ScreenLine> lines;
};

std::optional<double> number_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

const Json& part_of(const Json& object, const char* key) {
  static const Json kNone;
  const auto found = object.find(key);
  return found != object.end() ? *found : kNone;
}

// Returns the time in whole seconds, for a countdown.
std::string countdown(double seconds) {
  const auto whole = std::chrono::seconds{std::llround(std::ceil(std::clamp(seconds, 0.0, 1e9)))};
  return whole < std::chrono::minutes{1} ? fmt::format("{} s", whole.count()) : readable(whole);
}

// Returns "14:05", with the date if it is not today.
std::string local_time(std::time_t time, std::time_t now) {
  std::tm then{}, today{};
  if (::localtime_r(&time, &then) == nullptr || ::localtime_r(&now, &today) == nullptr) return "?";
  if (then.tm_yday == today.tm_yday && then.tm_year == today.tm_year) return fmt::format("{:%H:%M}", then);
  return fmt::format("{:%a %d %b, %H:%M}", then);
}

bool is_waiting(std::string_view state) {
  return state == "paused" || state == "held" || state == "raising";
}

// Returns the usual state after this one, or an empty text if there is none.
std::string next_state(std::string_view state, std::int64_t layer, std::int64_t layers) {
  using Step = std::pair<std::string_view, std::string_view>;
  constexpr auto kSteps = std::to_array<Step>({{"preparing", "warming up"},
                                               {"warming up", "homing"},
                                               {"homing", "the first layer"},
                                               {"lowering", "settling"},
                                               {"settling", "exposing"},
                                               {"showing", "exposing"},
                                               {"igniting", "exposing"},
                                               {"exposing", "resting"},
                                               {"rising", "lifting"},
                                               {"darkening", "resting"},
                                               {"extinguishing", "resting"},
                                               {"interrupting", "lifting"},
                                               {"resting", "lifting"},
                                               {"braking", "lifting"},
                                               {"raising", "a pause"},
                                               {"halting", "parking"},
                                               {"parking", "the report"},
                                               {"ending", "the report"}});
  if (state == "lifting") return layer < layers ? fmt::format("layer {}", layer + 1) : "parking";
  const auto* const step = std::ranges::find(kSteps, state, &Step::first);
  return step != kSteps.end() ? std::string(step->second) : "";
}

class View {
 public:
  View(const WatchedPrinter& printer, ScreenSize size)
      : printer_(printer), status_(printer.status), job_(part_of(printer.status, "job")), size_(size) {}

  std::vector<ScreenLine> lines() {
    add_header();
    if (!printer_.trouble.empty()) add("contourd", printable(printer_.trouble), kTrouble, Ink::Alarm);
    if (status_.is_object()) {
      add_wanted_job();
      job_.is_object() ? add_job() : add_idle();
      add_waits();
      add_queue();
      add_files();
    }
    return chosen();
  }

 private:
  [[nodiscard]] std::string state() const { return text_of(status_, "state"); }

  void add_line(const std::string& text, Rank rank, Ink ink) {
    blocks_.push_back({rank, {{cut_to_columns(text, size_.columns), ink}}});
  }

  // Adds a label and its text, which is wrapped next to the label.
  void add(std::string_view label, const std::string& text, Rank rank, Ink ink = Ink::Plain) {
    Block block{rank, {}};
    if (size_.columns < kNarrow) {
      for (std::string& line : wrapped(fmt::format("{} {}", label, text), size_.columns))
        block.lines.push_back({std::move(line), ink});
    } else {
      for (const std::string& line : wrapped(text, size_.columns - kLabelColumns))
        block.lines.push_back(
            {fmt::format("{:<{}}{}", block.lines.empty() ? label : "", kLabelColumns, line), ink});
    }
    blocks_.push_back(std::move(block));
  }

  // Adds a line for each text in the list.
  void add_each(std::string_view label, const Json& list, Rank rank, Ink ink, std::string_view more = "") {
    for (const Json& each : list)
      if (each.is_string()) add(label, printable(each.get<std::string>()).append(more), rank, ink);
  }

  void add_if(std::string_view label, const std::string& text, Rank rank, Ink ink = Ink::Plain) {
    if (!text.empty()) add(label, text, rank, ink);
  }

  void add_blank() { blocks_.push_back({kBlank, {{"", Ink::Plain}}}); }

  void add_header() {
    const std::string name = status_.is_object() ? text_of(status_, "printer") : "contourd";
    std::tm local{};
    (void)::localtime_r(&printer_.now, &local);
    const std::string time = fmt::format("{:%H:%M:%S}", local);
    const std::size_t taken = time.size() + 2;
    if (size_.columns < taken + 6) return add_line(name, kHeader, Ink::Faint);
    std::string line = cut_to_columns(name, size_.columns - taken);
    line.append(size_.columns - columns_of(line) - time.size(), ' ').append(time);
    add_line(line, kHeader, Ink::Faint);
    add_blank();
  }

  void add_wanted_job() {
    if (printer_.job.empty() || printer_.job_is_under_way) return;
    add_line(printable(printer_.job) + " waits", kName, Ink::Strong);
  }

  // --- During a print

  void add_job() {
    add_line(text_of(job_, "name"), kName, Ink::Strong);
    if (job_.contains("layer")) {
      add_bar();
      add_phase();
      add_light();
      add_time();
      add_figures();
    } else {
      add("phase", state(), kHow);
      add_light();
    }
    add_next();
    add_stops();
    add_analysis();
  }

  void add_bar() {
    const double layers = std::fmax(number_of(job_, "layers").value_or(1), 1);
    const double part = std::clamp(number_of(job_, "layers_done").value_or(0) / layers, 0.0, 1.0);
    const std::string percent = fmt::format("{:.0f} %", std::floor(part * 100));
    constexpr std::size_t kAround = 8, kNarrowestBar = 6;  // "[", "] " and "100 %"
    if (size_.columns < kAround + kNarrowestBar) return add_line(percent, kHow, Ink::Good);
    std::string bar(size_.columns - kAround, '.');
    std::fill_n(bar.begin(), static_cast<std::size_t>(part * static_cast<double>(bar.size())), '#');
    add_line(fmt::format("[{}] {:>5}", bar, percent), kHow, Ink::Good);
  }

  void add_phase() {
    std::string text = state();
    const auto left = number_of(job_, "state_left_s");
    if (left && printer_.trouble.empty())
      text += fmt::format(", {} left", countdown(*left - printer_.status_age_s));
    add("phase", text, kPhase);
  }

  void add_light() {
    if (!printer_.trouble.empty()) return add("light", "unknown", kLight, Ink::Alarm);
    const bool dark = status_.value("dark", false);
    const std::string by_hand = text_of(part_of(status_, "manual"), "state");
    if (dark) return add("light", "off", kLight);
    if (state() == "exposing" || state() == "rising" || by_hand == "lit")
      return add("light", "ON", kLight, Ink::Alarm);
    if (state() == "igniting" || by_hand == "igniting") return add("light", "turning on", kLight, Ink::Alarm);
    add("light", "not confirmed off", kLight, Ink::Alarm);
  }

  void add_time() {
    // As in contourd, the time by which a state exceeds its expected duration does not count.
    const double counted = std::min(printer_.status_age_s, number_of(job_, "state_left_s").value_or(0));
    const double left = std::max(number_of(job_, "time_left_s").value_or(0) - counted, 0.0);
    if (is_waiting(state()))
      return add("time left", countdown(left) + " of printing, once it continues", kTime);
    if (!printer_.trouble.empty()) return;
    const std::time_t end = printer_.now + static_cast<std::time_t>(std::clamp(left, 0.0, 1e9));
    add("time left", fmt::format("{}, until {}", countdown(left), local_time(end, printer_.now)), kTime);
  }

  void add_figures() {
    add("layer",
        fmt::format("{} of {}, {:.6g} um", job_.value("layer", 0), job_.value("layers", 0),
                    job_.value("layer_height_um", 0.0)),
        kLayer);
    add("height",
        fmt::format("{:.3f} of {:.3f} mm", job_.value("height_mm", 0.0), job_.value("total_height_mm", 0.0)),
        kLayer);
  }

  void add_next() {
    std::string next = next_state(state(), job_.value("layer", 0), job_.value("layers", 0));
    const auto append = [&next](const std::string& what) {
      if (!what.empty()) next += (next.empty() ? "" : "; ") + what;
    };
    for (const char* pause : {"pause", "planned_pause"})
      if (const std::string when = text_of(job_, pause); !when.empty()) append("a pause " + when);
    const Json& queue = part_of(printer_.queue, "queue");
    if (queue.is_array() && !queue.empty() && queue.front().is_string())
      append((next.empty() ? "" : "then ") + printable(queue.front().get<std::string>()));
    add_if("next", next, kNext);
  }

  void add_stops() {
    add_if("stopped", text_of(job_, "interruption"), kStopped, Ink::Warning);
    add_each("warning", part_of(job_, "warnings"), kWarning, Ink::Warning);
    if (state() == "paused") add("", "continue with: contourctl resume", kStopped, Ink::Strong);
  }

  void add_analysis() {
    const Json& analysis = part_of(job_, "analysis");
    if (!analysis.is_object()) return;
    add("resin", fmt::format("{:.2f} ml", analysis.value("resin_ml", 0.0)), kResin);
    add_each("warning", part_of(analysis, "warnings"), kWarning, Ink::Warning);
  }

  // --- Without a print

  void add_idle() {
    add_line(state(), kHow, Ink::Strong);
    add_light();
    const std::string occupant = text_of(status_, "plate_job");
    add("plate", text_of(status_, "plate") + (occupant.empty() ? "" : " by " + occupant), kWait);
    const Json& last = part_of(status_, "last");
    if (last.is_object()) {
      const std::string reason = text_of(last, "reason"), outcome = text_of(last, "outcome");
      add("last job",
          fmt::format("{}: {}{}", text_of(last, "job"), outcome, reason.empty() ? "" : ": " + reason), kLast,
          outcome == "done" ? Ink::Plain : Ink::Warning);
    }
    add_each("reminder", part_of(status_, "reminders"), kReminder, Ink::Warning);
    add_manual();
  }

  void add_manual() {
    const Json& manual = part_of(status_, "manual");
    if (!manual.is_object()) return;
    std::string text = text_of(manual, "state");
    if (const auto height = number_of(manual, "height_mm"))
      text += fmt::format(", plate at {:.3f} mm", *height);
    if (const std::string picture = text_of(manual, "picture"); !picture.empty())
      text += ", screen: " + picture;
    if (text != "idle") add("by hand", text, kByHand);
    add_if("by hand", text_of(manual, "problem"), kByHand, Ink::Warning);
  }

  // --- Always

  void add_waits() {
    const std::string held = text_of(status_, "held"), waiting = text_of(status_, "waiting_for");
    const std::string not_ready_reason = text_of(status_, "not_ready_reason");
    add_if("machine", not_ready_reason, kStopped, Ink::Warning);
    if (held != not_ready_reason) add_if("held", held, kStopped, Ink::Warning);
    const Json& unaccepted = part_of(status_, "unaccepted");
    const bool is_question = std::ranges::find(unaccepted, Json(waiting)) != unaccepted.end();
    if (waiting != held && waiting != not_ready_reason && !is_question)
      add_if("waiting", waiting, kWait, Ink::Warning);
  }

  void add_queue() {
    const auto queued = status_.value("queued", std::size_t{0});
    add_blank();
    add("queue", queued == 0 ? "empty" : count_of(queued, "job", "jobs"), kQueueBlock);
    Block names{kQueueBlock, {}};
    const Json& queue = part_of(printer_.queue, "queue");
    for (std::size_t i = 0; i < std::min(queue.size(), kMostListed); ++i) {
      if (!queue[i].is_string()) continue;
      const std::string name = fmt::format("{:>4}  {}", i + 1, printable(queue[i].get<std::string>()));
      names.lines.push_back({cut_to_columns(name, size_.columns), Ink::Plain});
    }
    if (!names.lines.empty()) blocks_.push_back(std::move(names));
    add_each("arriving", part_of(printer_.queue, "arriving"), kUnprinted, Ink::Plain);
  }

  void add_files() {
    for (const auto& [what, name] : {std::pair("unaccepted", "accept"), std::pair("postponed", "postponed"),
                                     std::pair("ignored", "ignored")}) {
      for (const auto& [file, why] : part_of(status_, what).items())
        if (why.is_string())
          add(name, fmt::format("{}: {}", printable(file), printable(why.get<std::string>())), kUnprinted,
              Ink::Warning);
    }
    for (const auto& [plate, files] : part_of(status_, "incomplete").items())
      add("unprinted",
          fmt::format("{}: waits for {}", printable(plate), count_of(files.size(), "file", "files")),
          kUnprinted, Ink::Warning);
    add_each("deletable", part_of(status_, "deletable"), kUnprinted, Ink::Warning,
             ": it is finished, but cannot be moved away");
  }

  // Returns the lines that fit on the screen.
  std::vector<ScreenLine> chosen() {
    std::size_t count = 0;
    for (const Block& block : blocks_)
      count += block.lines.size();
    while (count > size_.rows) {
      // Among blocks of equal rank, the last one loses lines first.
      const auto least = std::max_element(blocks_.rbegin(), blocks_.rend(),
                                          [](const Block& a, const Block& b) { return a.rank < b.rank; });
      least->lines.pop_back();
      --count;
      if (least->lines.empty()) blocks_.erase(std::next(least).base());
    }
    std::vector<ScreenLine> lines;
    for (Block& block : blocks_)
      std::ranges::move(block.lines, std::back_inserter(lines));
    return lines;
  }

  const WatchedPrinter& printer_;
  const Json& status_;
  const Json& job_;
  ScreenSize size_;
  std::vector<Block> blocks_;
};

}  // namespace

std::vector<ScreenLine> watch_lines(const WatchedPrinter& printer, ScreenSize size) {
  return View(printer, size).lines();
}

}  // namespace contourd::ctl
