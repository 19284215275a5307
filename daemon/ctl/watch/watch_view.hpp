// The view of contourctl watch on a whole terminal, as lines. A pure function, except that it uses the
// process's time zone.
#pragma once

#include <cstddef>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace contourd::ctl {

struct ScreenSize {
  std::size_t columns = 80, rows = 24;
};

enum class Ink { Plain, Strong, Good, Warning, Alarm, Faint };

struct ScreenLine {
  std::string text;  // printable, or part of a picture with its colours; not wider than the screen
  Ink ink = Ink::Plain;
  bool operator==(const ScreenLine&) const = default;
};

// The known facts about a printer, in the format of docs/control-api.md.
struct WatchedPrinter {
  using Json = nlohmann::ordered_json;

  Json status;              // null if none has arrived yet
  Json queue;               // null if none has arrived yet
  double status_age_s = 0;  // time since the status arrived
  std::time_t now = 0;      // wall-clock time
  std::string job;          // the awaited job; empty: the current print
  bool job_is_under_way = false;
  std::string trouble;  // problem with the connection, as a sentence; empty: none
};

// Returns at most as many lines as the screen has rows. If there are too few rows, the least important lines
// are left out first.
[[nodiscard]] std::vector<ScreenLine> watch_lines(const WatchedPrinter& printer, ScreenSize size);

}  // namespace contourd::ctl
