#include "daemon/system/nearest_word.hpp"

#include <vector>

#include "tests/catch.hpp"

namespace {

const std::vector<std::string> kWords{"status", "submit", "queue", "move",
                                      "remove", "resume", "home",  "logs"};

}  // namespace

TEST_CASE("The nearest word has the fewest typing mistakes") {
  for (const char* const typed : {"statsu", "status", "sttus", "statuss", "stayus", "stat", "sta"})
    CHECK(nearest_word(typed, kWords) == "status");
  CHECK(nearest_word("sumbit", kWords) == "submit");
  CHECK(nearest_word("qeue", kWords) == "queue");
  CHECK(nearest_word("mvoe", kWords) == "move");
  CHECK(nearest_word("remov", kWords) == "remove");
  CHECK(nearest_word("resme", kWords) == "resume");
  CHECK(suggestion("hmoe", kWords) == "; did you mean home?");
}

TEST_CASE("A word that is far from all others has no nearest word") {
  for (const char* const typed : {"", "s", "st", "print", "eject", "\xff\xff\xff"})
    CHECK(nearest_word(typed, kWords) == std::nullopt);
  CHECK(nearest_word(std::string(1'000'000, 'a'), kWords) == std::nullopt);
  CHECK(nearest_word("status", {}) == std::nullopt);
  CHECK(suggestion("print", kWords).empty());
}
