#include "core/formats/obj.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/formats/polygon_triangles.hpp"

namespace contourd {
namespace {

// Words that begin a line (Wavefront's specification, version 3.0, and what programs add).
constexpr auto kObjWords = std::to_array<std::string_view>(
    {"v",      "vn",     "vt",    "vp",    "f",        "fo",       "l",          "p",
     "o",      "g",      "s",     "mg",    "lod",      "bevel",    "mtllib",     "usemtl",
     "usemap", "maplib", "call",  "csh",   "cstype",   "deg",      "bmat",       "step",
     "curv",   "curv2",  "surf",  "parm",  "trim",     "hole",     "scrv",       "sp",
     "end",    "con",    "ctech", "stech", "d_interp", "c_interp", "shadow_obj", "trace_obj"});

// A facet takes at least these bytes, with its share of the vertices, beside the first thousand facets of a
// file, whose numbers are short.
constexpr std::uint64_t kLeastBytesPerFacet = 16, kFacetsOfAnyFile = 1000;
// Comparisons of corners while polygons are cut into triangles: some ten seconds.
constexpr std::int64_t kMostTests = 4'000'000'000;
// The base counts as flat if it covers this share of the model's extent.
constexpr double kBaseShare = 0.02;

// Programs of old Macs end lines with a carriage return alone.
constexpr std::string_view kLineEnds = "\n\r";

bool is_obj_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

// Returns the next word of the line and removes it; empty at the line's end.
std::string_view take_word(std::string_view& line) {
  const auto begin = std::ranges::find_if_not(line, is_obj_blank);
  const auto end = std::find_if(begin, line.end(), is_obj_blank);
  const std::string_view word(begin, end);
  line = {end, line.end()};
  return word;
}

bool ends_with_backslash(std::string_view line) {
  while (!line.empty() && is_obj_blank(line.back()))
    line.remove_suffix(1);
  return line.ends_with('\\');
}

bool begins_with_mark(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF");  // byte order mark
}

Likeness obj_likeness(const FileStart& start) {
  std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
  if (begins_with_mark(text)) text.remove_prefix(3);
  if (text.find('\0') != std::string_view::npos) return Likeness::None;
  bool any = false;
  // The last line may be cut by the end of the bytes.
  const bool is_whole = start.bytes.size() == start.file_bytes;
  bool continues = false;
  while (!text.empty()) {
    const std::size_t end = text.find_first_of(kLineEnds);
    if (end == std::string_view::npos && !is_whole) break;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty()) continue;
    const bool is_continued = std::exchange(continues, ends_with_backslash(line));
    const std::string_view word = take_word(line);
    if (word.empty() || word.starts_with('#') || is_continued) continue;
    if (std::ranges::find(kObjWords, word) == kObjWords.end()) return Likeness::None;
    any = true;
  }
  return any ? Likeness::Likely : Likeness::None;
}

ModelOutline obj_outline(const FileStart& start) {
  return {.most_facets = start.file_bytes / kLeastBytesPerFacet + kFacetsOfAnyFile,
          // A vertex line has at least eight bytes and becomes twelve.
          .buffered_bytes = start.file_bytes * 5 / 2};
}

class ObjReader {
 public:
  ObjReader(std::string_view text, std::uint64_t most_facets) : text_(text), most_facets_(most_facets) {}

  Model read() {
    if (begins_with_mark(text_)) text_.remove_prefix(3);
    while (!text_.empty())
      read_line(next_line());
    if (model_.facets.empty()) throw ModelError("the OBJ file has no faces: export the model as a mesh");
    guess_up();
    return std::move(model_);
  }

 private:
  // Returns the next line. The line of a vertex or a face that ends with a backslash continues in the next
  // one; elsewhere, such as in a comment, a backslash may be part of a folder's name.
  std::string_view next_line() {
    joined_.clear();
    while (true) {
      const std::size_t end = text_.find_first_of(kLineEnds);
      std::string_view line = text_.substr(0, end);
      const bool is_pair = end != std::string_view::npos && text_.substr(end).starts_with("\r\n");
      text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + (is_pair ? 2 : 1));
      ++line_;
      while (!line.empty() && is_obj_blank(line.back()))
        line.remove_suffix(1);
      std::string_view rest = line;
      const std::string_view word = take_word(rest);
      const bool is_read = !joined_.empty() || word == "v" || word == "f" || word == "fo";
      const bool continues = is_read && line.ends_with('\\') && !text_.empty();
      if (!continues && joined_.empty()) return line;
      joined_ += continues ? line.substr(0, line.size() - 1) : line;
      if (!continues) return joined_;
      joined_ += ' ';
    }
  }

