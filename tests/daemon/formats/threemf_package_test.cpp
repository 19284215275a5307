#include "daemon/formats/threemf_package.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/model/model.hpp"
#include "daemon/formats/model_input.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/formats/packed_models.hpp"
#include "tests/message_of.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using testing::PackedFile;
using testing::threemf_assembly;
using testing::threemf_files;
using testing::threemf_object;
using testing::threemf_part;

constexpr std::uint64_t kFacetsWithRoom = 1'000'000;

const models::Facets kUnitBox = models::box({0, 0, 0}, {1, 2, 3});

Model read_3mf(const std::vector<PackedFile>& files) {
  const testing::TemporaryFolder folder;
  const auto input = open_model(folder.write("part.3mf", testing::zipped(files)));
  CHECK(input->outline().format == "3mf");
  return input->read(kFacetsWithRoom);
}
Model read_3mf(std::string_view objects, std::string_view items,
               std::string_view attributes = "unit=\"millimeter\"") {
  return read_3mf(threemf_files(threemf_part(objects, items, attributes)));
}

template <typename... Arguments>
std::string refusal_of_3mf(const Arguments&... arguments) {
  return testing::message_of<ModelError>([&] { return read_3mf(arguments...); });
}

// Returns a package with another file beside the model.
std::vector<PackedFile> with_file(std::vector<PackedFile> files, std::string name, std::string content) {
  files.push_back({std::move(name), std::move(content)});
  return files;
}

models::Facets moved(models::Facets facets, float x, float y, float z) {
  models::translate(facets, x, y, z);
  return facets;
}

}  // namespace

TEST_CASE("A 3MF model has the facets of the STL model, to the bit and in the same order") {
  const testing::TemporaryFolder folder;
  const models::Facets ball = models::sphere(4, 12);
  const auto input = open_model(folder.write("ball.stl", testing::threemf_of(ball)));
  const Model model = input->read(kFacetsWithRoom);
  CHECK(testing::same_facets(model.facets, ball));
  CHECK(model.warnings.empty());
}

TEST_CASE("Names in a 3MF file are compared without regard to case and percent-encoding") {
  const std::string part = threemf_part(threemf_object(1, kUnitBox), "");
  const auto read_with = [&](std::string_view path, const std::string& entry) {
    const std::string item = fmt::format("<item objectid=\"1\" p:path=\"{}\"/>", path);
    return read_3mf(with_file(threemf_files(threemf_part("", item)), entry, part)).facets;
  };
  CHECK(testing::same_facets(read_with("/3d/objects/O.model", "3D/Objects/o.model"), kUnitBox));
  CHECK(testing::same_facets(read_with("/3D/o%201.model", "3D/o 1.model"), kUnitBox));
  CHECK(testing::same_facets(read_with("/3D/o 1.model", "3D/o%201.model"), kUnitBox));
  CHECK(testing::same_facets(read_with("/3D/o%201.model", "3D/o%201.model"), kUnitBox));
  CHECK(testing::same_facets(read_with("/3D/o.MODEL", "3D/o.MODEL"), kUnitBox));
  const std::string items =
      "<item objectid=\"1\" p:path=\"/3D/o.model\"/><item objectid=\"1\" p:path=\"/3D/O.model\"/>";
  const std::vector<PackedFile> both = with_file(threemf_files(threemf_part("", items)), "3D/O.model", part);
  CHECK(read_3mf(both).facets.size() == 24);
  // The exact name wins over an equivalent one.
  const models::Facets far = moved(kUnitBox, 5, 0, 0);
  const Model exact = read_3mf(with_file(both, "3D/o.model", threemf_part(threemf_object(1, far), "")));
  REQUIRE(exact.facets.size() == 24);
  CHECK(testing::same_facets(std::span(exact.facets).first(12), far));
  CHECK(testing::same_facets(std::span(exact.facets).last(12), kUnitBox));
  CHECK(lacking(refusal_of_3mf(threemf_files(threemf_part("", items))), {"lacks \"3D/o.model\""}) == "");

  const std::string root = threemf_part(threemf_object(1, kUnitBox), "<item objectid=\"1\"/>");
  for (const char* entry : {"3d/3DModel.model", "3D/3dmodel.MODEL", "3D/3dm%6Fdel.model"}) {
    CAPTURE(entry);
    std::vector<PackedFile> files = threemf_files(root);
    files[0].name = "[Content_Types].XML";
    files[1].name = "_RELS/.RELS";
    files[2].name = entry;
    CHECK(testing::same_facets(read_3mf(files).facets, kUnitBox));
  }
}

