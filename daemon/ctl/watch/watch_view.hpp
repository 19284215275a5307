// What contourctl watch shows on a whole terminal, line by line. A pure function, but for the time zone,
// which is the process'.
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
  std::string text;  // printable or a picture's with its colours, and as wide as the screen at most
  Ink ink = Ink::Plain;
  bool operator==(const ScreenLine&) const = default;
};

// What is known of a printer, as docs/control-api.md has it.
struct WatchedPrinter {
  using Json = nlohmann::ordered_json;

  Json status;              // null as long as none has come
  Json queue;               // the same
  double status_age_s = 0;  // how long ago the status came
  std::time_t now = 0;      // the wall clock
  std::string job;          // the one that is waited for; empty: whichever is printed
  bool job_is_under_way = false;
  std::string trouble;  // with the connection, in a sentence; empty: none
};

// As many lines as the screen has rows at most: where that is too few, what matters least is left out first.
[[nodiscard]] std::vector<ScreenLine> watch_lines(const WatchedPrinter& printer, ScreenSize size);

}  // namespace contourd::ctl
