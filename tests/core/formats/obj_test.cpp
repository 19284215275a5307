#include "core/formats/obj.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "core/formats/model_reader.hpp"
#include "core/model/model.hpp"
#include "tests/catch.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"

namespace {

FileStart start_of(std::string_view text) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
  return {text.size(), bytes.first(std::min(text.size(), kSniffBytes))};
}

Model read_obj_text(std::string_view text) {
  return kObj.read(start_of(text), [&](std::span<std::byte> into) {
    REQUIRE(into.size() == text.size());
    std::memcpy(into.data(), text.data(), into.size());
  });
}

std::string refusal_of_obj(std::string_view text) {
  return testing::message_of<ModelError>([&] { return read_obj_text(text); });
}

// Returns the area of all facets, seen from above.
double area_from_above(const models::Facets& facets) {
  double area = 0;
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.vertices;
    area += ((double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x)) / 2;
  }
  return area;
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("An OBJ model has the facets of the STL model, to the bit and in the same order") {
  const models::Facets ball = models::sphere(4, 12);
  std::ostringstream obj;
  obj.precision(std::numeric_limits<float>::max_digits10);
  obj << "# made by a test\nmtllib none.mtl\no ball\n";
  std::string faces;
  int vertices = 0;
  for (const Facet& facet : ball) {
    for (const Vertex& vertex : facet.vertices)
      obj << "v " << vertex.x << ' ' << vertex.y << ' ' << vertex.z << '\n';
    faces += "f " + std::to_string(vertices + 1) + "//1 " + std::to_string(vertices + 2) + "/2 " +
             std::to_string(vertices + 3) + "/2/3\r\n";
    vertices += 3;
  }
  const std::string text = obj.str();
  CHECK(kObj.likeness(start_of(text + faces)) == Likeness::Likely);
  const Model model = read_obj_text(text + faces);
  REQUIRE(model.facets.size() == ball.size());
  CHECK(std::memcmp(model.facets.data(), ball.data(), ball.size() * sizeof(Facet)) == 0);
  CHECK(kObj.outline(start_of(text + faces)).most_facets >= ball.size());
}

TEST_CASE("A negative number counts vertices from the face back, and lines may be continued") {
  const Model model = read_obj_text(kSquare + "f -4 \\\n -3 -2\nv 5 5 5\nf -5 -3 -2\n");
  REQUIRE(model.facets.size() == 2);
  CHECK(model.facets[0].vertices[2] == Vertex{1, 1, 0});
  CHECK(model.facets[1].vertices[0] == Vertex{0, 0, 0});
  CHECK(model.facets[1].vertices[2] == Vertex{0, 1, 0});
}

TEST_CASE(
    "A backslash continues the line of a face, and is part of a comment or of a group's name elsewhere") {
  const std::string square = kSquare + "# from C:\\models\\\nf 1 2 3\ng C:\\models\\\nf 1 3 \\\r\n4\n";
  CHECK(kObj.likeness(start_of(square)) == Likeness::Likely);
  CHECK(area_from_above(read_obj_text(square).facets) == Approx(1));
}

TEST_CASE("Comments of any usual length may come before an OBJ model") {
  std::string comments;
  for (int i = 0; i < 1000; ++i)
    comments += "# a line of the licence, which is no part of the model\n\n";
  const std::string text = comments + kSquare + "f 1 2 3 4\n";
  CHECK(kObj.likeness(start_of(text)) == Likeness::Likely);
  CHECK(read_model(std::as_bytes(std::span(text))).facets.size() == 2);
}

TEST_CASE("Lines of an OBJ file with unknown words are ignored") {
  for (const char* line : {"xyzzy 1 2\n", "vc 1 0 0\n", "res 1 2\n", "newmtl steel\n", "7 8 9\n"}) {
    CAPTURE(line);
    const std::string text = line + kSquare + line + "f 1 2 3 4\n";
    CHECK(kObj.likeness(start_of(text)) == Likeness::Likely);
    CHECK(read_model(std::as_bytes(std::span(text))).facets.size() == 2);
  }
  CHECK(kObj.likeness(start_of("xyzzy\nv as in volume\n")) == Likeness::None);
  CHECK(kObj.likeness(start_of("<html>\nv 1 2 3\n")) == Likeness::None);
}

TEST_CASE("Curves, free-form surfaces and called files of an OBJ model are left out and told") {
  const std::string square = kSquare + "f 1 2 3 4\n";
  const auto warning = [&](const char* lines) {
    const Model model = read_obj_text(square + lines);
    CHECK(model.facets.size() == 2);
    return model.warnings.size() == 2 ? model.warnings[0] : "no single warning";
  };
  for (const char* lines : {"cstype bezier\nsurf 0 1 0 1 1 2 3 4\nend\n", "curv 0 1 1 2 3\n", "bzp 1 2 3 4\n",
                            "bsp 1 2 3 4\n", "cdc 1 2 3 4\n", "cdp 1 2 3 4\n"})
    CHECK(lacking(warning(lines), {"curves or free-form surfaces", "left out", "mesh"}) == "");
  CHECK(lacking(warning("call wheel.obj\n"), {"\"call\"", "left out", "one file"}) == "");
  CHECK(lacking(refusal_of_obj(kSquare + "surf 0 1 0 1 1 2 3 4\n"),
                {"curves or free-form surfaces", "no faces"}) == "");
  CHECK(lacking(refusal_of_obj("call wheel.obj\n"), {"\"call\"", "no faces"}) == "");
}

