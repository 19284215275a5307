#include "core/formats/model_reader.hpp"

#include <sys/stat.h>

#include <clocale>
#include <locale>

#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace {

constexpr std::size_t kCountOffset = 80;
constexpr std::size_t kFirstFacet = 84;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kFirstVertex = kFirstFacet + 12;  // after the normal

models::Facets tetrahedron() {
  const Vertex o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {{{o, y, x}}, {{o, x, z}}, {{o, z, y}}, {{x, y, z}}};
}

std::vector<std::byte> binary() {
  return models::to_binary_stl(tetrahedron());
}

template <typename Value>
void put(std::vector<std::byte>& bytes, std::size_t offset, Value value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

std::vector<std::byte> binary_claiming(std::uint32_t count) {
  std::vector<std::byte> bytes = binary();
  put(bytes, kCountOffset, count);
  return bytes;
}

void append(std::vector<std::byte>& bytes, std::size_t count, std::byte value = std::byte{0xA5}) {
  bytes.insert(bytes.end(), count, value);
}

Model read_text(std::string_view text) {
  return read_model(std::as_bytes(std::span(text)));
}

// Returns the error message for the data; empty if it is accepted.
std::string refusal_of(std::span<const std::byte> bytes) {
  return testing::message_of<ModelError>([&] { (void)read_model(bytes); });
}
std::string refusal_of(std::string_view text) {
  return refusal_of(std::as_bytes(std::span(text)));
}

// Returns the outline of a file with these bytes.
ModelOutline outline_of(std::span<const std::byte> bytes) {
  return outline_of_model({bytes.size(), bytes.first(std::min(bytes.size(), kSniffBytes))});
}
ModelOutline outline_of(std::string_view bytes) {
  return outline_of(std::as_bytes(std::span(bytes)));
}

bool same(std::span<const Facet> a, std::span<const Facet> b) {
  return std::ranges::equal(a, b, [](const Facet& f, const Facet& g) { return f.vertices == g.vertices; });
}

// Checks that a file was read as these facets, without a warning.
void check_read(const Model& model, const models::Facets& facets = tetrahedron()) {
  CHECK(model.warnings.empty());
  CHECK(same(model.facets, facets));
}

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// A facet: lines 2 to 8 of the file.
std::string one_facet(std::string_view first_vertex = "vertex 1 2 3",
                      std::string_view normal = "normal 0 0 1") {
  return "solid one\nfacet " + std::string(normal) + "\nouter loop\n" + std::string(first_vertex) +
         "\nvertex 4 5 6\nvertex 7 8 10\nendloop\nendfacet\nendsolid one\n";
}

const models::Facets kOneFacet{{{Vertex{1, 2, 3}, Vertex{4, 5, 6}, Vertex{7, 8, 10}}}};

// Returns the first coordinate of a file in which it is spelled like this.
float coordinate(const std::string& spelling) {
  return read_text(one_facet("vertex " + spelling + " 2 3")).facets.at(0).vertices[0].x;
}

}  // namespace

TEST_CASE("A binary file's facets are read in their order") {
  CHECK(outline_of(binary()).format == "binary");
  check_read(read_model(binary()));
}

TEST_CASE("A file of exactly 84 + 50 n bytes is binary whatever its header says") {
  std::vector<std::byte> bytes = binary();
  const std::string_view header = "solid cube\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n";
  std::memcpy(bytes.data(), header.data(), header.size());
  std::memset(bytes.data() + header.size(), ' ', kCountOffset - header.size());
  CHECK(outline_of(bytes).format == "binary");
  check_read(read_model(bytes));
}

TEST_CASE("A binary header may hold any bytes") {
  std::vector<std::byte> bytes = binary();
  for (std::size_t i = 0; i < kCountOffset; ++i)
    bytes[i] = static_cast<std::byte>(0x80 + i);
  CHECK(same(read_model(bytes).facets, tetrahedron()));
}

