#include "daemon/formats/model_versions.hpp"

#include <string_view>

#include "tests/catch.hpp"

using contourd::NamedSupports;
using contourd::version_name;

namespace {

NamedSupports supports_of(std::string_view path) {
  return version_name(path, ".stl").supports;
}

bool is_version_of(std::string_view a, std::string_view b) {
  return version_name(a, ".stl").model == version_name(b, ".stl").model;
}

}  // namespace

TEST_CASE("Words in folders and files tell whether a model carries supports") {
  for (const std::string_view path :
       {"Supported/a.stl", "a_sup.stl", "a-presupported.stl", "Pre-Supported/STL/a.stl", "PreSupported/a.stl",
        "a (supported).stl", "with supports/a.stl", "Supports/a.stl", "A_PS.stl", "STL Supported\\a.stl",
        "knightsupported.stl", "01_Lychee Supported/a.stl"})
    CHECK(supports_of(path) == NamedSupports::With);
  for (const std::string_view path :
       {"Unsupported/a.stl", "a_unsup.stl", "a nosup.stl", "No Supports/a.stl", "UnSupported/a.stl",
        "non-supported/a.stl", "without_supports/a.stl", "Supported/a_nosup.stl", "Unsupported/a_sup.stl",
        "knightunsupported.stl", "a nonsupported.stl", "02_Unsupported/a.stl"})
    CHECK(supports_of(path) == NamedSupports::Without);
  for (const std::string_view path :
       {"a.stl", "motor support.stl", "supper.stl", "ups.stl", "no/a.stl", "STL/a.stl"})
    CHECK(supports_of(path) == NamedSupports::Unsaid);
}

TEST_CASE("Versions of a model have the same words apart from supports and folders of formats") {
  CHECK(is_version_of("Supported/STL/Dragon_sup.stl", "un-supported/dragon.stl"));
  CHECK(is_version_of("pack/Pre-Supported/a b.stl", "pack/a_b.stl"));
  CHECK(is_version_of("01_Supported/k.stl", "02_Unsupported/k.stl"));
  CHECK(is_version_of("Lychee_Supported/k.stl", "STL_Unsupported/k.stl"));
  CHECK(is_version_of("Chitubox Supported/k.stl", "STL/k.stl"));
  CHECK(is_version_of("PRESUPPORTED/k.stl", "RAW/k.stl"));
  CHECK(is_version_of("knightsupported.stl", "knight.stl"));
  CHECK_FALSE(is_version_of("Dragon Supported/k.stl", "Knight Unsupported/k.stl"));
  CHECK_FALSE(is_version_of("1/k.stl", "2/k.stl"));
  CHECK_FALSE(is_version_of("left/arm.stl", "right/arm.stl"));
  CHECK_FALSE(is_version_of("a/bc.stl", "a b/c.stl"));
  CHECK_FALSE(is_version_of("motor.stl", "motor support.stl"));
}
