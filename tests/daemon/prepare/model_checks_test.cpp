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

TEST_CASE_METHOD(PrintJobFixture, "A model of which nothing would be printed is refused with its size") {
  CHECK(refusal_of(models::box({0, 0, 0}, {0.02F, 0.03F, 0.5F})) ==
        "nothing of the model would be printed: in 10 layers, no pixel of 0.05 mm reaches grey 64 of 255; it "
        "measures 0.02 x 0.03 x 0.5 mm");
  // The only layer is cut at a height above the model.
  CHECK(refusal_of(models::box({0, 0, 0}, {5, 5, 0.01F})) ==
        "nothing of the model would be printed: in 1 layer, no pixel of 0.05 mm reaches grey 64 of 255; it "
        "measures 5 x 5 x 0.01 mm");
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
  CHECK(prepare(open).summary.warnings.size() == 1);
  models::Facets inverted = kCube;
  models::invert(inverted);
  const PreparedJob job = prepare(inverted);
  CHECK(job.summary.warnings ==
        std::vector<std::string>{"the model is inside out: its facets were turned outwards"});
  CHECK(job.plan.engine->mask_at(Nanometers{1'000'000}).lit_area() == 160000.0);
}

TEST_CASE_METHOD(PlateFixture, "A plate's warnings name the model") {
  models::Facets open = kCube;
  open.pop_back();
  add("open.stl", open);
  const PreparedJob job = prepare(R"({"models": [{"file": "open.stl"}]})");
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
      R"({"models": [{"file": "open.stl"}, {"file": "open.stl"}, {"file": "open.stl", "copies": 3}]})");
  CHECK(job.summary.warnings.size() == 1);
  CHECK_FALSE(job.summary.models[2].mesh.watertight);
}
