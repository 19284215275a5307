// Demands that messages about a bad file are readable. Thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "tests/fuzz/demand.hpp"

namespace contourd::fuzz {

// Demands one line that a terminal shows unchanged. It may quote a text from the file of up to 1024 bytes.
inline void demand_sentence(const std::string& text) {
  demand(!text.empty(), "a sentence is empty");
  demand(text.size() <= 4096, "a sentence is too long to be read");
  demand(printable(text) == text, "a sentence is not printable");
}

// Demands a refusal of at most 31 readable lines, see ConfigError.
inline void demand_told(const ConfigError& error) {
  demand(!error.violations().empty(), "a refusal has no violation");
  demand(error.violations().size() <= kMaxViolations, "a refusal has more than kMaxViolations");
  for (const Violation& violation : error.violations())
    demand(!violation.message.empty(), "a violation has no message");
  const std::string what = error.what();
  demand(printable_lines(what) == what, "a refusal is not printable");
  demand(std::ranges::count(what, '\n') <= 30, "a refusal has too many lines");
  for (std::size_t begin = 0; begin <= what.size();) {
    const std::size_t end = std::min(what.find('\n', begin), what.size());
    demand_sentence(what.substr(begin, end - begin));
    begin = end + 1;
  }
}

}  // namespace contourd::fuzz
