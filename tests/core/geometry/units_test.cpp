#include "core/geometry/units.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

template <typename A, typename B>
concept Addable = requires(A a, B b) {
  a + b;
};
template <typename A, typename B>
concept Comparable = requires(A a, B b) {
  a < b;
};

}  // namespace

TEST_CASE("A unit mix-up does not compile") {
  CHECK(Addable<Nanometers, Nanometers>);
  CHECK_FALSE(Addable<Nanometers, Millimeters>);
  CHECK_FALSE(Addable<Millimeters, Micrometers>);
  CHECK_FALSE(Addable<Pixels, int>);
  CHECK_FALSE(Comparable<Millimeters, Micrometers>);
  CHECK_FALSE(std::is_convertible_v<std::int64_t, Nanometers>);
  CHECK_FALSE(std::is_convertible_v<Nanometers, std::int64_t>);
  CHECK_FALSE(std::is_convertible_v<Millimeters, Micrometers>);
}

TEST_CASE("Quantities add, scale and compare like their counts") {
  Nanometers height{2500};
  height += Nanometers{100};
  height -= Nanometers{1};
  CHECK(height == Nanometers{2599});
  CHECK(-height == Nanometers{-2599});
  CHECK(Nanometers{7} - Nanometers{9} == Nanometers{-2});
  CHECK(Nanometers{7} * std::int64_t{3} == std::int64_t{3} * Nanometers{7});
  CHECK(Nanometers{7} / std::int64_t{2} == Nanometers{3});
  CHECK(Nanometers{21} / Nanometers{7} == 3);
  CHECK(Nanometers{1} < Nanometers{2});
  CHECK(Nanometers{} == Nanometers{0});
}

TEST_CASE("Lengths convert to millimetres by their unit's size") {
  CHECK(to_millimeters(Nanometers{2'500'000}) == Millimeters{2.5});
  CHECK(to_millimeters(Nanometers{-1}) == Millimeters{-1e-6});
  CHECK(to_millimeters(Micrometers{50.0}) == Millimeters{0.05});
}

TEST_CASE("Millimetres round to the nearest nanometre, halves away from zero") {
  CHECK(to_nanometers(Millimeters{0.0025}) == Nanometers{2500});
  CHECK(to_nanometers(Millimeters{1.4e-6}) == Nanometers{1});
  CHECK(to_nanometers(Millimeters{1.6e-6}) == Nanometers{2});
  CHECK(to_nanometers(Millimeters{-1.6e-6}) == Nanometers{-2});
  CHECK(to_nanometers(Millimeters{0.5e-6}) == Nanometers{1});
}

TEST_CASE("A length beyond the range of nanometres is not converted") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK(to_nanometers(Millimeters{9e12}) == Nanometers{9'000'000'000'000'000'000});
  CHECK(to_nanometers(Millimeters{-9e12}) == Nanometers{-9'000'000'000'000'000'000});
  for (const double beyond :
       {9.0001e12, -9.0001e12, 1e300, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    CAPTURE(beyond);
    CHECK_FALSE(to_nanometers(Millimeters{beyond}).has_value());
  }
}

TEST_CASE("Every height of a machine survives conversion to millimetres and back") {
  CHECK(rc::check([] {
    // A kilometre: far within a double's 53 bits, so that the two roundings stay below half a nanometre.
    const Nanometers height{testing::draw(-1'000'000'000'000, 1'000'000'000'000)};
    RC_ASSERT(to_nanometers(to_millimeters(height)) == height);
  }));
}
