#include "daemon/json/json_document.hpp"

#include <sys/stat.h>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

JsonDocument parse(std::string_view text) {
  return JsonDocument::from_text(text, "test.json");
}

Complaints syntax_complaints(std::string_view text) {
  return complaints_of([&] { parse(text).throw_if_violated(); });
}

TEST_CASE("a JSON file is read with its path as the name in messages") {
  const ConfigFolder folder;
  const auto file = folder.write("a.json", "{\"a\": [1, 2]}");
  const JsonDocument document = JsonDocument::from_file(file);
  CHECK(document.file() == file.string());
  CHECK(document.value().dump() == R"({"a":[1,2]})");
  CHECK(document.violations().empty());
}

TEST_CASE("a path that is not a readable file is refused with one sentence") {
  const ConfigFolder folder;
  const auto missing = folder.path() / "missing.json";
  const auto fifo = folder.path() / "fifo.json";
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  const auto read = [](const std::filesystem::path& path) {
    return complaints_of([&] { (void)JsonDocument::from_file(path); });
  };
  CHECK(read(missing) == Complaints{"there is no such file"});
  CHECK(read(folder.path() / "missing" / "a.json") == Complaints{"there is no such file"});
  CHECK(read(folder.path()) == Complaints{"it is a folder, not a file"});
  CHECK(read(fifo) == Complaints{"it is not a regular file"});
  CHECK(violations_of([&] { (void)JsonDocument::from_file(missing); }).at(0).file == missing.string());
}

TEST_CASE("a file without read permission is refused with the system's reason") {
  const ConfigFolder folder;
  const auto file = folder.write("a.json", "{}");
  std::filesystem::permissions(file, std::filesystem::perms::none);
  if (std::ifstream(file)) return;  // root reads everything
  CHECK(complaints_of([&] { (void)JsonDocument::from_file(file); }) ==
        Complaints{"it cannot be read: Permission denied"});
}

TEST_CASE("a file of 1 MiB is read and one byte more is refused") {
  const ConfigFolder folder;
  std::string text = "{}";
  text.resize(1024 * 1024, ' ');
  CHECK(JsonDocument::from_file(folder.write("full.json", text)).value().is_object());
  text += ' ';
  const auto file = folder.write("over.json", text);
  CHECK(complaints_of([&] { (void)JsonDocument::from_file(file); }) ==
        Complaints{"it is larger than the limit, 1 MiB"});
}

TEST_CASE("a syntax error is one sentence with line and column") {
  CHECK(syntax_complaints("") == Complaints{"line 1, column 1: it is empty; a JSON object is expected"});
  CHECK(syntax_complaints(" \n ").size() == 1);
  CHECK(syntax_complaints("{\n  \"a\": 1,\n}") ==
        Complaints{"line 3, column 1: remove the comma before this bracket"});
  CHECK(syntax_complaints("{\"a\": [1, 2,]}") ==
        Complaints{"line 1, column 13: remove the comma before this bracket"});
  CHECK(syntax_complaints("{\"a\": 1") ==
        Complaints{"line 1, column 8: the text ends before its last bracket or quote is closed"});
  CHECK(syntax_complaints("// mine\n{}") == Complaints{"line 1, column 1: JSON has no comments"});
  CHECK(syntax_complaints("{'a': 1}") ==
        Complaints{"line 1, column 2: keys and texts are written in double quotes"});
  CHECK(syntax_complaints("{\"a\": }") == Complaints{"line 1, column 7: \"}\" is not expected here"});
  CHECK(syntax_complaints("{\"a\": True}") == Complaints{"line 1, column 7: \"True\" is not expected here"});
  CHECK(syntax_complaints("{\"a\": tru}") == Complaints{"line 1, column 10: \"tru\" is not expected here"});
  CHECK(syntax_complaints("{\"a\": 1 \"b\": 2}") ==
        Complaints{"line 1, column 11: \"b\" is not expected here"});
  for (const std::string_view text :
       {"{\"a\" 1}", "{\"a\": 1 \"b\": 2}", "{\"a\": tru}", "{\"a\": NaN}", "{\"a\": -}", "{\"a\": 01}",
        "{\"a\": \"\\ud800\"}", "{\"a\": \"\n\"}", "{} {}", "\\"}) {
    INFO(text);
    const Complaints complaints = syntax_complaints(text);
    REQUIRE(complaints.size() == 1);
    CHECK(complaints[0].starts_with("line 1, column "));
    CHECK(complaints[0].find("json.exception") == std::string::npos);
    CHECK(complaints[0].find('\n') == std::string::npos);
  }
}

