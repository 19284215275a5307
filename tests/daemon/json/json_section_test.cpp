#include "daemon/json/json_section.hpp"

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

// Returns a document whose key "x" has this value, without the document's normalization of numbers.
JsonDocument holding(const nlohmann::json& value) {
  JsonDocument document = JsonDocument::from_text("{}", "test.json");
  document.value()["x"] = value;
  return document;
}

template <typename T>
Complaints complaints_as_integer(const nlohmann::json& value) {
  const JsonDocument document = holding(value);
  return complaints_of([&] { (void)JsonSection(document).integer<T>("x"); });
}

TEST_CASE("an integer is read only from a whole number that the type can hold") {
  CHECK(JsonSection(holding(-3)).integer<int>("x") == -3);
  CHECK(complaints_as_integer<unsigned>(-3) == Complaints{"/x: -3 is out of range"});
  CHECK(complaints_as_integer<unsigned>(-3.7) == Complaints{"/x: expected a whole number"});
  CHECK(complaints_as_integer<int>(true) == Complaints{"/x: expected a whole number"});
  CHECK(complaints_as_integer<int>("3") == Complaints{"/x: expected a whole number"});
  CHECK(complaints_as_integer<int>(nullptr) == Complaints{"/x: expected a whole number"});
  CHECK(complaints_as_integer<int>(std::int64_t{1} << 31) == Complaints{"/x: 2147483648 is out of range"});
  CHECK(complaints_as_integer<std::int64_t>(UINT64_MAX) ==
        Complaints{"/x: 18446744073709551615 is out of range"});
}

TEST_CASE("a list of texts is read only from texts") {
  CHECK(JsonSection(holding({"a", "b"})).texts("x") == std::vector<std::string>{"a", "b"});
  CHECK(JsonSection(holding(nlohmann::json::array())).texts("x").empty());
  const auto complaints = [](const nlohmann::json& value) {
    const JsonDocument document = holding(value);
    return complaints_of([&] { (void)JsonSection(document).texts("x"); });
  };
  CHECK(complaints("a") == Complaints{"/x: expected a list"});
  CHECK(complaints({"a", 1}) == Complaints{"/x: expected a list of texts"});
}

TEST_CASE("a read of the wrong type or of a missing key throws with the place") {
  const JsonDocument document = JsonDocument::from_text(R"({"a": {"b": true, "c": 1}})", "test.json");
  const JsonSection a = JsonSection(document).section("a");
  CHECK(complaints_of([&] { (void)a.number("b"); }) == Complaints{"/a/b: expected a number"});
  CHECK(complaints_of([&] { (void)a.boolean("c"); }) == Complaints{"/a/c: expected true or false"});
  CHECK(complaints_of([&] { (void)a.text("c"); }) == Complaints{"/a/c: expected a text"});
  CHECK(complaints_of([&] { (void)a.section("c"); }) == Complaints{"/a/c: expected an object"});
  CHECK(complaints_of([&] { (void)a.number("d"); }) == Complaints{"/a/d: this key is missing"});
}

TEST_CASE("lengths and durations take their unit from the key and are rounded to the nearest") {
  const JsonDocument document = JsonDocument::from_text(
      R"({"a_mm": 0.0025, "a_um": 2.5004, "a_ms": 0.5, "a_s": 16.6666667,
          "huge_mm": 1e200, "huge_s": 1e200, "a": 1})",
      "test.json");
  const JsonSection root(document);
  CHECK(root.length("a_mm") == Nanometers{2500});
  CHECK(root.length("a_um") == Nanometers{2500});
  CHECK(root.duration("a_ms") == std::chrono::microseconds{500});
  CHECK(root.duration("a_s") == Duration{16'666'666'700});
  CHECK(complaints_of([&] { (void)root.length("huge_mm"); }) ==
        Complaints{"/huge_mm: this length is out of range"});
  CHECK(complaints_of([&] { (void)root.duration("huge_s"); }) ==
        Complaints{"/huge_s: this duration is out of range"});
  CHECK(testing::contract_broken_by([&] { (void)root.length("a"); }) == "the key ends in a length's unit");
  CHECK(testing::contract_broken_by([&] { (void)root.duration("a"); }) ==
        "the key ends in a duration's unit");
}

TEST_CASE("the lengths and durations of a list take their unit from the list's key") {
  const JsonDocument document = JsonDocument::from_text(
      R"({"a_mm": [0.0025, 3], "a_ms": [0.5, 0], "none_ms": [], "odd_ms": [1, "2"], "a": [1], "one_ms": 1,
          "huge_mm": [1, 1e200]})",
      "test.json");
  const JsonSection root(document);
  CHECK(root.lengths("a_mm") == std::vector{Nanometers{2500}, Nanometers{3'000'000}});
  CHECK(root.durations("a_ms") == std::vector{Duration{500'000}, Duration{0}});
  CHECK(root.durations("none_ms").empty());
  CHECK(complaints_of([&] { (void)root.durations("odd_ms"); }) == Complaints{"/odd_ms: expected numbers"});
  CHECK(complaints_of([&] { (void)root.durations("one_ms"); }) == Complaints{"/one_ms: expected a list"});
  CHECK(complaints_of([&] { (void)root.lengths("huge_mm"); }) ==
        Complaints{"/huge_mm: this length is out of range"});
  CHECK(testing::contract_broken_by([&] { (void)root.lengths("a"); }) == "the key ends in a length's unit");
  CHECK(testing::contract_broken_by([&] { (void)root.durations("a"); }) ==
        "the key ends in a duration's unit");
}

}  // namespace
}  // namespace contourd