TEST_CASE("A unit in the header or the first line is read, but not applied") {
  const auto unit_of = [](std::string_view header) {
    std::vector<std::byte> bytes = binary();
    std::memcpy(bytes.data(), header.data(), header.size());
    CHECK(read_model(bytes).facets[0].vertices[1].y == 1);
    return read_model(bytes).unit;
  };
  CHECK(unit_of("COLOR=abcd,MATERIAL=x UNITS=in") == LengthUnit::Inch);
  CHECK(unit_of("UNITS=mm, made by hand") == LengthUnit::Millimeter);
  CHECK(unit_of("UNITS=Meters\n") == LengthUnit::Meter);
  CHECK(unit_of("made by hand, units = cm") == LengthUnit::Centimeter);
  CHECK(unit_of("Units of length: UNITS= Inches") == LengthUnit::Inch);
  CHECK_FALSE(unit_of("UNITS"));
  CHECK_FALSE(unit_of("UNITS = "));
  CHECK_FALSE(unit_of("UNITS=furlong"));
  CHECK_FALSE(unit_of("UNITS="));
  CHECK_FALSE(unit_of("inches"));
  // The header ends after 80 bytes, where the count and the facets begin.
  CHECK_FALSE(unit_of(std::string(76, ' ') + "UNIT"));
  const std::string text = models::to_ascii_stl(tetrahedron());
  const std::string named = "solid part UNITS=cm" + text.substr(text.find('\n'));
  CHECK(read_model(std::as_bytes(std::span(named))).unit == LengthUnit::Centimeter);
  CHECK_FALSE(read_model(std::as_bytes(std::span(text))).unit);
}

TEST_CASE("Attributes and normals of any value do not matter") {
  std::vector<std::byte> bytes = binary();
  for (std::size_t facet = 0; facet < 4; ++facet) {
    put(bytes, kFirstFacet + facet * kFacetBytes, std::numeric_limits<float>::quiet_NaN());
    put(bytes, kFirstFacet + facet * kFacetBytes + 48, std::uint16_t{0xFFFF});
  }
  check_read(read_model(bytes));
}

TEST_CASE("A count larger than the file is corrected with a warning and never allocated") {
  for (const std::uint32_t claimed : {5U, 66U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    CAPTURE(claimed);
    const Model model = read_model(binary_claiming(claimed));
    CHECK(same(model.facets, tetrahedron()));
    CHECK(model.facets.capacity() == 4);
    REQUIRE(model.warnings.size() == 1);
    CHECK(lacking(model.warnings[0], {std::to_string(claimed), "holds 4"}) == "");
  }
}

TEST_CASE("A count of 0 before whole facets is corrected with a warning") {
  const Model model = read_model(binary_claiming(0));
  CHECK(same(model.facets, tetrahedron()));
  CHECK(model.warnings.size() == 1);
}

TEST_CASE("A count smaller than the file ends the model there with a warning") {
  const Model model = read_model(binary_claiming(2));
  const models::Facets whole = tetrahedron();
  CHECK(same(model.facets, std::span(whole).first(2)));
  REQUIRE(model.warnings.size() == 1);
  CHECK(lacking(model.warnings[0], {"100 more bytes"}) == "");
}

TEST_CASE("Bytes after the last facet are ignored with a warning") {
  for (const std::size_t surplus : {std::size_t{1}, std::size_t{49}, std::size_t{50}, std::size_t{1000}}) {
    CAPTURE(surplus);
    std::vector<std::byte> bytes = binary();
    append(bytes, surplus);
    const Model model = read_model(bytes);
    CHECK(same(model.facets, tetrahedron()));
    REQUIRE(model.warnings.size() == 1);
    CHECK(lacking(model.warnings[0], {std::to_string(surplus) + " more bytes"}) == "");
  }
}

TEST_CASE("A binary file cut anywhere within a facet is refused") {
  for (std::size_t size = kFirstFacet + 1; size < kFirstFacet + 4 * kFacetBytes; ++size) {
    if ((size - kFirstFacet) % kFacetBytes == 0) continue;
    CAPTURE(size);
    std::vector<std::byte> bytes = binary();
    bytes.resize(size);
    const std::string refusal = refusal_of(bytes);
    CHECK(lacking(refusal, {"cut short", "4 facets",
                            std::to_string((size - kFirstFacet) / kFacetBytes) + " whole facets"}) == "");
  }
}

TEST_CASE("A file too short for a binary header is refused unless it is text") {
  for (std::size_t size = 1; size < kFirstFacet; ++size) {
    CAPTURE(size);
    std::vector<std::byte> bytes = binary();
    bytes.resize(size);
    CHECK(lacking(refusal_of(bytes), {std::to_string(size) + " bytes", "not an STL file"}) == "");
  }
}

TEST_CASE("A binary header without facets is an empty model") {
  CHECK(outline_of(models::to_binary_stl({})).format == "binary");
  const Model model = read_model(models::to_binary_stl({}));
  CHECK(model.facets.empty());
  CHECK(model.warnings.empty());
}

TEST_CASE("Facets followed by as many bytes as their attribute count says are refused") {
  const std::vector<std::byte> source = binary();
  std::vector<std::byte> bytes(source.begin(), source.begin() + kFirstFacet);
  for (std::size_t facet = 0; facet < 4; ++facet) {
    const auto begin = source.begin() + static_cast<std::ptrdiff_t>(kFirstFacet + facet * kFacetBytes);
    bytes.insert(bytes.end(), begin, begin + static_cast<std::ptrdiff_t>(kFacetBytes));
    const auto attribute_bytes = static_cast<std::uint16_t>(facet + 1);
    put(bytes, bytes.size() - 2, attribute_bytes);
    append(bytes, attribute_bytes);
  }
  CHECK(lacking(refusal_of(bytes), {"attribute", "byte 132"}) == "");
}

TEST_CASE("A binary coordinate that is not finite is refused with its facet and byte") {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity}) {
    for (std::size_t coordinate_index = 0; coordinate_index < 9; ++coordinate_index) {
      CAPTURE(bad, coordinate_index);
      std::vector<std::byte> bytes = binary();
      put(bytes, kFirstVertex + 2 * kFacetBytes + 4 * coordinate_index, bad);
      CHECK(lacking(refusal_of(bytes), {"facet 3 ", "byte 184"}) == "");
    }
  }
}

