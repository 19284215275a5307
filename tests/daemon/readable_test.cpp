#include "daemon/readable.hpp"

#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

TEST_CASE("Durations read as a person says them") {
  CHECK(readable(0s) == "0.0 s");
  CHECK(readable(4'200ms) == "4.2 s");
  CHECK(readable(12min + 30s) == "12 min 30 s");
  CHECK(readable(12min + 5s) == "12 min 05 s");
  CHECK(readable(3h + 5min + 20s) == "3 h 05 min");
}

TEST_CASE("Text from a file name is one line of valid UTF-8") {
  CHECK(printable("plain.stl") == "plain.stl");
  CHECK(printable("Ger\xC3\xA4t") == "Ger\xC3\xA4t");
  CHECK(printable("two\nlines\x1B[2J") == "two?lines?[2J");
  CHECK(printable("bad\xFF") == "bad\xEF\xBF\xBD");
}

TEST_CASE("What is too long is cut at a character, and how much is left out is said") {
  CHECK(shortened("short", 5) == "short");
  CHECK(shortened("longer", 5) == "longe... (1 bytes more)");
  CHECK(shortened("Ger\xC3\xA4t", 4) == "Ger... (3 bytes more)");
  CHECK(shortened("", 0).empty());
}
