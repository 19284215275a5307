#include "daemon/ctl/terminal/text_columns.hpp"

#include "tests/catch.hpp"

using namespace contourd::ctl;

using Lines = std::vector<std::string>;

TEST_CASE("The width of a text counts a terminal's columns") {
  CHECK(columns_of("") == 0);
  CHECK(columns_of("gear") == 4);
  CHECK(columns_of("B\u00E4r") == 3);
  CHECK(columns_of("\u90E8\u54C1") == 4);  // two columns each
  CHECK(columns_of("a\u0308") == 1);       // a combining mark
  CHECK(columns_of("a\xFF") == 2);         // not UTF-8
}

TEST_CASE("A text is cut between characters, and the cut is marked") {
  CHECK(cut_to_columns("gear", 4) == "gear");
  CHECK(cut_to_columns("a longer name", 8) == "a lon...");
  CHECK(cut_to_columns("gears", 4) == "gear");  // no room for dots
  CHECK(cut_to_columns("\u90E8\u54C1\u90E8\u54C1", 7) == "\u90E8\u54C1...");
  CHECK(cut_to_columns("\u90E8\u54C1", 3) == "\u90E8");
  CHECK(cut_to_columns("\u90E8", 1).empty());
  CHECK(cut_to_columns("gear", 0).empty());
}

TEST_CASE("A text is wrapped at spaces, and inside words that are too wide") {
  CHECK(wrapped("", 10) == Lines{""});
  CHECK(wrapped("one two", 10) == Lines{"one two"});
  CHECK(wrapped("one two three", 7) == Lines{"one two", "three"});
  CHECK(wrapped("one two three", 8) == Lines{"one two", "three"});
  CHECK(wrapped("abcdefgh", 3) == Lines{"abc", "def", "gh"});
  CHECK(wrapped("\u90E8\u54C1\u90E8", 5) == Lines{"\u90E8\u54C1", "\u90E8"});
  CHECK(wrapped("\u90E8", 1) == Lines{""});
  CHECK(wrapped("a b", 1) == Lines{"a", "b"});
}