TEST_CASE("Infinities of both signs in one facet do not cancel") {
  std::vector<std::byte> bytes = binary();
  put(bytes, kFirstVertex, std::numeric_limits<float>::infinity());
  put(bytes, kFirstVertex + 4, -std::numeric_limits<float>::infinity());
  CHECK(lacking(refusal_of(bytes), {"facet 1 "}) == "");
}

TEST_CASE("The largest finite coordinates are kept") {
  constexpr float kLargest = std::numeric_limits<float>::max();
  models::Facets facets = tetrahedron();
  facets[1].vertices[0] = {kLargest, -kLargest, std::numeric_limits<float>::denorm_min()};
  CHECK(same(read_model(models::to_binary_stl(facets)).facets, facets));
}

TEST_CASE("A file in which several facets or the last one are zeros is refused as not whole") {
  const auto refusal_with_zeros = [](std::size_t first, std::size_t count) {
    std::vector<std::byte> bytes = models::to_binary_stl(models::Facets(10, tetrahedron()[0]));
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(kFirstFacet + first * kFacetBytes),
                count * kFacetBytes, std::byte{});
    return refusal_of(bytes);
  };
  for (const std::size_t first : {0U, 1U, 6U}) {
    CAPTURE(first);
    const std::string place = "facet " + std::to_string(first + 1) + " (byte " +
                              std::to_string(kFirstFacet + first * kFacetBytes) + ")";
    CHECK(lacking(refusal_with_zeros(first, 4), {"not whole", place, "zeros", "copy it again"}) == "");
  }
  CHECK(refusal_with_zeros(3, 3).empty());
  CHECK(lacking(refusal_with_zeros(9, 1), {"facet 10 "}) == "");
  CHECK(lacking(refusal_with_zeros(7, 3), {"facet 8 "}) == "");
}

TEST_CASE("Single facets at the origin are read") {
  models::Facets facets(10, tetrahedron()[0]);
  for (std::size_t i = 0; i < 10; i += 2)
    facets[i] = {};
  CHECK(same(read_model(models::to_binary_stl(facets)).facets, facets));
}

TEST_CASE("Facets beyond one read chunk keep their order") {
  models::Facets facets;
  for (int i = 0; i < 10'000; ++i) {
    const auto x = static_cast<float>(i);
    facets.push_back({{Vertex{x, 0, 0}, Vertex{x, 1, 0}, Vertex{x, 0, 1}}});
  }
  CHECK(same(read_model(models::to_binary_stl(facets)).facets, facets));
}

