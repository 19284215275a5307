#include "daemon/prepare/model_checks.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/prepare/print_job_fixture.hpp"

using namespace contourd;
using testing::kCube;
using testing::PlateFixture;
using testing::PrintJobFixture;

namespace {

constexpr SizeMm kRoom{96, 54, 150};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE_METHOD(PrintJobFixture, "A model of which nothing would be printed is refused with its size",
                 "[long]") {
  CHECK(refusal_of(models::box({0, 0, 0}, {0.02F, 0.03F, 2})) ==
        "nothing of the model would be printed: in 40 layers, no pixel of 0.05 mm reaches grey 64 of 255; it "
        "measures 0.02 x 0.03 x 2 mm");
  // The only layer would be cut at a height above the model.
  CHECK(refusal_of(models::box({0, 0, 0}, {5, 5, 0.01F})) ==
        "the model is 0.01 mm high, too thin for a layer");
  const std::string drill = R"({"drain": [
    {"position_mm": {"x": 1, "y": 1}, "direction": {"z": 1}, "diameter_mm": 4}]})";
  CHECK(refusal_of(models::box({0, 0, 0}, {2, 2, 2}), drill) ==
        "nothing of the model would be printed: in 40 layers, no pixel of 0.05 mm reaches grey 64 of 255; it "
        "measures 2 x 2 x 2 mm less its drain holes");
  // A head of two by two pixels on a needle that is too thin to print.
  models::Facets needle = models::box({-0.01F, -0.01F, 0}, {0.01F, 0.01F, 0.3F});
  const models::Facets head = models::box({-0.05F, -0.05F, 0.3F}, {0.05F, 0.05F, 0.5F});
  needle.insert(needle.end(), head.begin(), head.end());
  CHECK(refusal_of(needle).empty());
  // A sheet seven tenths of a pixel thick, half in each of two rows: grey 89 of 255.
  const models::Facets sheet = models::box({-5, -0.0175F, 0}, {5, 0.0175F, 5});
  CHECK(refusal_of(sheet).empty());
  printer.tone.threshold = 100;
  CHECK(refusal_of(sheet) ==
        "nothing of the model would be printed: in 100 layers, no pixel of 0.05 mm reaches grey 100 of 255; "
        "it measures 10 x 0.035 x 5 mm");
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A model that is not watertight or is inside out is printed with a warning") {
  models::Facets open = kCube;
  open.pop_back();
  CHECK(prepare(open, R"({"cracks": "repair"})").summary.warnings.size() == 1);
  models::Facets inverted = kCube;
  models::invert(inverted);
  const PreparedJob job = prepare(inverted);
  CHECK(job.summary.warnings ==
        std::vector<std::string>{"the model is inside out: its facets were turned outwards"});
  CHECK(job.plan.engine->mask_at(Nanometers{1'000'000}).lit_area() == 160000.0);
}

TEST_CASE_METHOD(PrintJobFixture, "Shells that are wound against their place are named with their place") {
  const models::Facets ridge = models::inverted(models::box({5, 5, 19}, {8, 7, 22}));
  const PreparedJob job = prepare(models::together(kCube, ridge));
  CHECK(job.summary.models[0].shells.inside_out == 1);
  CHECK(
      job.summary.warnings ==
      std::vector<std::string>{"1 shell of the model is inside out though it lies in no solid or overlaps a "
                               "cavity, at -5.00, -5.00 mm from the plate's centre at a height of 19.00 mm: "
                               "such a shell is filled there, but where it overlaps a solid, nothing is "
                               "printed; turn its facets outwards if it is a body, or unite it with the "
                               "cavity that it overlaps"});
  const models::Facets core = models::box({5, 5, 5}, {15, 15, 15});
  const JobSummary filled = prepare(models::together(kCube, core)).summary;
  REQUIRE(filled.warnings.size() == 1);
  CHECK(filled.warnings[0].starts_with("1 shell of the model faces outwards within a solid, at "));
  CHECK(prepare(models::together(kCube, models::inverted(core))).summary.warnings.empty());
  const models::Facets cavities =
      models::inverted(models::together(core, models::box({8, 8, 8}, {18, 18, 18})));
  const JobSummary overlapping = prepare(models::together(kCube, cavities)).summary;
  REQUIRE(overlapping.warnings.size() == 1);
  CHECK(overlapping.warnings[0].find("unite it with the cavity") != std::string::npos);
}

