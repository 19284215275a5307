#include "daemon/system/readable.hpp"

#include "tests/catch.hpp"

TEST_CASE("Text from a file name is one line of valid UTF-8") {
  CHECK(printable("plain.stl") == "plain.stl");
  CHECK(printable("Ger\xC3\xA4t") == "Ger\xC3\xA4t");
  CHECK(printable("two\nlines\x1B[2J") == "two?lines?[2J");
  CHECK(printable("bad\xFF") == "bad\xEF\xBF\xBD");
}

TEST_CASE("Text that is too long is cut between characters, with the length of the rest") {
  CHECK(shortened("short", 5) == "short");
  CHECK(shortened("longer", 5) == "longe... (1 bytes more)");
  CHECK(shortened("Ger\xC3\xA4t", 4) == "Ger... (3 bytes more)");
  CHECK(shortened("", 0).empty());
}

TEST_CASE("Characters that reorder, hide or break a line are replaced") {
  CHECK(printable("a\xC2\x9B"
                  "b") == "a?b");  // U+009B, a C1 control that begins a sequence as ESC [ does
  CHECK(printable("a\xE2\x80\xAE"
                  "lts.b") == "a?lts.b");  // U+202E, right-to-left override
  CHECK(printable("a\xE2\x81\xA6"
                  "b") == "a?b");  // U+2066, left-to-right isolate
  CHECK(printable("a\xE2\x80\xA8"
                  "b") == "a?b");  // U+2028, line separator
  CHECK(printable("a\xE2\x80\x8B"
                  "b") == "a?b");  // U+200B, zero width space
  CHECK(printable("a\xEF\xBB\xBF"
                  "b") == "a?b");  // U+FEFF, byte order mark
  CHECK(printable("a\xF3\xA0\x80\xA1"
                  "b") == "a?b");  // U+E0021, tag
  CHECK(printable("a\x7F"
                  "b\tc\rd") == "a?b?c?d");
  CHECK(printable("\xE4\xB8\xAD\xF0\x9F\x96\xA8 \xD7\xA9") == "\xE4\xB8\xAD\xF0\x9F\x96\xA8 \xD7\xA9");
  CHECK(printable("cut\xE2\x80") == "cut\xEF\xBF\xBD");
  CHECK(printable("").empty());
}

TEST_CASE("Text of several lines keeps its line breaks but no other control characters") {
  CHECK(printable_lines("one\ntwo\x1B[2J\xE2\x80\xA8three\r") == "one\ntwo?[2J?three?");
}