TEST_CASE("Any model survives both formats bit for bit") {
  CHECK(rc::check([] {
    models::Facets facets(static_cast<std::size_t>(testing::draw(1, 20)));
    for (Facet& facet : facets)
      facet = testing::draw_facet(500);
    RC_ASSERT(same(read_model(models::to_binary_stl(facets)).facets, facets));
    RC_ASSERT(same(read_text(models::to_ascii_stl(facets)).facets, facets));
  }));
}

TEST_CASE("Any bytes are either read or refused") {
  CHECK(rc::check([] {
    std::vector<std::byte> bytes = testing::draw(0, 1) == 0 ? binary() : [] {
      const std::string text = models::to_ascii_stl(tetrahedron());
      const auto all = std::as_bytes(std::span(text));
      return std::vector<std::byte>(all.begin(), all.end());
    }();
    for (std::int64_t i = testing::draw(1, 8); i > 0; --i) {
      const auto last = static_cast<std::int64_t>(bytes.size()) - 1;
      bytes[static_cast<std::size_t>(testing::draw(0, last))] = static_cast<std::byte>(testing::draw(0, 255));
    }
    bytes.resize(static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(bytes.size()))));
    try {
      for (const Facet& facet : read_model(bytes).facets) {
        for (const Vertex& v : facet.vertices) {
          RC_ASSERT(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z));
        }
      }
    } catch (const ModelError& error) {
      RC_ASSERT(std::strlen(error.what()) > 10);
    }
  }));
}

TEST_CASE("An ASCII file's facets are read") {
  CHECK(outline_of(models::to_ascii_stl(tetrahedron())).format == "ascii");
  check_read(read_text(models::to_ascii_stl(tetrahedron())));
}

TEST_CASE("ASCII keywords may be in any case") {
  const std::string text = models::to_ascii_stl(tetrahedron());
  std::string upper = text;
  for (char& c : upper)
    c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  CHECK(same(read_text(upper).facets, tetrahedron()));
  CHECK(
      same(read_text(replaced(replaced(text, "facet", "Facet"), "vertex", "vErTeX")).facets, tetrahedron()));
}

TEST_CASE("The words that end a part of an ASCII file may have a blank after end") {
  const std::string text = replaced(models::to_ascii_stl(tetrahedron()), "end", "End ");
  check_read(read_text(text));
  CHECK(lacking(refusal_of(replaced(one_facet(), "endloop", "end vertex")), {"line 7", "found \"end\""}) ==
        "");
}

TEST_CASE("Any line ends, a byte order mark, and blanks and comments between words are read over") {
  const std::string text = models::to_ascii_stl(tetrahedron());
  for (const char* line_end : {"\r\n", "\r", "\n\n", "\r\n\r\n", " \t\v\f\n", " # endsolid facet 1 2 3\n"}) {
    CAPTURE(line_end);
    check_read(read_text(replaced(text, "\n", line_end)));
  }
  for (const char* start : {"\n\n  \t", "\xEF\xBB\xBF", "\xEF\xBB\xBF\r\n ", "# made by hand\n"}) {
    CAPTURE(start);
    CHECK(same(read_text(start + text).facets, tetrahedron()));
  }
}

TEST_CASE("A solid's name may hold any words") {
  const std::string text = one_facet();
  for (const char* name : {"", " ", " facet normal 0 0 1 outer loop vertex 1 2 3", " solid endsolid endfacet",
                           " \xC4\x8D\xC5\x99 \xFF\xFE", " # hash"}) {
    CAPTURE(name);
    check_read(read_text(replaced(replaced(text, "endsolid one", "endsolid" + std::string(name)), "solid one",
                                  "solid" + std::string(name))),
               kOneFacet);
  }
  CHECK(same(read_text(replaced(text, "solid one", "solid " + std::string(5000, 'n'))).facets, kOneFacet));
}

TEST_CASE("Text after the end words is ignored") {
  std::string text = replaced(one_facet(), "endloop", "endloop and more");
  text = replaced(replaced(text, "endfacet", "endfacet 1 vertex"), "endsolid one", "endsolid other facet");
  CHECK(same(read_text(text).facets, kOneFacet));
}