TEST_CASE("The unit of a 3MF model applies: the facets are in millimetres") {
  const auto times = [](double mm, double number) { return static_cast<float>(mm * number); };
  for (const auto& [unit, mm] :
       {std::pair("micron", 0.001), std::pair("millimeter", 1.0), std::pair("centimeter", 10.0),
        std::pair("inch", 25.4), std::pair("foot", 304.8), std::pair("meter", 1000.0)}) {
    const Model model =
        read_3mf(threemf_object(1, kUnitBox), "<item objectid=\"1\"/>", fmt::format("unit=\"{}\"", unit));
    const models::Facets box = models::box({0, 0, 0}, {times(mm, 1), times(mm, 2), times(mm, 3)});
    CHECK(testing::same_facets(model.facets, box));
    REQUIRE(model.unit.has_value());
    CHECK(millimeters_in(*model.unit) == testing::Approx(mm));
  }
  CHECK(lacking(refusal_of_3mf(threemf_object(1, kUnitBox), "<item objectid=\"1\"/>", "unit=\"parsec\""),
                {"unit \"parsec\" is unknown"})
            .empty());
}

TEST_CASE("Items and components are placed by their transforms, the component's first") {
  const Model model =
      read_3mf(threemf_object(1, kUnitBox) +
                   threemf_assembly(2,
                                    "<component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/>"
                                    "<component objectid=\"1\"/>"),
               "<item objectid=\"2\" transform=\"0 1 0 -1 0 0 0 0 1 0 0 5\"/><item objectid=\"1\"/>");
  // A quarter turn takes x to y and y to -x.
  REQUIRE(model.facets.size() == 36);
  const Bounds first = bounds_of(std::span(model.facets).first(12));
  CHECK(first.min_x == -2);
  CHECK(first.max_x == 0);
  CHECK(first.min_y == 10);
  CHECK(first.max_y == 11);
  CHECK(first.min_z == 5);
  CHECK(first.max_z == 8);
  CHECK(testing::same_facets(std::span(model.facets).last(12), kUnitBox));
}

TEST_CASE("A transform that mirrors an object does not turn it inside out") {
  const Model model =
      read_3mf(threemf_object(1, kUnitBox), "<item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 1 0 0\"/>");
  double volume = 0;
  for (const Facet& facet : model.facets) {
    const auto& [a, b, c] = facet.vertices;
    volume += (double{a.x} * (double{b.y} * c.z - double{b.z} * c.y) +
               double{a.y} * (double{b.z} * c.x - double{b.x} * c.z) +
               double{a.z} * (double{b.x} * c.y - double{b.y} * c.x)) /
              6;
  }
  CHECK(volume == Approx(6));
}

TEST_CASE("Objects in other files of the package are read by their paths") {
  const std::string other = threemf_part(threemf_object(7, kUnitBox), "");
  const std::string root =
      threemf_part(threemf_assembly(1, "<component objectid=\"7\" p:path=\"/3D/Objects/one.model\"/>"),
                   "<item objectid=\"1\"/>", "unit=\"millimeter\" requiredextensions=\"p\"");
  const auto package = with_file(threemf_files(root), "3D/Objects/one.model", other);
  CHECK(testing::same_facets(read_3mf(package).facets, kUnitBox));
  CHECK(lacking(refusal_of_3mf(threemf_files(root)), {"lacks \"3D/Objects/one.model\""}).empty());
  const auto nested =
      with_file(threemf_files(root), "3D/Objects/one.model",
                threemf_part(threemf_assembly(7, "<component objectid=\"1\" p:path=\"/3D/x.model\"/>"), ""));
  CHECK(lacking(refusal_of_3mf(nested), {"only the root model"}).empty());
}

