#include "daemon/json/schema_reader.hpp"

#include <string_view>

#include "daemon/json/json_schema.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using testing::Complaints;
using testing::complaints_of;

Complaints complaints_about(std::string_view schema) {
  return complaints_of([&] { JsonSchema(schema, "x.schema.json"); });
}

TEST_CASE("an unknown keyword in a schema is refused when it is read, with its place") {
  CHECK(complaints_about(R"({"minProperties": 1})") ==
        Complaints{"/minProperties: the keyword \"minProperties\" is not known"});
  CHECK(complaints_about(R"({"properties": {"a/b": {"items": {"oneOf": [{}, {"minimun": 1}]}}}})") ==
        Complaints{"/properties/a~1b/items/oneOf/1/minimun: the keyword \"minimun\" is not known"});
  CHECK(complaints_about(R"({"definitions": {"unused": {"const": 1}}})") ==
        Complaints{"/definitions/unused/const: the keyword \"const\" is not known"});
  CHECK(complaints_about(R"({"additionalProperties": {"not": {}}})") ==
        Complaints{"/additionalProperties/not: the keyword \"not\" is not known"});
  CHECK(complaints_about(R"({"$ref": "#", "if": true})").size() == 1);
  const auto violations = testing::violations_of([] { JsonSchema(R"({"format": "uri"})", "x.schema.json"); });
  REQUIRE(violations.size() == 1);
  CHECK(violations[0].file == "x.schema.json");
}

TEST_CASE("a keyword's name is no keyword where names of keys stand") {
  CHECK(complaints_about(R"({"properties": {"const": {}, "$ref": {"type": "string"}},
                             "default": {"not": 1}, "examples": [{"if": 1}], "enum": [{"const": 1}]})")
            .empty());
}

TEST_CASE("what says nothing about what fits is known") {
  CHECK(complaints_about(R"({"$schema": "http://json-schema.org/draft-07/schema#", "$id": "http://a/b.json",
                             "$comment": "c", "title": "t", "description": "d", "default": 1, "examples": [1]})")
            .empty());
}

TEST_CASE("a keyword with a value that it cannot have is refused") {
  CHECK(complaints_about("3") == Complaints{"expected a schema"});
  CHECK(complaints_about(R"({"properties": {"a": null}})") == Complaints{"/properties/a: expected a schema"});
  CHECK(complaints_about(R"({"properties": []})") == Complaints{"/properties: expected an object"});
  CHECK(complaints_about(R"({"maximum": "5"})") == Complaints{"/maximum: expected a number"});
  for (const char* size : {"-1", "1.5", "1e300", "\"1\"", "true"}) {
    for (const char* keyword : {"minLength", "maxLength", "minItems", "maxItems"}) {
      CHECK(complaints_about("{\"" + std::string(keyword) + "\": " + size + "}") ==
            Complaints{"/" + std::string(keyword) + ": expected a whole number that is not negative"});
    }
  }
  CHECK(complaints_about(R"({"maxLength": 2.0})").empty());
  CHECK(complaints_about(R"({"type": "text"})") == Complaints{"/type: the type \"text\" is not known"});
  CHECK(complaints_about(R"({"type": ["string", 5]})") == Complaints{"/type: expected a text"});
  CHECK(complaints_about(R"({"type": []})") == Complaints{"/type: expected a list with something in it"});
  CHECK(complaints_about(R"({"enum": 5})") == Complaints{"/enum: expected a list with something in it"});
  CHECK(complaints_about(R"({"oneOf": []})") == Complaints{"/oneOf: expected a list with something in it"});
  CHECK(complaints_about(R"({"required": "a"})") == Complaints{"/required: expected a list"});
  CHECK(complaints_about(R"({"required": ["a", 1]})") == Complaints{"/required/1: expected a text"});
  CHECK(complaints_about(R"({"items": [{}]})") ==
        Complaints{"/items: a schema for each element is not known, only one for all"});
  CHECK(complaints_about(R"({"pattern": "("})") == Complaints{"/pattern: \"(\" is no regular expression"});
  CHECK(complaints_about(R"({"$schema": "http://json-schema.org/draft-04/schema#"})").size() == 1);
  CHECK(complaints_about(R"({"properties": {"a": {"$id": "b"}}})") ==
        Complaints{"/properties/a/$id: a name within a schema is not known, only that of the whole"});
}

TEST_CASE("a reference to nothing is refused") {
  CHECK(complaints_about(R"({"items": {"$ref": "#/definitions/none"}})") ==
        Complaints{"/items/$ref: there is no \"#/definitions/none\" to refer to"});
  CHECK(complaints_about(R"({"$ref": "#definitions"})") ==
        Complaints{"/$ref: there is no \"#definitions\" to refer to"});
  CHECK(complaints_about(R"({"$ref": "#/enum/7", "enum": [1]})").size() == 1);
  CHECK(complaints_about(R"({"$ref": "#/a~2"})").size() == 1);
  CHECK(complaints_about(R"({"$ref": "other.json#/a"})") ==
        Complaints{"/$ref: there is no schema \"other.json\" to refer to"});
  CHECK(complaints_about(R"({"$ref": "#/%2"})") ==
        Complaints{"/$ref: expected two hexadecimal digits after '%'"});
  CHECK(complaints_about(R"({"$ref": "#/title", "title": "t"})") == Complaints{"/title: expected a schema"});
}

TEST_CASE("a reference is written as part of an address, and its pointer has escapes of its own") {
  const JsonSchema schema(
      R"({"definitions": {"a~b": {"maximum": 1}, "a/b": {"maximum": 2}, "a%b": {"maximum": 3}},
    "properties": {"x": {"$ref": "#/definitions/a~0b"}, "y": {"$ref": "#/definitions/a~1b"},
                   "z": {"$ref": "#/definitions/a%25b"}, "same": {"$ref": "#%2Fdefinitions/a~1b"}}})");
  CHECK(schema.root().properties.at("x")->followed().maximum == 1);
  CHECK(schema.root().properties.at("y")->followed().maximum == 2);
  CHECK(schema.root().properties.at("z")->followed().maximum == 3);
  CHECK(&schema.root().properties.at("same")->followed() == &schema.root().properties.at("y")->followed());
}

TEST_CASE("a circle of references that would never end is refused") {
  CHECK(complaints_about(R"({"$ref": "#"})") == Complaints{"this leads back to itself"});
  CHECK(complaints_about(
            R"({"definitions": {"a": {"$ref": "#/definitions/b"}, "b": {"$ref": "#/definitions/a"}}})") ==
        Complaints{"/definitions/a: this leads back to itself"});
  CHECK(complaints_about(R"({"oneOf": [{"type": "string"}, {"$ref": "#"}]})").size() == 1);
  // Every default would have one more in it.
  CHECK(complaints_about(R"({"properties": {"a": {"$ref": "#", "default": {}}}})").size() == 1);
  CHECK(complaints_about(R"({"properties": {"a": {"$ref": "#"}}})").empty());
  CHECK(complaints_about(R"({"items": {"$ref": "#"}, "default": []})").empty());
}

}  // namespace
}  // namespace contourd
