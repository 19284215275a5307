#include "core/formats/stl_ascii.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace contourd {
namespace {

// A word of the file that is quoted in an error is cut to this many characters.
constexpr std::size_t kQuoteLimit = 24;

// Words without meaning are skipped up to this many in a row.
constexpr int kMaxIgnoredWords = 16;

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // the UTF-8 one

// The words that a facet cannot do without, and white space after each.
constexpr std::string_view kShortestFacet =
    "facet outer loop vertex 0 0 0 vertex 0 0 0 vertex 0 0 0 endloop endfacet ";

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}
bool is_line_end(char c) {
  return c == '\n' || c == '\r';
}

bool same_word(std::string_view word, std::string_view lower_case) {
  if (word.size() != lower_case.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char c = word[i];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != lower_case[i]) return false;
  }
  return true;
}

// The words that end a part of the file. Some writers put a blank after "end".
constexpr std::array<std::string_view, 3> kEndWords{"endloop", "endfacet", "endsolid"};
constexpr std::string_view kEnd = "end";

// Splits the text into words; finds the line for error messages. Comments (from a word that begins with # to
// the end of the line) count as blanks.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  // Returns the next word; empty at the end of the text. "end loop" is returned as "endloop".
  std::string_view next() {
    const std::string_view word = next_as_written();
    return same_word(word, kEnd) ? joined_to_end(word) : word;
  }

  void skip_line() {
    while (at_ < text_.size() && !is_line_end(text_[at_]))
      ++at_;
  }

  // Returns the current line, counted on demand: most files have no error. A line ends with LF, CR LF or CR
  // alone.
  [[nodiscard]] std::size_t line() const {
    std::size_t lines = 1;
    for (std::size_t i = 0; i < at_ && i < text_.size(); ++i) {
      const bool carriage_return_alone = text_[i] == '\r' && (i + 1 >= text_.size() || text_[i + 1] != '\n');
      if (text_[i] == '\n' || carriage_return_alone) ++lines;
    }
    return lines;
  }

 private:
  std::string_view next_as_written() {
    skip_blank();
    const std::size_t start = at_;
    while (at_ < text_.size() && !is_space(text_[at_]))
      ++at_;
    return text_.substr(start, at_ - start);
  }

  std::string_view joined_to_end(std::string_view end) {
    const std::size_t after_end = at_;
    const std::string_view second = next_as_written();
    for (const std::string_view word : kEndWords)
      if (same_word(second, word.substr(kEnd.size()))) return word;
    at_ = after_end;
    return end;
  }

  void skip_blank() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        skip_line();
      } else if (is_space(text_[at_])) {
        ++at_;
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// Returns a word of the file made fit to print: cut short, and without control characters or invalid UTF-8.
std::string quoted(std::string_view word) {
  if (word.empty()) return "the end of the file";
  std::string text = "\"";
  for (const char c : word.substr(0, kQuoteLimit))
    text += c > ' ' && c < '\x7F' ? c : '?';
  return text + (word.size() > kQuoteLimit ? "...\"" : "\"");
}

class AsciiReader {
 public:
  explicit AsciiReader(std::string_view text) : words_(text) {}

  Model read() {
    std::string_view word;
    while (!(word = words_.next()).empty()) {
      if (same_word(word, "facet")) {
        read_facet();
      } else if (same_word(word, "solid")) {
        in_solid_ = true;
        words_.skip_line();  // the solid's name, which may contain any word
      } else if (same_word(word, "endsolid")) {
        in_solid_ = false;
        words_.skip_line();
      } else if (text_after_facet_ > 0) {
        --text_after_facet_;
      } else {
        refuse("expected \"facet\" or \"endsolid\", found " + quoted(word));
      }
    }
    if (in_solid_ && model_.facets.empty())
      refuse("the file ends after \"solid\", without a facet or an \"endsolid\"");
    if (in_solid_)
      refuse("the file is cut short: it has no \"endsolid\" at its end; copy or export it again");
    return std::move(model_);
  }

 private:
  void read_facet() {
    skip_to("outer");
    expect("loop");
    Facet facet{};
    for (Vertex& vertex : facet.vertices) {
      expect("vertex");
      vertex = {read_coordinate(), read_coordinate(), read_coordinate()};
    }
    expect("endloop");
    skip_to("endfacet");  // some writers put text after the end words
    text_after_facet_ = kMaxIgnoredWords;
    model_.facets.push_back(facet);
  }

  // Skips words without meaning up to the given one: a normal (never trusted, so it may be missing, garbage
  // or NaN), or text after an end word.
  void skip_to(std::string_view lower_case) {
    for (int i = 0; i < kMaxIgnoredWords; ++i) {
      const std::string_view word = words_.next();
      if (same_word(word, lower_case)) return;
      if (word.empty())
        refuse("the file is cut short inside a facet: expected \"" + std::string(lower_case) + "\"");
    }
    refuse("found no \"" + std::string(lower_case) + "\" in a facet");
  }

  void expect(std::string_view lower_case) {
    const std::string_view word = words_.next();
    if (same_word(word, lower_case)) return;
    const std::string expected = "expected \"" + std::string(lower_case) + "\", found " + quoted(word);
    if (word.empty()) refuse("the file is cut short inside a facet: " + expected);
    refuse(expected);
  }

  float read_coordinate() {
    const std::string_view word = words_.next();
    if (word.empty()) refuse("the file is cut short inside a facet: expected a coordinate");
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    const std::string_view number = plus ? word.substr(1) : word;
    float value = 0;
    const auto [end, code] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (code == std::errc::result_out_of_range && end == number.data() + number.size()) {
      return out_of_float_range(word, number);
    }
    if (code != std::errc() || end != number.data() + number.size()) {
      refuse("a coordinate is not a number: " + quoted(word));
    }
    if (!std::isfinite(value)) refuse("a coordinate is not a finite number: " + quoted(word));
    return value;
  }

  // Returns the nearest float of a number that is too small for one; refuses a number that is too large.
  float out_of_float_range(std::string_view word, std::string_view number) {
    double wide = 0;
    const bool beyond_double =
        std::from_chars(number.data(), number.data() + number.size(), wide).ec != std::errc();
    const bool negative_exponent =
        number.find_first_of("eE") != std::string_view::npos && number[number.find_first_of("eE") + 1] == '-';
    const bool tiny = beyond_double ? negative_exponent : std::fabs(wide) < 1.0;
    if (!tiny) refuse("a coordinate is too large for STL: " + quoted(word));
    return static_cast<float>(wide);
  }

  [[noreturn]] void refuse(const std::string& why) const {
    throw ModelError("line " + std::to_string(words_.line()) + ": " + why);
  }

  Words words_;
  Model model_;
  bool in_solid_ = false;
  int text_after_facet_ = 0;  // words still allowed after an "endfacet"
};

bool starts_with_ignoring_case(std::string_view text, std::string_view lower_case_word) {
  return same_word(text.substr(0, lower_case_word.size()), lower_case_word);
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A binary file of an ordinary size has a NUL within its first bytes: the highest byte of its facet count.
constexpr std::size_t kBinaryHeaderBytes = 84;

// Recognises ASCII STL. After any comments it begins with `solid` or, without a solid line, with a facet.
// Text never holds a NUL, but an interrupted copy may leave some after it.
Likeness ascii_likeness(const FileStart& start) {
  std::string_view text = as_text(start.bytes);
  if (text.substr(0, kBinaryHeaderBytes).find('\0') != std::string_view::npos) return Likeness::None;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const std::string_view word = Words(text).next();
  const bool is_stl = starts_with_ignoring_case(word, "solid") || starts_with_ignoring_case(word, "facet");
  return is_stl ? Likeness::Likely : Likeness::None;
}

ModelOutline ascii_outline(const FileStart& start) {
  // White space after the last facet may be missing.
  return {.most_facets = (start.file_bytes + 1) / kShortestFacet.size(), .buffered_bytes = start.file_bytes};
}

Model read_ascii(const FileStart& start, const ReadBytes& read) {
  std::vector<std::byte> all(start.file_bytes);
  read(all);
  std::string_view text = as_text(all);
  // Some writers end the text with a NUL. After an interrupted copy "endsolid" is missing before the NULs.
  text = text.substr(0, text.find_last_not_of('\0') + 1);
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    throw ModelError("the file is not whole: byte " + std::to_string(zero) +
                     " of the text is zero, as after an interrupted copy; copy it again");
  }
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return AsciiReader(text).read();
}

}  // namespace

constinit const ModelFormat kAsciiStl{"ascii", ascii_likeness, ascii_outline, read_ascii};

}  // namespace contourd