TEST_CASE("A normal may be missing or be garbage") {
  for (const char* normal : {"", "normal", "normal nan NaN -nan", "normal -1.#IND 1.#QNAN inf",
                             "normal 0,5 0,5 0", "normal 1e999 -1e999 x", "normal 0 0 1 0 0 1"}) {
    CAPTURE(normal);
    CHECK(same(read_text(one_facet("vertex 1 2 3", normal)).facets, kOneFacet));
  }
}

TEST_CASE("A facet whose loop never begins is refused") {
  CHECK(lacking(refusal_of(replaced(one_facet(), "outer loop", "")), {"\"outer\""}) == "");
}

TEST_CASE("ASCII numbers are read in all their spellings") {
  CHECK(coordinate("+1.0E+00") == 1.0F);
  CHECK(coordinate("-1.5e-3") == -1.5e-3F);
  CHECK(coordinate(".5") == 0.5F);
  CHECK(coordinate("5.") == 5.0F);
  CHECK(coordinate("00012") == 12.0F);
  CHECK(coordinate("1.00000000000000000000000000001") == 1.0F);
  CHECK(coordinate("0.1") == 0.1F);
  CHECK(coordinate("3.4028234e38") == std::numeric_limits<float>::max());
  CHECK(coordinate("-0") == 0.0F);
}

TEST_CASE("An ASCII number too small for STL is zero") {
  for (const char* tiny : {"1e-60", "-1e-60", "+1E-60", "1e-400", "-1e-99999",
                           "0.00000000000000000000000000000000000000000000000000000000001"}) {
    CAPTURE(tiny);
    CHECK(coordinate(tiny) == 0.0F);
  }
}

TEST_CASE("An ASCII number too large for STL is refused with its line") {
  for (const char* huge : {"1e60", "-1e60", "3.5e38", "1e400", "-1E+99999"}) {
    CAPTURE(huge);
    CHECK(lacking(refusal_of(one_facet("vertex " + std::string(huge) + " 2 3")),
                  {"line 4", "too large", huge}) == "");
  }
}

TEST_CASE("An ASCII coordinate that is not a finite number is refused with its line") {
  for (const char* bad : {"nan", "-nan", "inf", "-INF", "infinity", "1,5", "0x10", "1e", "1.2.3", "--1",
                          "+-1", "abc", "1_000", "+", "-", "."}) {
    CAPTURE(bad);
    CHECK(lacking(refusal_of(one_facet("vertex 1 " + std::string(bad) + " 3")), {"line 4", bad}) == "");
  }
}

TEST_CASE("The words that Windows writes for infinities and NaN are refused in every place") {
  for (const char* bad : {"-1.#IND", "1.#QNAN", "1.#INF"}) {
    CAPTURE(bad);
    CHECK_FALSE(refusal_of(one_facet("vertex " + std::string(bad) + " 2 3")).empty());
    CHECK_FALSE(refusal_of(one_facet("vertex 1 2 " + std::string(bad))).empty());
  }
}

TEST_CASE("A facet with four vertices is refused with the line of the fourth") {
  const std::string text = replaced(one_facet(), "vertex 7 8 10\n", "vertex 7 8 10\nvertex 9 9 9\n");
  CHECK(lacking(refusal_of(text), {"line 7", "endloop"}) == "");
}

TEST_CASE("A facet with two vertices or a vertex with two or four coordinates is refused") {
  CHECK(lacking(refusal_of(replaced(one_facet(), "vertex 7 8 10\n", "")), {"line 6", "vertex"}) == "");
  CHECK(lacking(refusal_of(one_facet("vertex 1 2")), {"line 5", "not a number"}) == "");
  CHECK(lacking(refusal_of(one_facet("vertex 1 2 3 4")), {"line 4", "\"4\""}) == "");
}

TEST_CASE("An ASCII file cut anywhere within a facet is refused") {
  const std::string text = one_facet();
  const std::size_t begin = text.find("facet normal") + std::strlen("facet");
  // After "vertex 7 8 1" the cut number is still a number; the words after it are missing.
  const std::size_t end = text.find("endfacet") + std::strlen("endfacet");
  for (std::size_t size = begin; size < end; ++size) {
    CAPTURE(size);
    CHECK_FALSE(refusal_of(std::string_view(text).substr(0, size)).empty());
  }
}