TEST_CASE("Objects and items that are not to be printed are left out and told") {
  const std::string objects = threemf_object(1, kUnitBox) + threemf_object(2, kUnitBox, "support") +
                              threemf_object(3, kUnitBox, "surface") + threemf_object(4, kUnitBox, "other");
  const Model model = read_3mf(objects,
                               "<item objectid=\"1\"/><item objectid=\"2\"/><item objectid=\"3\"/>"
                               "<item objectid=\"4\"/><item objectid=\"1\" printable=\"0\"/>");
  CHECK(model.facets.size() == 12);
  REQUIRE(model.warnings.size() == 2);
  CHECK(lacking(model.warnings[0], {"1 object as not printable"}).empty());
  CHECK(lacking(model.warnings[1], {"3 objects"}).empty());
  CHECK(
      lacking(refusal_of_3mf(objects, "<item objectid=\"1\" printable=\"0\"/>"), {"not printable"}).empty());
  CHECK(lacking(refusal_of_3mf(objects, ""), {"its build has no item"}).empty());
}

TEST_CASE("PrusaSlicer's modifiers and negative volumes are left out of the mesh and told") {
  const models::Facets all = models::together({kUnitBox, moved(kUnitBox, 5, 0, 0), moved(kUnitBox, 9, 0, 0)});
  const auto package = with_file(
      threemf_files(threemf_part(threemf_object(1, all), "<item objectid=\"1\"/>")),
      "Metadata/Slic3r_PE_model.config",
      "<?xml version=\"1.0\"?><config><object id=\"1\"><metadata type=\"object\" key=\"name\" value=\"x\"/>"
      "<volume firstid=\"0\" lastid=\"11\"><metadata type=\"volume\" key=\"volume_type\" "
      "value=\"ModelPart\"/></volume>"
      "<volume firstid=\"12\" lastid=\"23\"><metadata type=\"volume\" key=\"volume_type\" "
      "value=\"ParameterModifier\"/></volume>"
      "<volume firstid=\"24\" lastid=\"35\"><metadata type=\"volume\" key=\"volume_type\" "
      "value=\"NegativeVolume\"/></volume>"
      "</object></config>");
  const Model model = read_3mf(package);
  CHECK(testing::same_facets(model.facets, kUnitBox));
  REQUIRE(model.warnings.size() == 1);
  CHECK(lacking(model.warnings[0], {"1 modifier, 1 negative part", "is printed"}).empty());
}

TEST_CASE(
    "A side file whose volumes are not in the mesh is refused, and so is a package with two root models") {
  const std::vector<PackedFile> box =
      threemf_files(threemf_part(threemf_object(1, kUnitBox), "<item objectid=\"1\"/>"));
  CHECK(lacking(refusal_of_3mf(with_file(
                    box, "Metadata/Slic3r_PE_model.config",
                    "<config><object id=\"1\"><volume firstid=\"12\" lastid=\"23\"><metadata type=\"volume\" "
                    "key=\"volume_type\" value=\"NegativeVolume\"/></volume></object></config>")),
                {"negative part", "triangles 12 to 23 of object 1, which has only 12"})
            .empty());
  // libzip makes no archive with two entries of one name.
  std::string archive = testing::zipped(with_file(box, "3D/3dmodel.modex", box.back().content));
  for (std::size_t at = archive.find("modex"); at != std::string::npos; at = archive.find("modex", at))
    archive[at + 4] = 'l';
  const testing::TemporaryFolder folder;
  CHECK(lacking(testing::message_of<ModelError>([&] { (void)open_model(folder.write("part.3mf", archive)); }),
                {"3D/3dmodel.model", "twice"})
            .empty());
}

