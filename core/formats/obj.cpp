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

// A binary file has a zero within its first bytes.
constexpr std::size_t kUsualHeader = 84;

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

// Removes the number at the line's beginning and returns it; nullopt if there is no finite number.
std::optional<float> take_number(std::string_view& line) {
  std::string_view word = take_word(line);
  if (word.starts_with('+')) word.remove_prefix(1);
  float number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  // A number that is too small for a float is zero; one that is too large is none.
  if (error == std::errc::result_out_of_range &&
      std::fabs(std::strtod(std::string(word).c_str(), nullptr)) < 1)
    return 0.0F;
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

// Returns the vertex that follows the word "v"; nullopt if three finite numbers do not.
std::optional<Vertex> vertex_in(std::string_view line) {
  const auto x = take_number(line), y = take_number(line), z = take_number(line);
  return x && y && z ? std::optional(Vertex{*x, *y, *z}) : std::nullopt;
}

// True for the words that begin a curve or a free-form surface, also those of version 2 of the specification.
bool is_free_form(std::string_view word) {
  return word == "curv" || word == "surf" || word == "bzp" || word == "bsp" || word == "cdc" || word == "cdp";
}

Likeness obj_likeness(const FileStart& start) {
  std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
  if (begins_with_mark(text)) text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  // A page of the web may show the lines of an OBJ file.
  if (first == std::string_view::npos || text[first] == '<') return Likeness::None;
  if (text.substr(0, kUsualHeader).find('\0') != std::string_view::npos) return Likeness::None;
  bool any = false, all = true;
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
    if (word == "v" && vertex_in(line)) return Likeness::Likely;
    any = true;
    all = all && std::ranges::find(kObjWords, word) != kObjWords.end();
  }
  return any && all ? Likeness::Likely : Likeness::None;
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
    refuse_zeros();
    if (begins_with_mark(text_)) text_.remove_prefix(3);
    while (!text_.empty())
      read_line(next_line());
    if (model_.facets.empty()) refuse_no_faces();
    if (free_forms_ > 0)
      model_.warnings.emplace_back(
          "the OBJ file's curves or free-form surfaces are left out: export the model as a mesh");
    if (calls_ > 0)
      model_.warnings.emplace_back(
          "the files that the OBJ file includes by \"call\" are left out: export the model as one file");
    guess_up();
    return std::move(model_);
  }

 private:
  void refuse_zeros() {
    if (text_.ends_with('\0')) text_.remove_suffix(1);  // some writers end the text with one
    if (const std::size_t zero = text_.find('\0'); zero != std::string_view::npos)
      throw ModelError("the file is not whole: byte " + std::to_string(zero) +
                       " of the text is zero, as after an interrupted copy; copy it again");
  }

  [[noreturn]] void refuse_no_faces() const {
    if (free_forms_ > 0)
      throw ModelError(
          "the OBJ file has curves or free-form surfaces and no faces: export the model as a mesh");
    if (calls_ > 0)
      throw ModelError(
          "the OBJ file includes other files by \"call\" and has no faces: export the model as one file");
    throw ModelError("the OBJ file has no faces: export the model as a mesh");
  }

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
    } else if (is_free_form(word)) {
      ++free_forms_;
    } else if (word == "call") {
      ++calls_;
    }
  }

  void read_vertex(std::string_view line) {
    const std::optional<Vertex> vertex = vertex_in(line);
    if (!vertex) refuse("a vertex is not three finite numbers");
    vertices_.push_back(*vertex);
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
  std::size_t free_forms_ = 0, calls_ = 0;  // lines that are left out
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