TEST_CASE("A file cut within a vertex is refused with that vertex's line") {
  for (const char* line_end : {"\n", "\r\n", "\r"}) {
    const std::string text = replaced(one_facet(), "\n", line_end);
    const std::string cut = text.substr(0, text.find("5 6"));
    CHECK(lacking(refusal_of(cut), {"line 5", "cut short"}) == "");
  }
}

TEST_CASE("Several solids in one file are one model") {
  const Model model = read_text(one_facet() + one_facet() + "solid empty\nendsolid empty\n" + one_facet());
  CHECK(model.facets.size() == 3);
  CHECK(model.warnings.empty());
}

TEST_CASE("A solid within a solid and a facet without any solid are read") {
  CHECK(same(read_text("solid outer\n" + one_facet() + "endsolid outer\n").facets, kOneFacet));
  const std::string text = one_facet();
  const std::size_t begin = text.find("facet");
  CHECK(same(read_text(text.substr(begin, text.find("endsolid") - begin)).facets, kOneFacet));
}

TEST_CASE("An ASCII file without its last endsolid is refused as cut short") {
  const std::string text = one_facet() + one_facet();
  const std::string cut = text.substr(0, text.rfind("endsolid"));
  CHECK(lacking(refusal_of(cut), {"line 18", "cut short", "endsolid", "copy or export it again"}) == "");
  CHECK(lacking(refusal_of(cut + "endsol"), {"cut short"}) == "");
  CHECK(lacking(refusal_of(cut + std::string(100, '\0')), {"cut short"}) == "");
}

TEST_CASE("NULs after the end of an ASCII file are ignored, and NULs within it refused") {
  const std::string text = one_facet();
  CHECK(same(read_text(text + std::string(3, '\0')).facets, kOneFacet));
  std::string holed = text + text;
  holed.replace(text.size() + 20, 30, 30, '\0');
  CHECK(lacking(refusal_of(holed),
                {"not whole", "byte " + std::to_string(text.size() + 20), "zero", "copy it again"}) == "");
}

TEST_CASE("A solid without facets is an empty model if it ends and is refused if it does not") {
  CHECK(read_text("solid empty\nendsolid empty").facets.empty());
  CHECK_FALSE(refusal_of("solid").empty());
  CHECK_FALSE(refusal_of("solid a rest of a name").empty());
}

TEST_CASE("A strange word in an ASCII file is refused and quoted fit to print") {
  CHECK(lacking(refusal_of("solid x\n vertex 1 2 3\n"), {"line 2", "\"vertex\""}) == "");
  const std::string refusal = refusal_of("solid x\n\x01\xFF" + std::string(100, 'a') + "\n");
  CHECK(lacking(refusal, {"\"??aaaa", "...\""}) == "");
  CHECK(refusal.size() < 100);
}

TEST_CASE("Numbers are read alike in a locale whose decimal point is a comma") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::string old_c_locale = std::setlocale(LC_ALL, nullptr);
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new Comma));
  // Tested if such a locale is installed, for the C library's functions too.
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  const float point = coordinate("1.5");
  const std::string comma = refusal_of(one_facet("vertex 1,5 2 3"));
  std::locale::global(old);
  std::setlocale(LC_ALL, old_c_locale.c_str());
  CHECK(point == 1.5F);
  CHECK_FALSE(comma.empty());
}

TEST_CASE("An empty file is refused") {
  CHECK(lacking(refusal_of(std::span<const std::byte>{}), {"empty"}) == "");
  const testing::TemporaryFolder folder;
  CHECK_THROWS_AS((void)read_model_file(folder.write("empty.stl", "")), ModelError);
}

TEST_CASE("A file on disk is read like its bytes") {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "part.stl";
  models::write_binary_stl(path, tetrahedron());
  CHECK(same(read_model_file(path).facets, tetrahedron()));
  // A text longer than the part by which the format is recognised.
  models::Facets box = models::box({0, 0, 0}, {20, 20, 20});
  CHECK(same(read_model_file(folder.write("part.txt", models::to_ascii_stl(box))).facets, box));
}

TEST_CASE("A name that is not ASCII does not matter") {
  const testing::TemporaryFolder folder;
  CHECK(same(read_model_file(folder.write("Ger\xC3\xA4t \xC4\x8D\xC5\x99.stl", one_facet())).facets,
             kOneFacet));
}