TEST_CASE("Cura's meshes that are no part of the model are left out and told") {
  const auto object_with = [](int id, std::string_view setting, std::string_view value) {
    std::string object = threemf_object(id, kUnitBox);
    const std::string_view mesh = "<mesh>";
    return object.insert(
        object.find(mesh),
        fmt::format("<metadatagroup><metadata name=\"cura:extruder_nr\">0</metadata><metadata "
                    "name=\"cura:{}\" type=\"xs:string\">{}</metadata></metadatagroup>",
                    setting, value));
  };
  for (const auto& [setting, kind] :
       {std::pair("anti_overhang_mesh", "1 support blocker"), std::pair("support_mesh", "1 support"),
        std::pair("infill_mesh", "1 modifier"), std::pair("cutting_mesh", "1 modifier")}) {
    CAPTURE(setting);
    const std::string objects = threemf_object(1, kUnitBox) + object_with(2, setting, "True");
    const std::string assembly =
        threemf_assembly(3, "<component objectid=\"1\"/><component objectid=\"2\"/>");
    for (const Model& model : {read_3mf(objects, "<item objectid=\"1\"/><item objectid=\"2\"/>"),
                               read_3mf(objects + assembly, "<item objectid=\"3\"/>")}) {
      CHECK(testing::same_facets(model.facets, kUnitBox));
      REQUIRE(model.warnings.size() == 1);
      CHECK(lacking(model.warnings[0], {"left out", kind}).empty());
    }
    const Model kept = read_3mf(object_with(1, setting, "False"), "<item objectid=\"1\"/>");
    CHECK(testing::same_facets(kept.facets, kUnitBox));
    CHECK(kept.warnings.empty());
  }
}

TEST_CASE("Bambu Studio's modifiers and support blockers are left out of the components and told") {
  const std::string root = threemf_part(
      threemf_object(1, kUnitBox) + threemf_object(2, moved(kUnitBox, 5, 0, 0)) +
          threemf_object(3, moved(kUnitBox, 9, 0, 0)) +
          threemf_assembly(
              8, "<component objectid=\"1\"/><component objectid=\"2\"/><component objectid=\"3\"/>"),
      "<item objectid=\"8\"/>");
  const Model model = read_3mf(
      with_file(threemf_files(root), "Metadata/model_settings.config",
                "<?xml version=\"1.0\"?><config><object id=\"8\"><part id=\"1\" subtype=\"normal_part\"/>"
                "<part id=\"2\" subtype=\"modifier_part\"/><part id=\"3\" "
                "subtype=\"support_blocker\"/></object></config>"));
  CHECK(testing::same_facets(model.facets, kUnitBox));
  REQUIRE(model.warnings.size() == 1);
  CHECK(lacking(model.warnings[0], {"1 modifier, 1 support blocker"}).empty());
}

TEST_CASE("An extension that a 3MF model requires and contourd does not read is refused by its name") {
  CHECK(lacking(refusal_of_3mf(threemf_object(1, kUnitBox), "<item objectid=\"1\"/>",
                               "requiredextensions=\"p b\""),
                {"beamlattice/2017/02"})
            .empty());
}

