#include "core/mask/conic_rows.hpp"

#include "tests/catch.hpp"

TEST_CASE("Centres before a number are counted up to the limit") {
  CHECK(centers_before(-3, 64) == 0);
  CHECK(centers_before(0.5, 64) == 0);
  CHECK(centers_before(std::nextafter(0.5, 1), 64) == 1);
  CHECK(centers_before(0.6, 64) == 1);
  CHECK(centers_before(1.5, 64) == 1);
  CHECK(centers_before(63.6, 64) == 64);
  CHECK(centers_before(1e9, 64) == 64);
}
