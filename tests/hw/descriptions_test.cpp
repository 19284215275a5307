#include "hw/z_axis.hpp"
#include "tests/catch.hpp"

TEST_CASE("Every outcome of the axis has a description of its own") {
  std::set<std::string_view> words(kNames<HomingResult>.begin(), kNames<HomingResult>.end());
  words.insert(kNames<MoveResult>.begin(), kNames<MoveResult>.end());
  CHECK(words.size() == kNames<HomingResult>.size() + kNames<MoveResult>.size());
}
