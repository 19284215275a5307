#include "daemon/formats/amf_model.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "core/model/mesh_report.hpp"
#include "daemon/formats/model_input.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using contourd::testing::lacking;
using contourd::testing::same_facets;

constexpr std::uint64_t kEnoughForAmf = 100'000;

std::string amf_object(std::string_view id, const models::Facets& facets) {
  std::string vertices, triangles;
  std::size_t number = 0;
  for (const Facet& facet : facets) {
    for (const Vertex& v : facet.vertices)
      vertices += fmt::format("<vertex><coordinates><x>{}</x><y> {} </y><z>{}</z></coordinates></vertex>\n",
                              v.x, v.y, v.z);
    triangles +=
        fmt::format("<triangle><v1>{}</v1><v2>{}</v2><v3>{}</v3></triangle>", number, number + 1, number + 2);
    number += 3;
  }
  return fmt::format(
      "<object id=\"{}\"><metadata type=\"name\">n</metadata><mesh><vertices>{}</vertices><volume "
      "materialid=\"2\">{}</volume></mesh></object>",
      id, vertices, triangles);
}

std::string amf_file(std::string_view content, std::string_view unit = "millimeter") {
  return fmt::format("<?xml version=\"1.0\"?>\n<amf unit=\"{}\">{}</amf>", unit, content);
}

Model read_text(std::string_view text) {
  const testing::TemporaryFolder folder;
  return open_model(folder.write("a.amf", text))->read(kEnoughForAmf);
}

std::string refusal_of_amf(std::string_view text) {
  return testing::message_of<ModelError>([&] { (void)read_text(text); });
}

const models::Facets kSlab = models::box({1, 2, 3}, {5, 4, 9});

}  // namespace

TEST_CASE("An AMF model has the facets of the same STL model, plain, zipped and by gzip") {
  const models::Facets ball = models::sphere(4, 12);
  const std::string text = amf_file(amf_object("1", ball));
  CHECK(same_facets(read_text(text).facets, ball));
  CHECK(same_facets(read_text(testing::gzipped(text)).facets, ball));
  CHECK(same_facets(read_text(testing::zipped({{"a.amf", text}})).facets, ball));
  CHECK(bounds_of(read_text(amf_file(amf_object("1", kSlab), "inch")).facets).max_x == testing::Approx(127));
  CHECK(read_text(amf_file(amf_object("1", kSlab), "inch")).unit == LengthUnit::Inch);
  CHECK(read_text(text).unit == LengthUnit::Millimeter);
  CHECK(bounds_of(read_text(amf_file(amf_object("1", kSlab), "feet")).facets).max_x == testing::Approx(1524));
}

TEST_CASE("Constellations of an AMF model place its objects, turned and shifted") {
  const std::string placed =
      amf_object("1", kSlab) + amf_object("2", kSlab) +
      "<constellation id=\"3\"><instance objectid=\"1\"><deltax>10</deltax><rz>90</rz></instance>"
      "<instance objectid=\"1\"><deltaz>-3</deltaz></instance></constellation>";
  const Model model = read_text(amf_file(placed));
  // The second object is placed by no one, and stands as drawn.
  REQUIRE(model.facets.size() == 36);
  const Bounds turned = bounds_of(std::span(model.facets).subspan(12, 12));
  CHECK(turned.min_x == testing::Approx(10 - 4));
  CHECK(turned.max_x == testing::Approx(10 - 2));
  CHECK(turned.min_y == testing::Approx(1));
  CHECK(turned.max_y == testing::Approx(5));
  CHECK(bounds_of(std::span(model.facets).last(12)).min_z == 0);
  // Slic3r's turns are in radians.
  const Model radians =
      read_text(amf_file("<metadata type=\"cad\">Slic3r 2.5</metadata>" + amf_object("1", kSlab) +
                         "<constellation id=\"3\"><instance objectid=\"1\"><rz>1.5707963267948966</rz>"
                         "</instance></constellation>"));
  CHECK(bounds_of(radians.facets).min_x == testing::Approx(-4));
}