  void read_line(std::string_view line) {
    const std::string_view word = take_word(line);
    if (word == "v") {
      read_vertex(line);
    } else if (word == "f" || word == "fo") {
      read_face(line);
    }
  }

  void read_vertex(std::string_view line) {
    std::array<float, 3> at{};
    for (float& coordinate : at) {
      std::string_view word = take_word(line);
      if (word.starts_with('+')) word.remove_prefix(1);
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), coordinate);
      // A number that is too small for a float is zero; one that is too large is refused.
      if (error == std::errc::result_out_of_range &&
          std::fabs(std::strtod(std::string(word).c_str(), nullptr)) < 1)
        coordinate = 0;
      else if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(coordinate))
        refuse("a vertex is not three finite numbers");
    }
    vertices_.push_back({at[0], at[1], at[2]});
  }

  void read_face(std::string_view line) {
    corners_.clear();
    for (std::string_view word = take_word(line); !word.empty() && word.front() != '#';
         word = take_word(line))
      corners_.push_back(vertices_[vertex_number(word)]);
    if (corners_.size() < 3) refuse("a face has fewer than three corners");
    if (!add_triangles(corners_, model_.facets, tests_))
      refuse("the faces have too many corners to be cut into triangles: export the model with triangles");
    if (model_.facets.size() > most_facets_)
      refuse("the faces have far more corners than the file has vertices: export the model with triangles");
  }

  // Returns the index for "7", "7/1", "7/1/3", "7//3" or "-1", which is the last vertex before this line.
  [[nodiscard]] std::size_t vertex_number(std::string_view word) const {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const auto count = static_cast<std::int64_t>(vertices_.size());
    const bool is_number = error == std::errc{} && (end == word.data() + word.size() || *end == '/');
    const std::int64_t index = number < 0 ? count + number : number - 1;
    if (!is_number || number == 0 || index < 0 || index >= count)
      refuse("a face names a vertex that is not among the " + std::to_string(count) + " before it");
    return static_cast<std::size_t>(index);
  }

  // Compares the flat faces at the lowest z and at the lowest y. OBJ has no axis that points up.
  void guess_up() {
    const Bounds bounds = bounds_of(model_.facets);
    double base_z = 0, base_y = 0;
    for (const Facet& facet : model_.facets) {
      const auto& [a, b, c] = facet.vertices;
      if (a.z == b.z && b.z == c.z && a.z == bounds.min_z) base_z += twice_area(facet) / 2;
      if (a.y == b.y && b.y == c.y && a.y == bounds.min_y) base_y += twice_area(facet) / 2;
    }
    const bool has_base_z = base_z > kBaseShare * bounds.size_x() * bounds.size_y();
    const bool has_base_y = base_y > kBaseShare * bounds.size_x() * bounds.size_z();
    model_.y_is_up = has_base_y && !has_base_z;
    model_.warnings.push_back(model_.y_is_up ? "an OBJ file does not say which way is up: the model has a "
                                               "flat base at its lowest y, so y is up, "
                                               "unless \"up\" in the ticket says otherwise"
                                             : "an OBJ file does not say which way is up: z is up, unless "
                                               "\"up\" in the ticket says otherwise");
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw ModelError("line " + std::to_string(line_) + ": " + what);
  }

  std::string_view text_;  // the rest of the text
  std::uint64_t most_facets_;
  std::size_t line_ = 0;
  std::string joined_;
  std::vector<Vertex> vertices_;
  std::vector<Vertex> corners_;
  std::int64_t tests_ = kMostTests;
  Model model_;
};

Model read_obj(const FileStart& start, const ReadBytes& read) {
  std::vector<std::byte> data(start.file_bytes);
  read(data);
  return ObjReader({reinterpret_cast<const char*>(data.data()), data.size()}, obj_outline(start).most_facets)
      .read();
}

}  // namespace

constinit const ModelFormat kObj{"obj", obj_likeness, obj_outline, read_obj};

}  // namespace contourd
