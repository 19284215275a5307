#include "daemon/json/schema_node.hpp"

#include "tests/catch.hpp"

namespace contourd {
namespace {

TEST_CASE("a pattern matches anywhere, and its anchors are the ends of the text, not of a line") {
  CHECK(SchemaPattern("a+").is_in("xxaayy"));
  CHECK(SchemaPattern("^a*$").is_in("aaa"));
  CHECK_FALSE(SchemaPattern("^a*$").is_in("aab"));
  CHECK_FALSE(SchemaPattern("^abc$").is_in("abc\n"));
  CHECK_FALSE(SchemaPattern("^b").is_in("a\nb"));
  CHECK(SchemaPattern("").is_in(""));
}

TEST_CASE("a pattern matches characters, not bytes") {
  CHECK(SchemaPattern("^.$").is_in("\xF0\x9F\x90\xB2"));
  CHECK(SchemaPattern("^\xF0\x9F\x90\xB2*$").is_in("\xF0\x9F\x90\xB2\xF0\x9F\x90\xB2"));
  CHECK(SchemaPattern("^[^/]{2}$").is_in("\xC3\xA4\xE2\x82\xAC"));
  CHECK_FALSE(SchemaPattern("^[\xC3\xA0-\xC3\xA5]$").is_in("\xC3\xBC"));
}

TEST_CASE("digit and word classes are ASCII only") {
  CHECK(SchemaPattern("^\\d\\w$").is_in("1a"));
  CHECK_FALSE(SchemaPattern("^\\d$").is_in("\xE0\xA7\xAA"));
  CHECK_FALSE(SchemaPattern("^\\w$").is_in("\xC3\xA9"));
  CHECK(SchemaPattern("^\\W\\D$").is_in("\xC3\xA9\xC3\xA9"));
}

TEST_CASE("patterns that std::regex treats differently from the draft are refused") {
  for (const char* pattern :
       {"\\s", "\\Z", "\\p{L}", "a\\", "\\\\\\b", "[[:alpha:]]", "[[=a=]]", "(", "*", "a{2"})
    CHECK_THROWS_AS(SchemaPattern(pattern), std::invalid_argument);
  CHECK(SchemaPattern("\\\\s\\.").is_in("\\s."));
}

}  // namespace
}  // namespace contourd