TEST_CASE(
    "An instance of an AMF model is mirrored and scaled before it is turned, as Slic3r and its successors "
    "do") {
  const auto bounds_with = [](std::string_view figures) {
    const Model model =
        read_text(amf_file(amf_object("1", kSlab) + "<constellation id=\"2\"><instance objectid=\"1\">" +
                           std::string(figures) + "</instance></constellation>"));
    CHECK(inspect_mesh(model.facets).volume_mm3 > 0);  // the facets still face outwards
    return bounds_of(model.facets);
  };
  // The slab spans 1 to 5, 2 to 4 and 3 to 9.
  const Bounds mirrored = bounds_with("<mirrorx>-1</mirrorx><mirrory>1</mirrory><mirrorz>1</mirrorz>");
  CHECK(mirrored.min_x == testing::Approx(-5));
  CHECK(mirrored.max_x == testing::Approx(-1));
  CHECK(mirrored.min_y == testing::Approx(2));
  CHECK(bounds_with("<mirrory>-1</mirrory>").min_y == testing::Approx(-4));
  CHECK(bounds_with("<mirrorz>-1</mirrorz>").min_z == testing::Approx(-9));
  CHECK(bounds_with("<mirrorx>-1</mirrorx><mirrory>-1</mirrory>").max_x == testing::Approx(-1));
  const Bounds all =
      bounds_with("<deltax>100</deltax><rz>90</rz><scalex>2</scalex><scalez>3</scalez><mirrorx>-1</mirrorx>");
  // x of -10 to -2 becomes y, and y of 2 to 4 becomes x of -4 to -2.
  CHECK(all.min_x == testing::Approx(96));
  CHECK(all.max_x == testing::Approx(98));
  CHECK(all.min_y == testing::Approx(-10));
  CHECK(all.max_y == testing::Approx(-2));
  CHECK(all.max_z == testing::Approx(27));
}

TEST_CASE("Comments of any usual length may come before an AMF model") {
  const std::string comment = "<!-- " + std::string(30'000, 'c') + " -->\n", model = amf_object("1", kSlab);
  CHECK(read_text("<?xml version=\"1.0\"?>\n" + comment + "<amf>" + model + "</amf>").facets.size() == 12);
  CHECK(read_text(comment + "<amf>" + model + "</amf>").facets.size() == 12);
}

TEST_CASE(
    "A comment that is longer than the bytes by which files are recognised may come before an AMF model") {
  const std::string start = "<?xml version=\"1.0\"?>\n<!-- " + std::string(200'000, 'c') + " -->\n";
  CHECK(read_text(start + "<amf>" + amf_object("1", kSlab) + "</amf>").facets.size() == 12);
  CHECK(lacking(refusal_of_amf(start + "<svg></svg>"), {"does not begin with an AMF model"}).empty());
}

TEST_CASE("Curves and modifiers of an AMF model are left out with a warning") {
  std::string text = amf_file(amf_object("1", kSlab));
  text.insert(text.find("</coordinates>") + 14, "<normal><nx>1</nx><ny>0</ny><nz>0</nz></normal>");
  CHECK(lacking(read_text(text).warnings.at(0), {"curved triangles"}).empty());
  std::string other = amf_file(amf_object("1", kSlab));
  other.insert(other.find("</volume>"),
               "</volume><volume><metadata "
               "type=\"slic3r.modifier\">1</metadata><triangle><v1>0</v1><v2>1</v2><v3>2</v3>"
               "</triangle>");
  CHECK(read_text(other).facets.size() == 12);
  CHECK(lacking(read_text(other).warnings.at(0), {"modifiers"}).empty());
}

TEST_CASE("A hostile AMF model is refused in one sentence") {
  CHECK(lacking(refusal_of_amf(amf_file(amf_object("1", kSlab), "parsec")), {"unit \"parsec\""}).empty());
  CHECK(lacking(refusal_of_amf("<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b \"c\">]><amf>&b;</amf>"),
                {"document type declaration"})
            .empty());
  const auto constellation = [](int id, std::string_view of) {
    const std::string one = fmt::format("<instance objectid=\"{}\"/>", of);
    return fmt::format("<constellation id=\"{}\">{}</constellation>", id, one + one);
  };
  std::string doubled = amf_object("1", kSlab);
  for (int id = 2; id < 30; ++id)
    doubled += constellation(id, std::to_string(id - 1));
  CHECK(lacking(refusal_of_amf(amf_file(doubled)), {"more facets than there is room for"}).empty());
  CHECK(
      lacking(refusal_of_amf(amf_file(constellation(1, "2") + constellation(2, "2"))), {"contain themselves"})
          .empty());
  CHECK(lacking(refusal_of_amf(amf_file(constellation(1, "7"))), {"object \"7\", which does not exist"})
            .empty());
  std::string text = amf_file(amf_object("1", kSlab));
  text.replace(text.find("<v2>1<"), 6, "<v2>99<");
  CHECK(lacking(refusal_of_amf(text), {"line ", "does not name three of the 36 vertices"}).empty());
  CHECK_FALSE(refusal_of_amf(std::string_view(text).substr(0, text.size() / 2)).empty());
}
