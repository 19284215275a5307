#include "daemon/json/json_syntax.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

constexpr std::size_t kDeepestNesting = 64;
// Also limits the recursion of schema patterns: libstdc++'s std::regex recurses once per character.
constexpr std::size_t kLongestTextBytes = 1024;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

// Returns `line 3, column 7`, counted from 1 in characters.
std::string place(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  const std::string_view in_line = before.substr(line_start);
  const auto column =
      1 + std::count_if(in_line.begin(), in_line.end(), [](char c) { return !continues_character(c); });
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

// Returns the word or number around `offset`, or the character there if it is a delimiter.
std::string word_at(std::string_view text, std::size_t offset) {
  constexpr std::string_view kDelimiters = " \t\r\n,:{}[]\"";
  const std::size_t start = text.substr(0, offset).find_last_of(kDelimiters) + 1;  // npos + 1 is 0
  const std::size_t end = std::min(text.find_first_of(kDelimiters, offset), text.size());
  return std::string(start < end ? text.substr(start, end - start) : text.substr(offset, 1));
}

// Describes the most likely mistake at `offset`, where the parser gave up.
std::string syntax_sentence(std::string_view text, std::size_t offset) {
  if (std::all_of(text.begin(), text.end(), is_space)) return "it is empty; a JSON object is expected";
  if (offset >= text.size()) return "the text ends before its last bracket or quote is closed";
  const std::size_t before = text.substr(0, offset).find_last_not_of(" \t\r\n");
  const bool after_comma = before != std::string_view::npos && text[before] == ',';
  const char here = text[offset];
  if (here == '/' || here == '#') return "JSON has no comments";
  if (here == '\'') return "keys and texts are written in double quotes";
  if ((here == '}' || here == ']') && after_comma) return "remove the comma before this bracket";
  return in_quotes(word_at(text, offset)) + " is not expected here";
}

// Checks the parser's events and keeps track of the current place in the document.
class SyntaxCheck final : public nlohmann::json_sax<nlohmann::json> {
 public:
  SyntaxCheck(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  bool null() override { return end_value(); }
  bool boolean(bool) override { return end_value(); }
  bool number_integer(number_integer_t) override { return end_value(); }
  bool number_unsigned(number_unsigned_t) override { return end_value(); }
  bool number_float(number_float_t, const string_t&) override { return end_value(); }
  bool binary(binary_t&) override { return end_value(); }
  bool string(string_t& value) override { return check_text(value, "this text") && end_value(); }
  bool start_object(std::size_t) override { return enter(false); }
  bool start_array(std::size_t) override { return enter(true); }
  bool end_object() override { return leave(); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override;
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception& error) override;

  [[nodiscard]] std::vector<Violation> take_violations() { return std::move(violations_); }

 private:
  struct Level {
    bool is_array = false;
    std::size_t index = 0;
    std::string key;
    std::map<std::string, int> times_seen;
  };

  [[nodiscard]] std::string pointer() const;
  void add(std::string message) { violations_.push_back({file_, pointer(), std::move(message)}); }
  bool check_text(const std::string& text, std::string_view what);
  bool enter(bool is_array);
  bool leave();
  bool end_value();

  std::string_view text_;
  const std::string& file_;
  std::vector<Level> levels_;
  std::vector<Violation> violations_;
};

std::string SyntaxCheck::pointer() const {
  std::string result;
  for (const Level& level : levels_) {
    result = child_pointer(result, level.is_array ? std::to_string(level.index) : level.key);
  }
  return result;
}

bool SyntaxCheck::check_text(const std::string& text, std::string_view what) {
  if (text.size() > kLongestTextBytes) {
    add(std::string(what) + " is " + std::to_string(text.size()) + " bytes long; the limit is " +
        std::to_string(kLongestTextBytes));
  } else if (text.find('\0') != std::string::npos) {
    add(std::string(what) + " has a NUL character in it");
  } else {
    return true;
  }
  return false;
}

bool SyntaxCheck::key(string_t& name) {
  levels_.back().key = name.substr(0, 32);  // keeps the pointer short if the key is too long
  if (!check_text(name, "this key")) return false;
  levels_.back().key = name;
  if (++levels_.back().times_seen[name] == 2) add("this key occurs more than once");
  return true;
}

bool SyntaxCheck::enter(bool is_array) {
  if (levels_.size() >= kDeepestNesting) {
    violations_.push_back({file_, "", "it is nested more than " + std::to_string(kDeepestNesting) + " deep"});
    return false;
  }
  levels_.push_back({is_array, 0, {}, {}});
  return true;
}

bool SyntaxCheck::leave() {
  levels_.pop_back();
  return end_value();
}

bool SyntaxCheck::end_value() {
  if (!levels_.empty() && levels_.back().is_array) ++levels_.back().index;
  return true;
}

bool SyntaxCheck::parse_error(std::size_t position, const std::string& token,
                              const nlohmann::json::exception& error) {
  const std::size_t offset = position == 0 ? 0 : position - 1;
  constexpr int kOutOfRangeNumber = 406;
  const std::string sentence = error.id == kOutOfRangeNumber
                                   ? "the number " + in_quotes(token) + " is too large"
                                   : syntax_sentence(text_, offset);
  violations_.push_back({file_, "", place(text_, std::min(offset, text_.size())) + ": " + sentence});
  return false;
}

}  // namespace

std::vector<Violation> check_json_syntax(std::string_view text, const std::string& file) {
  if (text.starts_with("\xEF\xBB\xBF")) {  // The parser would skip this one without counting its columns.
    throw ConfigError({{file, "", place(text, 0) + ": there is a second byte order mark"}});
  }
  if (const auto offset = first_invalid_utf_8(text)) {
    throw ConfigError({{file, "", place(text, *offset) + ": this is not UTF-8 text"}});
  }
  SyntaxCheck check(text, file);
  const bool readable = nlohmann::json::sax_parse(text.begin(), text.end(), &check);
  std::vector<Violation> violations = check.take_violations();
  if (!readable) throw ConfigError(std::move(violations));
  return violations;
}

}  // namespace contourd
