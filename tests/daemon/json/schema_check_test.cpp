#include "daemon/json/schema_check.hpp"

#include "daemon/json/json_schema.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// Checks the value as it is written, without the document's normalization of numbers.
Complaints complaints_about(std::string_view schema, std::string_view value) {
  JsonDocument document = JsonDocument::from_text("{}", "test.json");
  document.value() = json::parse(value);
  check_by_schema(JsonSchema(schema).root(), document);
  return complaints_of([&] { document.throw_if_violated(); });
}

bool fits(std::string_view schema, std::string_view value) {
  return complaints_about(schema, value).empty();
}

TEST_CASE("numbers are compared exactly, however they are stored") {
  // As doubles, both are 2^53.
  CHECK_FALSE(fits(R"({"maximum": 9007199254740992})", "9007199254740993"));
  CHECK_FALSE(fits(R"({"minimum": 9007199254740993})", "9007199254740992.0"));
  CHECK(fits(R"({"maximum": 18446744073709551615})", "18446744073709551615"));
  CHECK_FALSE(fits(R"({"maximum": 18446744073709551614})", "18446744073709551615"));
  CHECK_FALSE(fits(R"({"maximum": -1})", "18446744073709551615"));
  CHECK_FALSE(fits(R"({"minimum": 0})", "-9223372036854775808"));
  CHECK(fits(R"({"maximum": 0.1})", "0.1"));
  CHECK_FALSE(fits(R"({"maximum": 1e300})", "1.1e300"));
}

TEST_CASE("a number in an enumeration matches any notation, but not a boolean") {
  CHECK(fits(R"({"enum": [1]})", "1.0"));
  CHECK(fits(R"({"enum": [{"a": [2.0]}]})", R"({"a": [2]})"));
  CHECK_FALSE(fits(R"({"enum": [1]})", "true"));
  CHECK_FALSE(fits(R"({"enum": [[false]]})", "[0]"));
  CHECK_FALSE(fits(R"({"enum": [{"a": 1}]})", R"({"b": 1})"));
  CHECK_FALSE(fits(R"({"enum": [9007199254740993]})", "9007199254740992.0"));
}

TEST_CASE("a whole number of any size is an integer, and null is a type") {
  CHECK(fits(R"({"type": "integer"})", "1e300"));
  CHECK_FALSE(fits(R"({"type": "integer"})", "1.5"));
  CHECK(fits(R"({"type": ["null", "boolean"]})", "null"));
  CHECK(complaints_about(R"({"type": ["null", "boolean"]})", "1") ==
        Complaints{"expected true or false or null, found 1"});
}

TEST_CASE(
    "a text's length is counted in characters, and a text that is too short is reported with the minimum") {
  CHECK(fits(R"({"minLength": 2, "maxLength": 2})", "\"\xF0\x9F\x92\xA9\xC3\xA4\""));
  CHECK(complaints_about(R"({"minLength": 2})", "\"\xF0\x9F\x92\xA9\"") ==
        Complaints{"\"\xF0\x9F\x92\xA9\" is 1 characters long; it must have at least 2"});
}

TEST_CASE("a value is not allowed where the schema is false") {
  CHECK(complaints_about("false", "1") == Complaints{"it is not allowed here"});
  CHECK(complaints_about(R"({"properties": {"a": false}})", R"({"a": 1, "b": 2})") ==
        Complaints{"/a: it is not allowed here"});
  CHECK(complaints_about(R"({"items": false})", "[1]") == Complaints{"/0: it is not allowed here"});
  CHECK(fits("true", "1"));
}

TEST_CASE("keys that a schema does not name may have a schema of their own") {
  constexpr std::string_view kSchema = R"({"properties": {"a": {}}, "additionalProperties": {"maximum": 3}})";
  CHECK(complaints_about(kSchema, R"({"a": 9, "b_mm": 9})") ==
        Complaints{"/b_mm: 9 is more than the limit, 3 mm"});
}

TEST_CASE(
    "a choice between sets of keys is reported with the keys, any other with the number of fitting "
    "alternatives") {
  constexpr std::string_view keys =
      R"({"oneOf": [{"required": ["a", "b"], "properties": {"c": false}},
                    {"required": ["c"], "properties": {"a": false, "b": false}}]})";
  CHECK(fits(keys, R"({"a": 1, "b": 1})"));
  CHECK(fits(keys, R"({"c": 1})"));
  CHECK(complaints_about(keys, "{}") == Complaints{"give either \"a\" and \"b\", or \"c\"; found neither"});
  CHECK(complaints_about(keys, R"({"a": 1})") ==
        Complaints{"give either \"a\" and \"b\", or \"c\"; found only \"a\""});
  CHECK(complaints_about(keys, R"({"b": 1, "c": 1})") ==
        Complaints{"give either \"a\" and \"b\", or \"c\"; found \"b\" and \"c\""});
  constexpr std::string_view kValues = R"({"oneOf": [{"type": "integer"}, {"minimum": 2}]})";
  CHECK(fits(kValues, "1"));
  CHECK(complaints_about(kValues, "3") ==
        Complaints{"it must fit exactly one of the schema's 2 alternatives; it fits 2"});
}

TEST_CASE("a schema that refers to itself checks the deepest document that is read") {
  constexpr std::string_view schema =
      R"({"properties": {"a": {"$ref": "#"}}, "items": {"$ref": "#"}, "type": ["object", "array"]})";
  const std::string deep = std::string(60, '[') + R"({"a": 7})" + std::string(60, ']');
  const Complaints complaints = complaints_about(schema, deep);
  REQUIRE(complaints.size() == 1);
  CHECK(complaints[0].ends_with("/0/a: expected an object or a list, found 7"));
}

TEST_CASE("defaults of a recursive schema are set in every object that is present") {
  const JsonSchema schema(R"({"properties": {"a": {"$ref": "#"}, "n": {"default": 1}}})");
  json value = json::parse(R"({"a": {"a": {}}})");
  fill_defaults(schema.root(), value);
  CHECK(value == json::parse(R"({"n": 1, "a": {"n": 1, "a": {"n": 1}}})"));
}

}  // namespace
}  // namespace contourd
