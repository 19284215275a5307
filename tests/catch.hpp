// The beginning of every test: Catch2 of either major version (Debian 12 has 2, Debian 13 has 3), the
// standard library's most frequent headers, and the names of contourd. Only sources of tests include it.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace contourd::testing {
// Returns a complaint about the first of `words` that is not in the text; empty if all are.
inline std::string lacking(const std::string& text, std::initializer_list<std::string> words) {
  for (const std::string& word : words) {
    if (text.find(word) == std::string::npos) return "no \"" + word + "\" in \"" + text + "\"";
  }
  return {};
}
}  // namespace contourd::testing
using namespace contourd;
using namespace contourd::testing;
using namespace std::chrono_literals;

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
namespace contourd::testing {
using Catch::Approx;
}
#else
#include <catch2/catch.hpp>
namespace contourd::testing {
using Catch::Detail::Approx;
}
#endif