TEST_CASE("A damaged 3MF model is refused with the place") {
  const std::string sound = threemf_object(1, kUnitBox), item = "<item objectid=\"1\"/>";
  CHECK(lacking(refusal_of_3mf(sound, "<item objectid=\"9\"/>"), {"object 9, which does not exist"}).empty());
  CHECK(lacking(refusal_of_3mf(sound + sound, item), {"two objects have the id 1"}).empty());
  CHECK(lacking(refusal_of_3mf(threemf_assembly(1, "<component objectid=\"1\"/>"), item),
                {"does not come before"})
            .empty());
  CHECK(lacking(refusal_of_3mf(
                    threemf_assembly(1, "<component objectid=\"1\" p:path=\"/3D/3dmodel.model\"/>"), item),
                {"does not come after"})
            .empty());
  CHECK(lacking(refusal_of_3mf(sound, "<item objectid=\"1\" transform=\"1 0 0\"/>"), {"12 finite numbers"})
            .empty());
  CHECK(lacking(refusal_of_3mf("<object id=\"1\"><mesh><vertices><vertex x=\"nan\" y=\"0\" "
                               "z=\"0\"/></vertices></mesh></object>",
                               item),
                {"line 4: vertex 0 of object 1"})
            .empty());
  CHECK(lacking(refusal_of_3mf("<object id=\"1\"><mesh><triangles><triangle v1=\"0\" v2=\"1\" "
                               "v3=\"2\"/></triangles></mesh></object>",
                               item),
                {"triangle 0 of object 1"})
            .empty());
  CHECK(lacking(refusal_of_3mf(sound + "<object id=\"2\"/>", item + "<item objectid=\"2\"/>"),
                {"object 2", "neither triangles nor components"})
            .empty());
  CHECK(lacking(refusal_of_3mf(sound, "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"/>"),
                {"object 1", "makes it flat"})
            .empty());
  CHECK(lacking(refusal_of_3mf(threemf_files("<model")), {"not valid XML"}).empty());
  CHECK(lacking(refusal_of_3mf(threemf_files("<html/>")), {"does not begin with a 3MF model"}).empty());
}

TEST_CASE("Components that double 30 times are refused at once, with and without a mesh") {
  for (const bool has_mesh : {true, false}) {
    std::string objects = threemf_object(1, has_mesh ? kUnitBox : models::Facets{});
    for (int id = 2; id <= 31; ++id)
      objects += threemf_assembly(
          id, fmt::format("<component objectid=\"{0}\"/><component objectid=\"{0}\"/>", id - 1));
    const auto start = std::chrono::steady_clock::now();
    CHECK(lacking(refusal_of_3mf(objects, "<item objectid=\"31\"/>"),
                  {has_mesh ? "come to 12884901888 facets, and there is room for 1000000"
                            : "more than 1000000 objects"})
              .empty());
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
  }
}

TEST_CASE("A chain of components that is too deep is refused") {
  std::string objects = threemf_object(1, kUnitBox);
  for (int id = 2; id <= 40'000; ++id)
    objects += threemf_assembly(id, fmt::format("<component objectid=\"{}\"/>", id - 1));
  CHECK(
      lacking(refusal_of_3mf(objects, "<item objectid=\"40000\"/>"), {"nested more than 32 levels"}).empty());
}

TEST_CASE("A document type, deep elements and endless names of XML are refused in bounded memory") {
  const std::string entities =
      "<?xml version=\"1.0\"?><!DOCTYPE m [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b "
      "\"&a;&a;&a;&a;\">]><m>&b;</m>";
  CHECK(lacking(refusal_of_3mf(threemf_files(entities)), {"document type declaration"}).empty());
  const std::string model = "<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">";
  std::string deep = model;
  for (int i = 0; i < 100; ++i)
    deep += "<a>";
  CHECK(lacking(refusal_of_3mf(threemf_files(deep)), {"64 levels"}).empty());
  std::string names = model, tag = "<model a=\"";
  for (int i = 0; i < 1'000'000; ++i) {
    names += fmt::format("<x{}/>", i);
    tag += fmt::format("{:040}", i * 1'234'567'891LL);
  }
  CHECK(lacking(refusal_of_3mf(threemf_files(names)), {"too long"}).empty());
  CHECK(lacking(refusal_of_3mf(threemf_files(tag)), {"too long"}).empty());
}
