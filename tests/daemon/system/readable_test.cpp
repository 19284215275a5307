#include "daemon/system/readable.hpp"

#include "tests/catch.hpp"

TEST_CASE("Coordinates that are rounded to zero have no sign") {
  CHECK(coordinates({-0.0, -0.004, 0.004}) == "0.00, 0.00, 0.00");
  CHECK(coordinates({-0.006, 12.3, -4.25}) == "-0.01, 12.30, -4.25");
  CHECK(coordinates({-0.04, -0.06}, 1) == "0.0, -0.1");
  CHECK(coordinates({-0.4}, 0) == "0");
}

TEST_CASE("A time for people is in the time zone of the process, with its offset") {
  ::setenv("TZ", "CET-1", 1);
  ::tzset();
  const std::chrono::system_clock::time_point noon{std::chrono::seconds{1'750'000'000}};
  CHECK(local_time(noon) == "2025-06-15 16:06:40 +0100");
  CHECK(iso_time(noon) == "2025-06-15T15:06:40Z");
  ::setenv("TZ", "UTC", 1);
  ::tzset();
  CHECK(local_time(noon) == "2025-06-15 15:06:40 +0000");
}

TEST_CASE("Durations are formatted in the units that people use") {
  CHECK(readable(0s) == "0.0 s");
  CHECK(readable(4'200ms) == "4.2 s");
  CHECK(readable(12min + 30s) == "12 min 30 s");
  CHECK(readable(12min + 5s) == "12 min 05 s");
  CHECK(readable(3h + 5min + 20s) == "3 h 05 min");
}