TEST_CASE_METHOD(PrintJobFixture, "A plate that no layer has is named with its place") {
  const models::Facets stem = models::box({8, 8, 0}, {12, 12, 20});
  const JobSummary summary =
      prepare(models::together(stem, models::box({0, 0, 10}, {20, 20, 10.02F}))).summary;
  CHECK(
      summary.warnings ==
      std::vector<std::string>{"parts of the model are thinner than a layer, lie between two layers and are "
                               "not printed, at 1 height: the first is 0.02 mm thick, at -9.98, 9.98 mm from "
                               "the plate's centre at a height of 10.010 mm (384 mm²); make them thicker, or "
                               "print thinner layers"});
  CHECK(prepare(models::together(stem, models::box({0, 0, 10}, {20, 20, 10.2F}))).summary.warnings.empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A model that lacks much of its surface has wide gaps") {
  models::Facets lacking = models::sphere(5, 12);
  std::erase_if(lacking, [](const Facet& facet) { return facet.vertices[0].x > 2; });
  const JobSummary summary = prepare(lacking).summary;
  CHECK(summary.wide_gaps.starts_with("much of the surface of the model is missing: in "));
  CHECK(std::ranges::find(summary.warnings, summary.wide_gaps) != summary.warnings.end());
  CHECK_FALSE(prepare(lacking, "{}").summary.wide_gaps.empty());
  CHECK(prepare(lacking, R"({"cracks": "repair"})").summary.wide_gaps.empty());
  // A narrow crack along the whole height, and a wide hole in few layers.
  models::Facets cracked = kCube;
  for (Vertex& v : cracked[4].vertices)
    v.y -= 0.3F;
  CHECK(prepare(cracked).summary.wide_gaps.empty());
  models::Facets holed = models::together(kCube, models::box({5, 5, 20}, {15, 15, 21}));
  holed.erase(holed.end() - 3);
  CHECK_FALSE(inspect_mesh(holed).watertight);
  CHECK(prepare(holed).summary.wide_gaps.empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A compensation that erases walls whole is reported with its place") {
  const auto walled = models::together(kCube, models::box({25, 0, 0}, {25.1F, 10, 5}));
  const auto warnings = [&] { return prepare(walled).summary.warnings; };
  CHECK(warnings().empty());
  resin.compensation = {Micrometers{}, Micrometers{60.0}, Nanometers{400'000}};
  CHECK(warnings() ==
        std::vector<std::string>{
            "the compensation moves outlines by -56 um in layer 1 and erases walls and pins thinner "
            "than twice that: nothing is left at 12.50, -5.00 mm from the plate's centre "
            "(1 mm²), and 2 more; thicken them, or reduce growth_um or "
            "elephant_foot_um"});
  resin.compensation = {Micrometers{-60.0}, {}, {}};
  REQUIRE(warnings().size() == 1);
  CHECK(warnings().front().find("-60 um in layer 1 ") != std::string::npos);
  resin.compensation = {Micrometers{60.0}, {}, {}};
  CHECK(warnings().empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A compensation that erases pins is reported, whatever their thickness",
                 "[long]") {
  const std::string small = " mm from the plate's centre (";
  for (const double radius_mm : {0.01, 0.02, 0.035}) {
    for (const double slant : {0.0, 0.7}) {
      INFO("pin of " << 2000 * radius_mm << " um, slant " << slant);
      const std::array<Point, 4> profile{{{0, 0}, {radius_mm, 0}, {radius_mm, 8}, {0, 8}}};
      models::Facets pin = models::lathe(profile, 12);
      for (Facet& facet : pin) {
        for (Vertex& v : facet.vertices)
          v = {static_cast<float>(v.x + 5 + slant * v.z), v.y + 5, v.z + 18};
      }
      const models::Facets pinned = models::together(kCube, pin);
      resin.compensation = {Micrometers{-40.0}, {}, {}};
      const std::vector<std::string> warnings = prepare(pinned).summary.warnings;
      REQUIRE(warnings.size() == 1);
      CHECK(warnings[0].find(small) != std::string::npos);
      resin.compensation = {Micrometers{-5.0}, {}, {}};
      CHECK(prepare(pinned).summary.warnings.size() == (radius_mm < 0.03 ? 1 : 0));
    }
  }
}

TEST_CASE_METHOD(PrintJobFixture, "A compensation that only shortens points erases nothing") {
  resin.compensation.growth = Micrometers{-100.0};
  const std::array<Point, 3> profile{{{0, 0}, {5, 5}, {0, 10}}};
  CHECK(prepare(models::lathe(profile, 24)).summary.warnings.empty());
}

TEST_CASE_METHOD(PlateFixture, "A plate's warnings name the model") {
  models::Facets open = kCube;
  open.pop_back();
  add("open.stl", open);
  const PreparedJob job = prepare(R"({"cracks": "repair", "models": [{"file": "open.stl"}]})");
  REQUIRE(job.summary.warnings.size() == 1);
  CHECK(job.summary.warnings[0].find("open.stl: the model is not watertight") == 0);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A cracked model is refused with its first open layer if the ticket refuses cracks") {
  models::Facets cracked = models::box({0, 0, 0}, {20, 20, 10});
  models::Facets upper = models::box({5, 5, 10}, {15, 15, 20});
  // Removes the facets of the upper box's front.
  std::erase_if(upper, [](const Facet& facet) {
    return std::ranges::all_of(facet.vertices, [](const Vertex& v) { return v.y == 5; });
  });
  cracked.insert(cracked.end(), upper.begin(), upper.end());
  const std::string refuse = R"({"layer_height_um": 100, "cracks": "refuse"})";
  CHECK(refusal_of(cracked, refuse) ==
        "the model is cracked: contours do not close in 100 of 200 layers, first in layer 101 at 10.050 "
        "mm, and the widest gap is 10.000 mm; fix the model, or print it with \"cracks\": \"repair\" in its "
        "ticket");
  CHECK(refusal_of(cracked, R"({"layer_height_um": 100, "cracks": "repair"})").empty());
  CHECK(refusal_of(cracked).empty());
  CHECK(refusal_of(kCube, refuse).empty());
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A mesh that needs repair is refused with the repairs if the ticket refuses cracks") {
  const std::string refuse = R"({"layer_height_um": 100, "cracks": "refuse"})";
  const auto refusal = [](const std::string& what) {
    return "the model is cracked: its facets disagree with each other (repair: " + what +
           "); fix the model, or print it with \"cracks\": \"repair\" in its ticket";
  };
  models::Facets turned = kCube, reversed = kCube, wall = kCube, doubled = kCube;
  std::swap(turned[4].vertices[0], turned[4].vertices[1]);
  CHECK(refusal_of(turned, refuse) == refusal("1 facet turned round"));
  reversed.insert(reversed.end(),
                  {turned[4], {{kCube[5].vertices[0], kCube[5].vertices[2], kCube[5].vertices[1]}}});
  CHECK(refusal_of(reversed, refuse) == refusal("2 reversed duplicate facets removed"));
  const Bounds bounds = bounds_of(kCube);
  const auto x = static_cast<float>(bounds.center().x), y = static_cast<float>(bounds.center().y);
  wall.push_back({{Vertex{x, y, 2}, Vertex{x + 3, y, 2}, Vertex{x, y, 8}}});
  CHECK(refusal_of(wall, refuse) == refusal("1 inner wall facet removed"));
  for (const models::Facets& dirty : {turned, reversed, wall})
    CHECK(refusal_of(dirty).empty());
  // Removing a duplicate is not a guess.
  doubled.push_back(kCube[3]);
  CHECK(refusal_of(doubled, refuse).empty());
}

TEST_CASE_METHOD(PrintJobFixture, "Gaps within a pixel do not refuse a model") {
  models::Facets cracked = kCube;
  for (Vertex& v : cracked[4].vertices)
    v.y -= 0.02F;
  CHECK(refusal_of(cracked, R"({"cracks": "refuse"})").empty());
}

TEST_CASE_METHOD(PlateFixture, "A file that a plate names many times gives each warning once") {
  models::Facets open = models::box({0, 0, 0}, {5, 5, 5});
  open.pop_back();
  add("open.stl", open);
  const PreparedJob job = prepare(
      R"({"cracks": "repair",
          "models": [{"file": "open.stl"}, {"file": "open.stl"}, {"file": "open.stl", "copies": 3}]})");
  CHECK(job.summary.warnings.size() == 1);
  CHECK_FALSE(job.summary.models[2].mesh.watertight);
}

TEST_CASE("A model of plausible size in a file that names no other unit has no hint") {
  CHECK(unit_hint({10, 10, 0.2}, {}, kRoom).empty());
  CHECK(unit_hint({2, 0.01, 0.01}, {}, kRoom).empty());
  CHECK(unit_hint({150, 96, 54}, {}, kRoom).empty());
  CHECK(unit_hint({10, 10, 10}, {{}, LengthUnit::Millimeter}, kRoom).empty());
  // The file's unit is millimetres, however small the model is.
  CHECK(unit_hint({0.1, 0.1, 0.1}, {{}, LengthUnit::Millimeter}, kRoom).empty());
  // A ticket overrules the file.
  CHECK(unit_hint({10, 10, 10}, {LengthUnit::Millimeter, LengthUnit::Inch}, kRoom).empty());
  CHECK(unit_hint({25.4, 25.4, 25.4}, {LengthUnit::Inch, LengthUnit::Inch}, kRoom).empty());
}

TEST_CASE("A file that names another unit gives a hint with the size in that unit") {
  CHECK(unit_hint({10, 8, 4}, {{}, LengthUnit::Inch}, kRoom) ==
        "the model's file names inches as its unit and is read in millimetres: in inches, the model would "
        "measure "
        "254 x 203.2 x 101.6 mm; if that is right, set \"unit\": \"inch\" in its ticket "
        "(contourctl submit --unit inch)");
}

TEST_CASE(
    "A model smaller than a millimetre or larger than the printer has a hint of a unit in which it fits") {
  CHECK(has(unit_hint({1.6, 1.2, 0.8}, {}, kRoom),
            "in inches, the model would measure 40.64 x 30.48 x 20.32 mm"));
  CHECK(has(unit_hint({0.04, 0.03, 0.06}, {}, kRoom), "in metres, the model would measure 40 x 30 x 60 mm"));
  CHECK(has(unit_hint({0.39, 0.31, 0.15}, {}, kRoom),
            "in inches, the model would measure 9.906 x 7.874 x 3.81 mm"));
  CHECK(has(unit_hint({0.0001, 0.0001, 0.01}, {}, kRoom),
            "in metres, the model would measure 0.1 x 0.1 x 10 mm"));
  CHECK(has(unit_hint({40'000, 30'000, 20'000}, {}, kRoom),
            "in micrometres, the model would measure 40 x 30 x 20 mm"));
  // A ticket's unit may be wrong, too.
  CHECK(has(unit_hint({254, 254, 254}, {LengthUnit::Inch, {}}, kRoom),
            "the model measures 254 x 254 x 254 mm if it is drawn in inches: in millimetres, the model would "
            "measure 10 x "
            "10 x 10 mm"));
  // No unit makes these plausible.
  CHECK(unit_hint({200, 20, 20}, {}, kRoom).empty());
  CHECK(unit_hint({4000, 3000, 2000}, {}, kRoom).empty());
  CHECK(unit_hint({0, 0, 0}, {}, kRoom).empty());
  CHECK(unit_hint({1e30, 1e30, 1e30}, {}, kRoom).empty());
}

TEST_CASE("Coordinates so far from the origin that floats are 5 um apart give a warning") {
  const auto at = [](double place) { return Bounds{0, place, 0, 1, place + 10, 1}; };
  CHECK(precision_warning(at(4e6), 1) ==
        "the model lies 4000 m from the origin, where the file's numbers are 0.25 mm apart: finer detail is "
        "lost; "
        "move the model to the origin and export it again");
  CHECK_FALSE(precision_warning(at(-4e6), 1).empty());
  CHECK(precision_warning(at(60'000), 1).empty());
  CHECK_FALSE(precision_warning(at(70'000), 1).empty());
  // 7 m of a file in metres.
  CHECK(precision_warning(at(7), 1000).empty());
  CHECK_FALSE(precision_warning(at(100), 1000).empty());
  CHECK(precision_warning({}, 1).empty());
  // The model is large, not far.
  CHECK(precision_warning({0, 0, 0, 2e5, 1, 1}, 1).empty());
}

TEST_CASE("The unit that a 3MF or AMF file names wins over the one that was asked for, with a warning") {
  CHECK(applies_unit("3mf"));
  CHECK(applies_unit("amf"));
  CHECK_FALSE(applies_unit("binary"));
  CHECK_FALSE(applies_unit("obj"));
  const ModelUnit inches_asked{LengthUnit::Inch, LengthUnit::Micrometer, true};
  CHECK(has(unit_conflict(inches_asked), "inches, is ignored, because the file names its own, micrometres"));
  CHECK(unit_conflict({LengthUnit::Inch, LengthUnit::Inch, true}).empty());
  CHECK(unit_conflict({{}, LengthUnit::Inch, true}).empty());
  CHECK(unit_conflict({LengthUnit::Inch, LengthUnit::Millimeter, false}).empty());
  CHECK(unit_hint({26, 9, 6}, inches_asked, kRoom).empty());
  CHECK(unit_hint({26, 9, 6}, {{}, LengthUnit::Inch, true}, kRoom).empty());
  // The file's unit may be wrong, and the ticket's unit would not help.
  CHECK(
      unit_hint({0.04, 0.03, 0.06}, {{}, LengthUnit::Millimeter, true}, kRoom) ==
      "the model measures 0.04 x 0.03 x 0.06 mm in the unit that its file names, millimetres: in metres, it "
      "would measure 40 x 30 x 60 mm; if that is right, set \"scale\": 1000 in its ticket (contourctl submit "
      "--scale 1000)");
}

TEST_CASE_METHOD(PrintJobFixture, "A ticket's unit scales the model, its holes stay in millimetres") {
  const PreparedJob job =
      prepare(models::box({0, 0, 0}, {1, 0.5, 0.25}), R"({"unit": "inch", "scale": 0.5, "drain": [
      {"position_mm": {"x": 12.7, "y": 6.35}, "direction": {"z": 1}, "diameter_mm": 2}]})");
  const ModelSummary& model = job.summary.models[0];
  CHECK(model.size_x_mm == testing::Approx(12.7));
  CHECK(model.size_z_mm == testing::Approx(3.175));
  CHECK(job.summary.warnings.empty());
  const double pixel = 0.05 * 0.05, drilled = 12.7 * 6.35 - 3.14159 * 0.25;
  CHECK(job.plan.engine->mask_at(Nanometers{1'000'000}).lit_area() * pixel ==
        testing::Approx(drilled).epsilon(0.01));
  CHECK(refusal_of(models::box({0, 0, 0}, {1e37F, 1, 1}), R"({"unit": "m"})") ==
        "the model is too large: its coordinates leave the range of numbers");
}

TEST_CASE_METHOD(
    PrintJobFixture,
    "A job whose model is in an unlikely unit or imprecise gets a warning, or is refused with it") {
  const models::Facets inches = models::box({0, 0, 0}, {0.4F, 0.3F, 0.2F});
  REQUIRE(prepare(inches).summary.warnings.size() == 1);
  CHECK(
      has(prepare(inches).summary.warnings[0], "in inches, the model would measure 10.16 x 7.62 x 5.08 mm"));
  // A scaled model has the size that is meant.
  CHECK(prepare(inches, R"({"scale": 1.5})").summary.warnings.empty());
  CHECK(prepare(inches, R"({"fit": true})").summary.warnings.empty());
  const std::string metres = refusal_of(models::box({0, 0, 0}, {0.04F, 0.03F, 0.02F}));
  CHECK(has(metres, "the model is 0.02 mm high, too thin for a layer"));
  CHECK(
      has(metres,
          "; the model measures 0.04 x 0.03 x 0.02 mm if it is drawn in millimetres: in metres, the model"));
  // Too high, and too wide.
  CHECK(has(refusal_of(models::box({0, 0, 0}, {9000, 9000, 9000})), "set \"unit\": \"um\""));
  CHECK(has(refusal_of(models::box({0, 0, 0}, {9000, 9000, 100})), "set \"unit\": \"um\""));
  CHECK_FALSE(has(refusal_of(models::box({0, 0, 0}, {200, 20, 20})), "unit"));
  models::Facets far = testing::kCube;
  models::translate(far, 0, 4e6F, 0);
  REQUIRE(prepare(far).summary.warnings.size() == 1);
  CHECK(has(prepare(far).summary.warnings[0], "0.25 mm apart"));
}

TEST_CASE_METHOD(PlateFixture, "The models of a plate have their own units") {
  add("part.stl", models::box({0, 0, 0}, {1, 0.5, 0.25}));
  const PreparedJob job = prepare(R"({"models": [{"file": "part.stl"}, {"file": "part.stl", "unit": "cm"},
                                                {"file": "part.stl", "unit": "inch"}]})");
  CHECK(job.summary.models[0].size_x_mm == testing::Approx(1));
  CHECK(job.summary.models[1].size_x_mm == testing::Approx(10));
  CHECK(job.summary.models[2].size_x_mm == testing::Approx(25.4));
  add("tiny.stl", models::box({0, 0, 0}, {0.4F, 0.3F, 0.2F}));
  const PreparedJob tiny = prepare(R"({"models": [{"file": "tiny.stl"}]})");
  REQUIRE(tiny.summary.warnings.size() == 1);
  CHECK(tiny.summary.warnings[0].starts_with("tiny.stl: the model measures 0.4 x 0.3 x 0.2 mm"));
}