TEST_CASE("columns count characters, not bytes") {
  CHECK(syntax_complaints("{\"\xc3\xa4\xe2\x82\xac\": }") ==
        Complaints{"line 1, column 8: \"}\" is not expected here"});
}

TEST_CASE("a byte order mark is skipped and not counted as a column") {
  CHECK(parse("\xef\xbb\xbf{\"a\": 1}").value().at("a").get<int>() == 1);
  CHECK(syntax_complaints("\xef\xbb\xbf{\"a\": }") ==
        Complaints{"line 1, column 7: \"}\" is not expected here"});
  CHECK(syntax_complaints("\xff\xfe{\0}\0").size() == 1);  // UTF-16
}

TEST_CASE("a second byte order mark is refused, a third one too") {
  for (const std::string marks : {"\xef\xbb\xbf\xef\xbb\xbf", "\xef\xbb\xbf\xef\xbb\xbf\xef\xbb\xbf"})
    CHECK(syntax_complaints(marks + "{\"a\": 1}") ==
          Complaints{"line 1, column 1: there is a second byte order mark"});
  CHECK(syntax_complaints("\xef\xbb\xbf") == syntax_complaints(""));
}

TEST_CASE("a text that is not UTF-8 is refused at its first invalid byte") {
  CHECK(syntax_complaints("{\n\"a\": \"x\xff\"}") == Complaints{"line 2, column 8: this is not UTF-8 text"});
  // A lone continuation byte, overlong forms, a surrogate, code points beyond U+10FFFF, truncated characters.
  for (const std::string_view bad : {"\x80", "\xc0\xaf", "\xe0\x80\xaf", "\xf0\x80\x80\xaf", "\xed\xa0\x80",
                                     "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xe2\x82", "\xf0\x9f\x92"}) {
    INFO(nlohmann::json(bad).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
    const std::string prefix = "{\"";
    CHECK(syntax_complaints(prefix + std::string(bad)) ==
          Complaints{"line 1, column 3: this is not UTF-8 text"});
    CHECK(syntax_complaints(prefix + std::string(bad) + "\": 1}") ==
          Complaints{"line 1, column 3: this is not UTF-8 text"});
  }
}

TEST_CASE("UTF-8 characters of every length are accepted") {
  const std::string text =
      "\x7f \xc2\x80 \xdf\xbf \xe0\xa0\x80 \xed\x9f\xbf \xef\xbf\xbf \xf0\x90\x80\x80 \xf4\x8f\xbf\xbf";
  CHECK(parse("[\"" + text + "\"]").value().at(0).get<std::string>() == text);
}

TEST_CASE("duplicate keys are violations at any depth, each reported once") {
  const JsonDocument document = parse(
      R"({"a": 1, "b": [0, {"c": 1, "c": 2, "d": {"e/f": 1, "e/f": 2, "e/f": 3}}], "a": 2, "x": {"a": 1}})");
  const std::vector<Violation> expected{
      {"test.json", "/a", "this key occurs more than once"},
      {"test.json", "/b/1/c", "this key occurs more than once"},
      {"test.json", "/b/1/d/e~1f", "this key occurs more than once"},
  };
  CHECK(document.violations() == expected);
}

TEST_CASE("the same key in two objects is not a duplicate") {
  CHECK(syntax_complaints(R"([{"a": 1}, {"a": 1}, {"a": {"a": [{"a": 1}]}}])").empty());
}

TEST_CASE("nesting has a maximum depth") {
  const auto nested = [](std::size_t depth, char open, char close) {
    return std::string(depth, open) + std::string(depth, close);
  };
  CHECK(syntax_complaints(nested(64, '[', ']')).empty());
  CHECK(syntax_complaints(nested(65, '[', ']')) == Complaints{"it is nested more than 64 deep"});
  CHECK(syntax_complaints(nested(500'000, '[', ']')) == Complaints{"it is nested more than 64 deep"});
  std::string objects;
  for (int i = 0; i < 100'000; ++i)
    objects += "{\"a\":";
  CHECK(syntax_complaints(objects) == Complaints{"it is nested more than 64 deep"});
}

TEST_CASE("texts and keys have a maximum length and no NUL") {
  const std::string fits(1024, 'x');
  CHECK(syntax_complaints("{\"a\": \"" + fits + "\"}").empty());
  CHECK(syntax_complaints("{\"a\": [\"" + fits + "x\"]}") ==
        Complaints{"/a/0: this text is 1025 bytes long; the limit is 1024"});
  CHECK(syntax_complaints("{\"" + fits + "x\": 1}") ==
        Complaints{"/" + std::string(32, 'x') + ": this key is 1025 bytes long; the limit is 1024"});
  CHECK(syntax_complaints(R"({"a": "/var/spool\u0000/x"})") ==
        Complaints{"/a: this text has a NUL character in it"});
}

TEST_CASE("a number too large for a double is refused and one too small becomes zero") {
  CHECK(syntax_complaints("{\"a\": 1e400}") ==
        Complaints{"line 1, column 11: the number \"1e400\" is too large"});
  CHECK(syntax_complaints("{\"a\": -1e400}").size() == 1);
  CHECK(parse("[1e-400]").value().at(0).get<double>() == 0.0);
}

TEST_CASE("whole numbers are integers however they are written, and none wraps around") {
  const auto value = parse("[3.0, 3e2, -0.0, -3.7, 9007199254740993.0, 1e300]").value();
  CHECK(value.at(0).is_number_integer());
  CHECK(value.at(0).get<int>() == 3);
  CHECK(value.at(1).is_number_integer());
  CHECK(value.at(2).dump() == "0");
  CHECK(value.at(3).is_number_float());
  CHECK(value.at(5).is_number_float());
  const auto huge = parse("{\"a\": [18446744073709551615, 9223372036854775807]}").value().at("a");
  CHECK(huge.at(0).get<double>() == 18446744073709551615.0);
  CHECK(huge.at(0).is_number_float());
  CHECK(huge.at(1).get<std::int64_t>() == INT64_MAX);
}

TEST_CASE("an error's text has one line per violation, whatever the names contain") {
  const ConfigError error(
      {{"a\nb.json", "/x\x1b", "one"}, {"c.json", "", "two\xc2\x9b"}, {"\xe2\x80\xae", "", "\r3"}});
  CHECK(std::string(error.what()) == "a?b.json: /x?: one\nc.json: two?\n?: ?3");
  CHECK(error.in_one_line() == "a?b.json: /x?: one; c.json: two?; ?: ?3");
  CHECK(warning_line({"a\nb", "/\xe2\x81\xa6", "\x1b[2J"}) == "a?b: warning: /?: ?[2J");
}

TEST_CASE("a quoted value is short, printable and valid UTF-8") {
  CHECK(in_quotes("a\"b") == "\"a\\\"b\"");
  CHECK(in_quotes("a\nb\x7f") == "\"a\\nb?\"");
  CHECK(in_quotes("\xc2\x9b\xe2\x80\xae") == "\"??\"");
  CHECK(in_quotes("\xff") == "\"\xef\xbf\xbd\"");
  CHECK(in_quotes(std::string(61, 'x')) == "\"" + std::string(60, 'x') + "...\"");
  // A two-byte character at the cut is dropped completely.
  CHECK(in_quotes(std::string(59, 'x') + "\xc3\xa4z") == "\"" + std::string(59, 'x') + "...\"");
}

TEST_CASE("a valid value has the right type and no violation") {
  JsonDocument document = parse(R"({"a": 1.5, "b": "x", "c": {"d": 2}})");
  CHECK(document.valid_number("/a") == 1.5);
  CHECK(document.valid_number("/c/d") == 2.0);
  CHECK(document.valid_text("/b") == "x");
  CHECK_FALSE(document.valid_number("/b"));
  CHECK_FALSE(document.valid_number("/a/b"));
  CHECK_FALSE(document.valid_number("/missing"));
  document.add_violation("/a", "wrong");
  CHECK_FALSE(document.valid_number("/a"));
}

}  // namespace
}  // namespace contourd
