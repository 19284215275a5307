#include "daemon/ctl/progress_view.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cwchar>

#include "daemon/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = ProgressView::Json;

constexpr std::size_t kWidestBar = 30, kNarrowestBar = 5;
constexpr std::size_t kUsualColumns = 80;

std::size_t terminal_columns() {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsualColumns;
  return size.ws_col;
}

// Calls `take` with each character and the columns that it takes, until that says no.
template <typename Take>
void for_each_character(const std::string& text, const Take& take) {
  std::mbstate_t state{};
  for (std::size_t at = 0; at < text.size();) {
    wchar_t character = 0;
    const std::size_t read = std::mbrtowc(&character, text.data() + at, text.size() - at, &state);
    const bool is_one = read > 0 && read <= text.size() - at;  // else it says that it is none
    const std::size_t bytes = is_one ? read : 1;
    const int columns = is_one ? ::wcwidth(character) : 1;
    if (!take(at, bytes, static_cast<std::size_t>(std::max(columns, 0)))) return;
    if (!is_one) state = {};
    at += bytes;
  }
}

std::size_t columns_of(const std::string& text) {
  std::size_t all = 0;
  for_each_character(text, [&all](std::size_t, std::size_t, std::size_t columns) {
    all += columns;
    return true;
  });
  return all;
}

std::string cut(const std::string& text, std::size_t columns) {
  std::size_t end = 0, used = 0;
  for_each_character(text, [&](std::size_t at, std::size_t bytes, std::size_t more) {
    if (used + more > columns) return false;
    used += more;
    end = at + bytes;
    return true;
  });
  return text.substr(0, end);
}

}  // namespace

// Names are UTF-8, whatever the user's locale says.
ProgressView::ProgressView() : terminal_(::isatty(STDOUT_FILENO) != 0) {
  (void)std::setlocale(LC_CTYPE, "C.UTF-8");
}

void ProgressView::show(const Json& status) {
  if (!status["job"].is_object()) return;
  const Json& job = status["job"];
  show_warnings(job);
  const std::string name = printable(job.value("name", "")), state = printable(status.value("state", ""));
  if (!job.contains("layer")) return draw(fmt::format("{}: {}", name, state), state);
  const std::size_t columns = terminal_ ? terminal_columns() : std::string::npos;
  const double part = job.value("layers_done", 0) / std::fmax(job.value("layers", 1), 1);
  draw(bar_of(job, state, columns), std::to_string(static_cast<int>(part * 10)));
}

std::string ProgressView::bar_of(const Json& job, const std::string& state, std::size_t columns) {
  const double part = job.value("layers_done", 0) / std::fmax(job.value("layers", 1), 1);
  const std::string name = printable(job.value("name", ""));
  const std::string figures = fmt::format(
      "{:3.0f} %  layer {}/{}  {:.2f} mm  {} left  {}", std::floor(part * 100), job.value("layer", 0),
      job.value("layers", 0), job.value("height_mm", 0.0), time_left(job),
      job["interruption"].is_string() ? state + ", " + printable(job["interruption"].get<std::string>())
                                      : state);
  constexpr std::size_t kAround = 4;  // " [" and "] ", and a column is left free
  const std::size_t taken = columns_of(name) + columns_of(figures) + kAround + 1;
  if (columns < taken + kNarrowestBar) return name + " " + figures;
  std::string bar(std::min(kWidestBar, columns - taken), '.');
  std::fill_n(bar.begin(), static_cast<std::size_t>(part * static_cast<double>(bar.size())), '#');
  return fmt::format("{} [{}] {}", name, bar, figures);
}

void ProgressView::show_job(const Json& status, const std::string& name, bool is_under_way) {
  if (is_under_way) return show(status);
  std::string text = printable(name) + ": waits";
  if (status["job"].is_object()) {
    text += fmt::format(" while {} is printed", printable(status["job"].value("name", "")));
  } else if (status["waiting_for"].is_string()) {
    text += ": " + printable(status["waiting_for"].get<std::string>());
  }
  draw(text, text);
}

void ProgressView::end() {
  if (terminal_ && drawn_) fmt::print("\n");
}

void ProgressView::show_warnings(const Json& job) {
  if (!job.contains("analysis") || !job["analysis"].is_object()) return;
  const std::string name = job.value("name", "");
  for (const Json& each : job["analysis"]["warnings"]) {
    const std::string warning = printable(each.get<std::string>());
    if (!warned_.insert(fmt::format("{}\n{}", name, warning)).second) continue;
    fmt::print("{}{}: warning: {}\n", terminal_ ? "\r\x1B[K" : "", printable(name), warning);
  }
}

// A line that fills the last column, or more, would stay where it is and the next be drawn below it.
void ProgressView::draw(const std::string& text, const std::string& step) {
  if (terminal_) {
    fmt::print("\r\x1B[K{}", cut(text, terminal_columns() - 1));
  } else if (step != last_step_) {
    fmt::print("{}\n", text);
  }
  std::fflush(stdout);
  last_step_ = step;
  drawn_ = true;
}

}  // namespace contourd::ctl