TEST_CASE("An OBJ file with zeros is refused as an interrupted copy") {
  const std::string square = kSquare + "f 1 2 3 4\n";
  CHECK(read_obj_text(square + std::string(1, '\0')).facets.size() == 2);
  CHECK(lacking(refusal_of_obj(square + std::string(4096, '\0') + "f 1 2 3\n"),
                {"not whole", "byte " + std::to_string(square.size()), "copy it again"}) == "");
}

TEST_CASE("Lines may end as on old Macs") {
  std::string square = kSquare + "g a\nf 1 2 3\nf 1 3 4\n";
  std::ranges::replace(square, '\n', '\r');
  CHECK(kObj.likeness(start_of(square)) == Likeness::Likely);
  CHECK(read_obj_text(square).facets.size() == 2);
}

TEST_CASE("Polygons are cut into triangles that cover them, also where they are concave") {
  const Model square = read_obj_text(kSquare + "f 1 2 3 4\n");
  CHECK(square.facets.size() == 2);
  CHECK(area_from_above(square.facets) == Approx(1));
  // A comb with five teeth: every second corner at the top lies deep.
  std::string comb = "v 10 0 0\nv 0 0 0\n", face = "f 1 2";
  for (int i = 0; i <= 10; ++i) {
    comb += "v " + std::to_string(i) + (i % 2 == 0 ? " 1 0\n" : " 9 0\n");
    face += " " + std::to_string(i + 3);
  }
  const Model model = read_obj_text(comb + face + "\n");
  CHECK(model.facets.size() == 11);
  double all = 0;
  for (const Facet& facet : model.facets) {
    CHECK(area_from_above({facet}) <= 0);
    all += area_from_above({facet});
  }
  CHECK(all == Approx(-50));
}

TEST_CASE("A polygon that crosses itself, or is a line, gets triangles in a bounded time") {
  CHECK(read_obj_text(kSquare + "f 1 3 2 4\n").facets.size() == 2);
  CHECK(read_obj_text(kSquare + "f 1 2 1 2 1\n").facets.size() == 3);
  std::string star = "", face = "f";
  for (int i = 0; i < 20'000; ++i) {
    star += "v " + std::to_string(std::cos(2.5 * i)) + " " + std::to_string(std::sin(2.5 * i)) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  CHECK(lacking(refusal_of_obj(star + face), {"too many corners"}) == "");
}

TEST_CASE("The axis that points up is guessed by a flat base and told") {
  const std::string upright = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0.5 0.5 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  CHECK_FALSE(read_obj_text(upright).y_is_up);
  const std::string lying = "v 0 0 0\nv 2 0 0\nv 0 0 2\nv 0.5 3 0.5\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";
  // The other faces stand or lean.
  const Model model = read_obj_text(std::string(lying).replace(lying.find("v 0 0 0"), 7, "v 0 0 -0.5"));
  CHECK(model.y_is_up);
  REQUIRE(model.warnings.size() == 1);
  CHECK(lacking(model.warnings[0], {"flat base at its lowest y", "\"up\" in the ticket"}) == "");
}

TEST_CASE("A bad line of an OBJ file is refused with its number") {
  CHECK(lacking(refusal_of_obj(kSquare + "f 1 2\n"), {"line 5", "fewer than three"}) == "");
  CHECK(lacking(refusal_of_obj(kSquare + "f 1 2 5\n"), {"line 5", "the 4 before it"}) == "");
  CHECK(lacking(refusal_of_obj(kSquare + "f 0 1 2\n"), {"line 5", "the 4 before it"}) == "");
  CHECK(lacking(refusal_of_obj(kSquare + "f -5 1 2\n"), {"line 5", "the 4 before it"}) == "");
  for (const char* vertex : {"v 1 2", "v 1 nan 3", "v 1 2 inf", "v 1 2 1e39", "v 1 2 3x"})
    CHECK(lacking(refusal_of_obj(std::string(vertex) + "\n"), {"line 1", "finite numbers"}) == "");
  CHECK(lacking(refusal_of_obj(kSquare), {"no faces"}) == "");
}

TEST_CASE("Faces with far more corners than vertices do not fill the memory") {
  std::string text = kSquare;
  for (int i = 0; i < 200; ++i) {
    text += "f";
    for (int corner = 0; corner < 200; ++corner)
      text += " 1 2";
    text += "\n";
  }
  CHECK(lacking(refusal_of_obj(text), {"far more corners"}) == "");
}
