#include "daemon/json/schema_reader.hpp"

#include "daemon/json/json_schema.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

Complaints schema_complaints(std::string_view schema) {
  return complaints_of([&] { JsonSchema(schema, "x.schema.json"); });
}

TEST_CASE("an unknown keyword in a schema is refused when it is read, with its place") {
  CHECK(schema_complaints(R"({"minProperties": 1})") ==
        Complaints{"/minProperties: the keyword \"minProperties\" is not supported"});
  CHECK(schema_complaints(R"({"properties": {"a/b": {"items": {"oneOf": [{}, {"minimun": 1}]}}}})") ==
        Complaints{"/properties/a~1b/items/oneOf/1/minimun: the keyword \"minimun\" is not supported"});
  CHECK(schema_complaints(R"({"definitions": {"unused": {"const": 1}}})") ==
        Complaints{"/definitions/unused/const: the keyword \"const\" is not supported"});
  CHECK(schema_complaints(R"({"additionalProperties": {"not": {}}})") ==
        Complaints{"/additionalProperties/not: the keyword \"not\" is not supported"});
  CHECK(schema_complaints(R"({"$ref": "#", "if": true})").size() == 1);
  const auto violations = testing::violations_of([] { JsonSchema(R"({"format": "uri"})", "x.schema.json"); });
  REQUIRE(violations.size() == 1);
  CHECK(violations[0].file == "x.schema.json");
}

TEST_CASE("a keyword's name is not a keyword among the names of properties") {
  CHECK(schema_complaints(R"({"properties": {"const": {}, "$ref": {"type": "string"}},
                             "default": {"not": 1}, "examples": [{"if": 1}], "enum": [{"const": 1}]})")
            .empty());
}

TEST_CASE("annotations are accepted") {
  CHECK(schema_complaints(R"({"$schema": "http://json-schema.org/draft-07/schema#", "$id": "http://a/b.json",
                             "$comment": "c", "title": "t", "description": "d", "default": 1, "examples": [1]})")
            .empty());
}

TEST_CASE("a keyword with an invalid value is refused") {
  CHECK(schema_complaints("3") == Complaints{"expected a schema"});
  CHECK(schema_complaints(R"({"properties": {"a": null}})") ==
        Complaints{"/properties/a: expected a schema"});
  CHECK(schema_complaints(R"({"properties": []})") == Complaints{"/properties: expected an object"});
  CHECK(schema_complaints(R"({"maximum": "5"})") == Complaints{"/maximum: expected a number"});
  for (const char* size : {"-1", "1.5", "1e300", "\"1\"", "true"}) {
    for (const char* keyword : {"minLength", "maxLength", "minItems", "maxItems"}) {
      CHECK(schema_complaints("{\"" + std::string(keyword) + "\": " + size + "}") ==
            Complaints{"/" + std::string(keyword) + ": expected a whole number that is not negative"});
    }
  }
  CHECK(schema_complaints(R"({"maxLength": 2.0})").empty());
  CHECK(schema_complaints(R"({"type": "text"})") == Complaints{"/type: the type \"text\" is not supported"});
  CHECK(schema_complaints(R"({"type": ["string", 5]})") == Complaints{"/type: expected a text"});
  CHECK(schema_complaints(R"({"type": []})") == Complaints{"/type: expected a list that is not empty"});
  CHECK(schema_complaints(R"({"enum": 5})") == Complaints{"/enum: expected a list that is not empty"});
  CHECK(schema_complaints(R"({"oneOf": []})") == Complaints{"/oneOf: expected a list that is not empty"});
  CHECK(schema_complaints(R"({"required": "a"})") == Complaints{"/required: expected a list"});
  CHECK(schema_complaints(R"({"required": ["a", 1]})") == Complaints{"/required/1: expected a text"});
  CHECK(schema_complaints(R"({"items": [{}]})") ==
        Complaints{"/items: a schema for each element is not supported, only one for all elements"});
  CHECK(schema_complaints(R"({"pattern": "("})") ==
        Complaints{"/pattern: \"(\" is not a regular expression"});
  CHECK(schema_complaints(R"({"$schema": "http://json-schema.org/draft-04/schema#"})").size() == 1);
  CHECK(schema_complaints(R"({"properties": {"a": {"$id": "b"}}})") ==
        Complaints{"/properties/a/$id: $id is only supported for the whole schema"});
}

TEST_CASE("a reference to a missing part is refused") {
  CHECK(schema_complaints(R"({"items": {"$ref": "#/definitions/none"}})") ==
        Complaints{"/items/$ref: there is no \"#/definitions/none\" to refer to"});
  CHECK(schema_complaints(R"({"$ref": "#definitions"})") ==
        Complaints{"/$ref: there is no \"#definitions\" to refer to"});
  CHECK(schema_complaints(R"({"$ref": "#/enum/7", "enum": [1]})").size() == 1);
  CHECK(schema_complaints(R"({"$ref": "#/a~2"})").size() == 1);
  CHECK(schema_complaints(R"({"$ref": "other.json#/a"})") ==
        Complaints{"/$ref: there is no schema \"other.json\" to refer to"});
  CHECK(schema_complaints(R"({"$ref": "#/%2"})") ==
        Complaints{"/$ref: expected two hexadecimal digits after '%'"});
  CHECK(schema_complaints(R"({"$ref": "#/title", "title": "t"})") == Complaints{"/title: expected a schema"});
}

TEST_CASE("a reference has percent escapes, and its pointer has escapes of its own") {
  const JsonSchema schema(
      R"({"definitions": {"a~b": {"maximum": 1}, "a/b": {"maximum": 2}, "a%b": {"maximum": 3}},
    "properties": {"x": {"$ref": "#/definitions/a~0b"}, "y": {"$ref": "#/definitions/a~1b"},
                   "z": {"$ref": "#/definitions/a%25b"}, "same": {"$ref": "#%2Fdefinitions/a~1b"}}})");
  CHECK(schema.root().properties.at("x")->followed().maximum == 1);
  CHECK(schema.root().properties.at("y")->followed().maximum == 2);
  CHECK(schema.root().properties.at("z")->followed().maximum == 3);
  CHECK(&schema.root().properties.at("same")->followed() == &schema.root().properties.at("y")->followed());
}

TEST_CASE("an endless cycle of references is refused") {
  CHECK(schema_complaints(R"({"$ref": "#"})") == Complaints{"this schema refers back to itself"});
  CHECK(schema_complaints(
            R"({"definitions": {"a": {"$ref": "#/definitions/b"}, "b": {"$ref": "#/definitions/a"}}})") ==
        Complaints{"/definitions/a: this schema refers back to itself"});
  CHECK(schema_complaints(R"({"oneOf": [{"type": "string"}, {"$ref": "#"}]})").size() == 1);
  // Every default would contain another one.
  CHECK(schema_complaints(R"({"properties": {"a": {"$ref": "#", "default": {}}}})").size() == 1);
  CHECK(schema_complaints(R"({"properties": {"a": {"$ref": "#"}}})").empty());
  CHECK(schema_complaints(R"({"items": {"$ref": "#"}, "default": []})").empty());
}

}  // namespace
}  // namespace contourd
