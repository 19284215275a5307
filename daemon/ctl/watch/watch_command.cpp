#include "daemon/ctl/watch/watch_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/ctl/watch/terminal_screen.hpp"
#include "daemon/ctl/watch/watch_end.hpp"
#include "daemon/ctl/watch/watch_view.hpp"
#include "daemon/ctl/watch/watched_mask.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using namespace std::chrono_literals;
using Json = DaemonConnection::Json;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kTick = 1s;           // interval of countdowns and requests
constexpr auto kQueueInterval = 5s;  // between requests of the queue's order; each status has its length
constexpr auto kFrame = 100ms;       // minimum interval between two drawings
constexpr auto kSilence = 5s;        // time without an answer after which this is reported
constexpr auto kLongestGone = 60s;
constexpr std::chrono::seconds kPatience{1};
constexpr int kMostAtOnce = 100;  // messages that are handled before the screen is drawn

// --- on a whole terminal

// The result, to be printed after the terminal was restored.
struct WatchResult {
  Json ended;                         // the ended job; null if unknown
  std::vector<std::string> warnings;  // about this job; may contain unprintable characters
};

// Collects the facts for the view and draws it. It has more members than other classes: each fact arrives at
// a different time.
class ScreenWatch {
 public:
  ScreenWatch(const ClientOptions& options, WatchEnd& end)
      : socket_(options.socket), end_(end), connection_(std::make_unique<DaemonConnection>(socket_)) {
    end_.begin(*connection_);
    end_.ask_queue(*connection_);
    printer_.job = end_.job();
  }

  std::optional<WatchResult> run(TerminalScreen& screen, std::optional<int>& signal) {
    while (true) {
      const auto now = SteadyClock::now();
      if (now >= next_frame_) draw(screen, now);
      if (now >= next_tick_) tick(now);
      const auto wake = std::min(next_tick_, changed_ ? next_frame_ : next_tick_);
      screen.wait(connection_ ? connection_->descriptor() : -1, more_ ? 0 : milliseconds_until(wake));
      if ((signal = screen.ended_by())) return std::nullopt;
      changed_ = true;
      if (!connection_) continue;
      try {
        if (auto result = receive()) return result;
        ask_for_mask();
      } catch (const DaemonError& error) {
        lost(error.what());
      }
    }
  }

