#include "core/engine/compensation.hpp"

#include "tests/catch.hpp"

TEST_CASE("Without compensation nothing moves at any height") {
  for (const std::int64_t nm : {-5, 0, 1, 1'000'000'000})
    CHECK(Compensation{}.offset_at(Nanometers{nm}) == Micrometers{0});
}

TEST_CASE("Growth is the same at every height") {
  const Compensation growth{.growth = Micrometers{-35}};
  for (const std::int64_t nm : {-5, 0, 1, 1'000'000'000})
    CHECK(growth.offset_at(Nanometers{nm}) == Micrometers{-35});
}

TEST_CASE("The elephant foot is removed in full at the plate and fades to nothing at its height") {
  const Compensation foot{Micrometers{20}, Micrometers{100}, Nanometers{400'000}};
  CHECK(foot.offset_at(Nanometers{-1000}) == Micrometers{-80});
  CHECK(foot.offset_at(Nanometers{0}) == Micrometers{-80});
  CHECK(foot.offset_at(Nanometers{100'000}) == Micrometers{-55});
  CHECK(foot.offset_at(Nanometers{300'000}) == Micrometers{-5});
  CHECK(foot.offset_at(Nanometers{400'000}) == Micrometers{20});
  CHECK(foot.offset_at(Nanometers{500'000}) == Micrometers{20});
}
