// What an owner is told of a bad file, held to be readable. Thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "daemon/json/config_error.hpp"
#include "daemon/system/printable.hpp"
#include "tests/fuzz/demand.hpp"

namespace contourd::fuzz {

// One line that a terminal takes as it is. A text of a file, which may be in it, has up to 1024 bytes.
inline void demand_sentence(const std::string& text) {
  demand(!text.empty(), "a sentence is empty");
  demand(text.size() <= 4096, "a sentence is longer than anybody reads");
  demand(printable(text) == text, "a sentence is not printable");
}

// 31 lines at most, see ConfigError.
inline void demand_told(const ConfigError& error) {
  demand(!error.violations().empty(), "a refusal without a violation");
  demand(error.violations().size() <= kMaxViolations, "more violations than are looked for");
  for (const Violation& violation : error.violations())
    demand(!violation.message.empty(), "a violation says nothing");
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