 private:
  static int milliseconds_until(SteadyClock::time_point time) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(time - SteadyClock::now()).count();
    return static_cast<int>(std::clamp<decltype(left)>(left, 0, 1000));
  }

  void draw(TerminalScreen& screen, SteadyClock::time_point now) {
    if (!changed_) return;
    changed_ = false;
    next_frame_ = now + kFrame;
    printer_.now = std::time(nullptr);
    printer_.status_age_s = std::chrono::duration<double>(now - status_at_).count();
    printer_.job_is_under_way = end_.is_under_way();
    printer_.trouble = trouble(now);
    const ScreenSize size = screen.size();
    std::vector<ScreenLine> lines = watch_lines(printer_, mask_.room_for_text(size));
    add_mask(lines, size);
    screen.draw(lines);
  }

  // Adds the mask in the rows that the text leaves free, after a blank line.
  void add_mask(std::vector<ScreenLine>& lines, ScreenSize size) {
    const std::size_t used = std::min(lines.size() + 1, size.rows);
    const std::vector<ScreenLine>& mask = mask_.lines({size.columns, size.rows - used});
    if (mask.empty()) return;
    lines.emplace_back();
    lines.insert(lines.end(), mask.begin(), mask.end());
  }

  void ask_for_mask() {
    if (const std::optional<Json> question = mask_.question(SteadyClock::now()))
      connection_->send("mask", WatchedMask::kQuestion, *question);
  }

  [[nodiscard]] std::string trouble(SteadyClock::time_point now) const {
    const auto seconds = [now](SteadyClock::time_point since) {
      return std::chrono::floor<std::chrono::seconds>(now - since).count();
    };
    if (!connection_)
      return fmt::format("{}; gone for {} s, this view is out of date", why_lost_, seconds(lost_at_));
    if (asked_at_ && now - *asked_at_ > kSilence)
      return fmt::format("no answer for {} s, this view is out of date", seconds(*asked_at_));
    return "";
  }

  void tick(SteadyClock::time_point now) {
    next_tick_ = now + kTick;
    changed_ = true;
    try {
      if (!connection_) return reconnect(now);
      if (asked_at_) return;  // one request at a time
      asked_at_ = now;
      end_.ask_again(*connection_);
      if (now >= next_queue_ || queued() != queued_then_) {
        end_.ask_queue(*connection_);
        next_queue_ = now + kQueueInterval;
        queued_then_ = queued();
      }
      end_.ask_status(*connection_);
      ask_for_mask();
    } catch (const DaemonError& error) {
      lost(error.what());
    }
  }

  [[nodiscard]] std::size_t queued() const {
    return printer_.status.is_object() ? printer_.status.value("queued", std::size_t{0}) : 0;
  }

  void reconnect(SteadyClock::time_point now) {
    try {
      auto connection = std::make_unique<DaemonConnection>(socket_, kPatience);
      end_.begin(*connection);
      end_.ask_queue(*connection);
      connection_ = std::move(connection);
    } catch (const DaemonError&) {
      if (now - lost_at_ > kLongestGone) throw;
    }
  }

  void lost(const std::string& why) {
    if (!connection_) throw DaemonError(why);
    connection_.reset();
    mask_.connection_lost();
    asked_at_.reset();
    more_ = false;
    why_lost_ = why;
    lost_at_ = SteadyClock::now();
    next_tick_ = lost_at_ + kTick;
  }

  std::optional<WatchResult> receive() {
    more_ = false;
    for (int i = 0; i < kMostAtOnce; ++i) {
      const std::optional<Json> message = connection_->receive_until(SteadyClock::now());
      if (!message) return std::nullopt;
      if (auto result = take(*message)) return result;
    }
    more_ = true;
    return std::nullopt;
  }

  std::optional<WatchResult> take(const Json& message) {
    const std::optional<Json> ended = end_.take(message);
    mask_.take(message);
    if (const Json* const queue = WatchEnd::queue_in(message)) printer_.queue = *queue;
    if (ended) return WatchResult{*ended, warnings_of(ended->value("job", ""))};
    const Json* const status = WatchEnd::status_in(message);
    if (status == nullptr) return std::nullopt;
    if (WatchEnd::is_repeated(message)) asked_at_.reset();
    if ((*status)["job"].is_object()) last_job_ = (*status)["job"];
    mask_.note(*status);
    printer_.status = *status;
    status_at_ = SteadyClock::now();
    return std::nullopt;
  }

  [[nodiscard]] std::vector<std::string> warnings_of(const std::string& job) const {
    std::vector<std::string> warnings;
    if (!last_job_.is_object() || last_job_.value("name", "") != job) return warnings;
    if (!last_job_.contains("analysis") || !last_job_["analysis"].is_object()) return warnings;
    for (const Json& each : last_job_["analysis"]["warnings"])
      warnings.push_back(each.get<std::string>());
    return warnings;
  }

  std::filesystem::path socket_;
  WatchEnd& end_;
  std::unique_ptr<DaemonConnection> connection_;  // null: lost
  WatchedPrinter printer_;
  WatchedMask mask_{picture_ink()};
  Json last_job_;
  std::string why_lost_;
  SteadyClock::time_point lost_at_{}, status_at_ = SteadyClock::now();
  std::optional<SteadyClock::time_point> asked_at_;  // time of an unanswered request for the status
  std::size_t queued_then_ = 0;
  bool changed_ = true, more_ = false;
  SteadyClock::time_point next_frame_{}, next_queue_{}, next_tick_ = SteadyClock::now() + kTick;
};

// Watches on a whole terminal until the end. Throws DaemonError if contourd is gone for a minute, and
// NoSuchJob as WatchEnd does. A signal that ends a program ends the process in the usual way, after the
// terminal was restored. Returns nullopt after the key q.
std::optional<WatchResult> watch_on_screen(const ClientOptions& options, WatchEnd& end) {
  ScreenWatch watch(options, end);
  std::optional<int> signal;
  {
    TerminalScreen screen;
    std::optional<WatchResult> result = watch.run(screen, signal);
    if (result || signal == TerminalScreen::kQuit) return result;
  }
  (void)std::raise(signal.value_or(SIGTERM));
  throw DaemonError("the view was ended");
}

// --- line by line

constexpr std::size_t kBar = 30;

double part_done(const Json& job) {
  return std::clamp(job.value("layers_done", 0) / std::fmax(job.value("layers", 1), 1), 0.0, 1.0);
}

std::string line_of(const Json& job, const std::string& state) {
  const double part = part_done(job);
  std::string bar(kBar, '.');
  std::fill_n(bar.begin(), static_cast<std::size_t>(part * static_cast<double>(bar.size())), '#');
  const std::string interruption = text_of(job, "interruption");
  return fmt::format("{} [{}] {:3.0f} %  layer {}/{}  {:.2f} mm  {} left  {}{}", text_of(job, "name"), bar,
                     std::floor(part * 100), job.value("layer", 0), job.value("layers", 0),
                     job.value("height_mm", 0.0), readable_seconds(job.value("time_left_s", 0.0)), state,
                     interruption.empty() ? "" : ", " + interruption);
}

// True for states that do not occur in every layer.
bool is_worth_a_line(const std::string& state) {
  return state == "warming up" || state == "homing" || state == "paused" || state == "held" ||
         state == "parking";
}