TEST_CASE("A path that is not a readable regular file is a system error that names the path") {
  const testing::TemporaryFolder folder;
  const auto code_of = [](const std::filesystem::path& path) {
    try {
      (void)read_model_file(path);
    } catch (const std::system_error& error) {
      CHECK(lacking(error.what(), {path.string()}) == "");
      return error.code();
    }
    return std::error_code{};
  };
  CHECK(code_of(folder.path() / "missing.stl") == std::errc::no_such_file_or_directory);
  CHECK(code_of(folder.path() / "missing" / "part.stl") == std::errc::no_such_file_or_directory);
  CHECK(code_of(folder.path()) == std::errc::is_a_directory);
  CHECK(code_of("/dev/null") == std::errc::invalid_argument);
  CHECK_THROWS_WITH((void)read_model_file("/dev/null"), "cannot read /dev/null: it is not a regular file");
}

TEST_CASE("A named pipe is refused without waiting for its writer") {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "pipe.stl";
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  // A reader that opened the pipe would wait forever; the test's time limit would end the wait.
  CHECK_THROWS_AS((void)read_model_file(path), std::system_error);
}

TEST_CASE("An ASCII file may have all its facets in one line") {
  std::string text = models::to_ascii_stl(models::box({0, 0, 0}, {1, 2, 3}));
  const std::size_t first_line = text.find('\n');
  std::replace(text.begin() + static_cast<std::ptrdiff_t>(first_line) + 1, text.end(), '\n', ' ');
  CHECK(read_model(std::as_bytes(std::span(text))).facets.size() == 12);
}

namespace {

std::string refused_outline(const std::vector<std::byte>& bytes) {
  return testing::message_of<ModelError>([&] { (void)outline_of(bytes); });
}

}  // namespace

TEST_CASE("A binary file's outline has the facets that reading it gives, whatever its header claims") {
  for (const std::uint32_t claimed : {0U, 1U, 3U, 4U, 5U, 1000U, 0xFFFFFFFFU}) {
    const std::vector<std::byte> bytes = binary_claiming(claimed);
    CHECK(outline_of(bytes).most_facets == read_model(bytes).facets.size());
    CHECK(outline_of(bytes).format == "binary");
  }
  // Only if there are bytes after the facets is the whole file in memory.
  CHECK(outline_of(binary()).buffered_bytes == 0);
  CHECK(outline_of(binary_claiming(1000)).buffered_bytes == 0);
  CHECK(outline_of(binary_claiming(3)).buffered_bytes == 200);
}

TEST_CASE("An outline refuses bad sizes and first bytes in the same words as reading does") {
  std::vector<std::byte> cut = binary_claiming(0xFFFFFFFF);
  append(cut, 7);
  CHECK(refused_outline(cut) == refusal_of(cut));
  CHECK_FALSE(refusal_of(cut).empty());
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{10}, std::size_t{83}}) {
    const std::vector<std::byte> few(bytes);
    CHECK(refused_outline(few) == refusal_of(few));
    CHECK_FALSE(refusal_of(few).empty());
  }
}

TEST_CASE("A text's outline has at least its facets, and exactly these if the text has only facets") {
  const std::string text = models::to_ascii_stl(tetrahedron());
  const ModelOutline outline = outline_of(text);
  CHECK(outline.format == "ascii");
  CHECK(outline.buffered_bytes == text.size());
  CHECK(outline.most_facets >= 4);
  std::string bare;
  for (int i = 0; i < 50; ++i)
    bare += "facet outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
  CHECK(outline_of(bare).most_facets == 50);
  bare.pop_back();
  CHECK(outline_of(bare).most_facets == 50);
  CHECK(read_text(bare).facets.size() == 50);
}

TEST_CASE("A binary file that begins with solid is outlined as binary") {
  std::vector<std::byte> bytes = binary();
  std::memcpy(bytes.data(), "solid part", 10);
  CHECK(outline_of(bytes).format == "binary");
  CHECK(outline_of(bytes).most_facets == 4);
}

TEST_CASE("An outline needs only the first bytes of a file") {
  std::vector<std::byte> header(kSniffBytes);
  constexpr std::uint32_t kFacets = 85'000'000;
  std::memcpy(header.data() + kCountOffset, &kFacets, sizeof kFacets);
  CHECK(outline_of_model({84 + std::uint64_t{50} * kFacets, header}).most_facets == kFacets);
}
