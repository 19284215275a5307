#include "daemon/system/utf_8.hpp"

#include "tests/catch.hpp"

namespace contourd {
namespace {

TEST_CASE("characters of every length are read, and malformed sequences next to them are not") {
  CHECK(code_points("a\xC3\xA4\xE2\x82\xAC\xF0\x9F\x92\xA9") == U"a\u00E4\u20AC\U0001F4A9");
  CHECK(utf_8_length("\xF4\x8F\xBF\xBF") == 4);  // U+10FFFF
  for (const char* none : {"", "\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                           "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xE2\x82", "\xF0\x9F\x92", "\xC3z"})
    CHECK(utf_8_length(none) == 0);
}

TEST_CASE("the first byte that is not part of a character is found") {
  CHECK_FALSE(first_invalid_utf_8("Ger\xC3\xA4t").has_value());
  CHECK(first_invalid_utf_8("\xC3\xA4\xFFz") == 2U);
  CHECK(first_invalid_utf_8("ab\xE2\x82") == 2U);
  CHECK(code_points("\xC3\xA4\xFFz") == U"\u00E4\uFFFDz");
}

TEST_CASE("a text is cut between characters, and anywhere if it is not UTF-8") {
  CHECK(cut_utf_8("Ger\xC3\xA4t", 4) == "Ger");
  CHECK(cut_utf_8("Ger\xC3\xA4t", 5) == "Ger\xC3\xA4");
  CHECK(cut_utf_8("\xF0\x9F\x92\xA9", 3).empty());
  CHECK(cut_utf_8("short", 5) == "short");
  CHECK(cut_utf_8("\x80\x80\x80\x80\x80\x80\x80\x80", 6).size() == 3);
}

}  // namespace
}  // namespace contourd