// Returns the findings that the user has to accept for this job, or an empty text.
std::string question_of(const Json& status, const std::string& job) {
  for (const auto& [file, question] : status["unaccepted"].items())
    if (job_name_of(file) == job) return printable(question.get<std::string>());
  return "";
}

// Prints a job's progress as text: a line for each tenth of the print and for other changes. Each warning is
// printed once, in its own line.
class ProgressLines {
 public:
  // Prints lines that are due. `job`: the awaited job, which may not be printed yet; empty: any job.
  void show(const Json& status, const std::string& job, bool is_under_way) {
    if (job.empty() || is_under_way) return show_job(status);
    std::string text = printable(job) + ": waits";
    if (const std::string question = question_of(status, job); !question.empty()) {
      text += ": " + question;
    } else if (status["job"].is_object()) {
      text += fmt::format(" while {} is printed", text_of(status["job"], "name"));
    } else if (const std::string why = text_of(status, "waiting_for"); !why.empty()) {
      text += ": " + why;
    }
    print(text, text);
  }

 private:
  void show_job(const Json& status) {
    if (!status["job"].is_object()) return;
    const Json& job = status["job"];
    show_warnings(job);
    const std::string name = text_of(job, "name"), state = text_of(status, "state");
    if (!job.contains("layer")) return print(fmt::format("{}: {}", name, state), state);
    print(line_of(job, state),
          fmt::format("{} {} {}", static_cast<int>(part_done(job) * 10), is_worth_a_line(state) ? state : "",
                      text_of(job, "interruption")));
  }

  void show_warnings(const Json& job) {
    if (const auto during = job.find("warnings"); during != job.end()) show_warnings(job, *during);
    if (const auto analysis = job.find("analysis"); analysis != job.end() && analysis->is_object())
      show_warnings(job, (*analysis)["warnings"]);
  }

  void show_warnings(const Json& job, const Json& warnings) {
    const std::string name = job.value("name", "");
    for (const Json& each : warnings) {
      const std::string warning = printable(each.get<std::string>());
      if (warned_.insert(fmt::format("{}\n{}", name, warning)).second)
        fmt::print("{}: warning: {}\n", printable(name), warning);
    }
  }

  // Prints the text if `step` has changed.
  void print(const std::string& text, const std::string& step) {
    if (step != last_step_) fmt::print("{}\n", text);
    std::fflush(stdout);
    last_step_ = step;
  }

  std::string last_step_;
  std::set<std::string> warned_;  // printed warnings: job name, line break, warning
};

int print_end(const Json& ended, bool json) {
  if (!json) fmt::print("{}\n", end_of(ended));
  return ended.value("outcome", "") == "done" ? kOk : kFailed;
}

std::optional<int> watch_by_screen(const ClientOptions& options, WatchEnd& end) {
  const std::optional<WatchResult> result = watch_on_screen(options, end);
  if (!result) return std::nullopt;
  const std::string job = text_of(result->ended, "job");
  for (const std::string& warning : result->warnings)
    fmt::print("{}: warning: {}\n", job, printable(warning));
  return print_end(result->ended, false);
}

int watch_by_line(const ClientOptions& options, WatchEnd& end) {
  DaemonConnection connection(options.socket);
  end.begin(connection);
  ProgressLines lines;
  auto ask_at = std::chrono::steady_clock::now() + WatchEnd::kAskInterval;
  while (true) {
    const std::optional<Json> message = connection.receive_until(ask_at);
    if (message) {
      if (options.json && !WatchEnd::is_repeated(*message)) {
        print_json(*message);
        std::fflush(stdout);
      }
      const std::optional<Json> ended = end.take(*message);
      const Json* const status = WatchEnd::status_in(*message);
      if (status != nullptr && !ended && !options.json && end.is_known())
        lines.show(*status, end.job(), end.is_under_way());
      if (ended) return print_end(*ended, options.json);
    }
    if (std::chrono::steady_clock::now() < ask_at) continue;
    ask_at = std::chrono::steady_clock::now() + WatchEnd::kAskInterval;
    end.ask_again(connection);
  }
}

}  // namespace

std::optional<int> watch(const ClientOptions& options, const std::optional<std::string>& job) {
  WatchEnd end(job);
  try {
    const bool by_screen = !options.json && knows_sequences() && in_foreground();
    if (by_screen) return watch_by_screen(options, end);
    return watch_by_line(options, end);
  } catch (const WatchEnd::NoSuchJob& error) {
    fmt::print(stderr, "contourctl: {}\n", error.sentence);
    return kFailed;
  }
}

void add_watch(Command& program) {
  Command& command = program.add("watch", "Follow the print until it ends");
  auto& job = command.arguments<std::optional<std::string>>();
  command.option("--job", job, "Follow until this job has ended").suggests(current_jobs);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &job] { return watch(client, job).value_or(kOk); };
}

}  // namespace contourd::ctl
