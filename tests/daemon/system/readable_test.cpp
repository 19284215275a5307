#include "daemon/system/readable.hpp"

#include "tests/catch.hpp"

TEST_CASE("Durations are formatted in the units that people use") {
  CHECK(readable(0s) == "0.0 s");
  CHECK(readable(4'200ms) == "4.2 s");
  CHECK(readable(12min + 30s) == "12 min 30 s");
  CHECK(readable(12min + 5s) == "12 min 05 s");
  CHECK(readable(3h + 5min + 20s) == "3 h 05 min");
}
