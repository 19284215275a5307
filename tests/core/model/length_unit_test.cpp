#include "core/model/length_unit.hpp"

#include "tests/catch.hpp"

using namespace contourd;

TEST_CASE("A unit is found by its name in tickets, its plural and its abbreviations, in either case") {
  for (const LengthUnit unit : {LengthUnit::Millimeter, LengthUnit::Centimeter, LengthUnit::Meter,
                                LengthUnit::Micrometer, LengthUnit::Inch, LengthUnit::Foot}) {
    CHECK(length_unit(name_of(unit)) == unit);
    CHECK(length_unit(plural_of(unit)) == unit);
  }
  CHECK(length_unit("IN") == LengthUnit::Inch);
  CHECK(length_unit("Millimeters") == LengthUnit::Millimeter);
  CHECK(length_unit("microns") == LengthUnit::Micrometer);
  for (const char* word : {"", "i", "inche", "furlong", "mm "})
    CHECK_FALSE(length_unit(word));
}

TEST_CASE("The lengths of the units are exact") {
  CHECK(millimeters_in(LengthUnit::Inch) == 25.4);
  CHECK(millimeters_in(LengthUnit::Foot) == 304.8);
  CHECK(millimeters_in(LengthUnit::Meter) == 1000);
  CHECK(millimeters_in(LengthUnit::Centimeter) == 10);
  CHECK(millimeters_in(LengthUnit::Micrometer) == 0.001);
  CHECK(millimeters_in(LengthUnit::Millimeter) == 1);
}
