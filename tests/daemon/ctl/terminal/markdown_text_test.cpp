#include "daemon/ctl/terminal/markdown_text.hpp"

#include "tests/catch.hpp"

using namespace contourd::ctl;

TEST_CASE("Markdown's markup is removed from words") {
  CHECK(plain_words("see [the page](a.md#b), **now**") == "see the page, now");
  CHECK(plain_words("`a [b](c) **d**` and `e`") == "a [b](c) **d** and e");
  CHECK(plain_words("[OPTION] and [a](b)") == "[OPTION] and a");
  CHECK(plain_words("![a picture](a.png)") == "a picture");
  CHECK(plain_words("one ` and [ and ](") == "one ` and [ and ](");
}

TEST_CASE("Headings, paragraphs and lists keep to the width") {
  CHECK(
      plain_text("# Title\n\nA paragraph of\nsome words.\n\n## Below\n- one and two and\n  three\n- four\n\n"
                 "12. last of all things\n",
                 20) ==
      "Title\n=====\n\nA paragraph of some\nwords.\n\nBelow\n-----\n- one and two and\n  three\n- four\n\n"
      "12. last of all\n    things\n");
}

TEST_CASE("A command is not broken, and its remark goes above it if there is no room") {
  const auto page = "    run --now        # it runs at once\n\n    stop\n";
  CHECK(plain_text(page, 60) == "    run --now        # it runs at once\n\n    stop\n");
  CHECK(plain_text(page, 20) == "    # it runs at\n    # once\n    run --now\n\n    stop\n");
  CHECK(plain_text("```sh\n# no heading\n```\n", 40) == "    # no heading\n");
}

TEST_CASE("A table has columns if they fit, otherwise entries") {
  const auto page = "| key | means |\n|---|---|\n| `a\\|b` | one of these two |\n| c | |\n";
  CHECK(plain_text(page, 40) == "key  means\n----------\na|b  one of these two\nc\n");
  CHECK(plain_text(page, 20) == "key  means\n----------\na|b  one of these\n     two\nc\n");
  const auto wide = "| a long name | b | c |\n|---|---|---|\n| one two three | 4 | 5 |\n";
  CHECK(plain_text(wide, 20) == "one two three\n    b: 4\n    c: 5\n");
}

TEST_CASE("Any text has a plain form at any width") {
  for (const auto* text :
       {"", "\n\n", "|", "| |", "|---|", "#", "```", "- ", "[", "](", "    ", "1. ", "a\n|b|\n", "\xFF|"})
    for (const std::size_t columns : {0U, 1U, 40U, 1000U})
      CHECK(plain_text(text, columns).size() < 100);
}
