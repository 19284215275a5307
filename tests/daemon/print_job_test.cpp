#include "daemon/print_job.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using contourd::testing::TemporaryFolder;

namespace {

// A spool with one model of 96 x 54 mm room, 50 um pixels (the shipped simulated printer).
class Desk {
 public:
  Desk() : printer(load_printer_config(std::filesystem::path(CONTOURD_CONFIG_DIR) / "simulated.json")) {}

  PreparedJob prepare(const models::Facets& facets, const std::string& ticket = "") {
    JobFiles files{"part", folder_.path() / "part.stl", std::nullopt};
    models::write_binary_stl(files.model, facets);
    if (!ticket.empty()) files.ticket = folder_.write("part.json", ticket);
    return prepare_job(files, printer);
  }

  std::string refusal_of(const models::Facets& facets, const std::string& ticket = "") {
    try {
      (void)prepare(facets, ticket);
    } catch (const JobRefused& refusal) {
      return refusal.what();
    }
    return "";
  }

  PrinterConfig printer;

 private:
  TemporaryFolder folder_;
};

const models::Facets kCube = models::box({0, 0, 0}, {20, 20, 20});

// Columns and rows that hold light.
struct Lit {
  int left, right, top, bottom;
  bool operator==(const Lit&) const = default;
};

Lit lit_box(const Mask& mask) {
  Lit lit{mask.width().count(), -1, mask.height().count(), -1};
  for (int y = 0; y < mask.height().count(); ++y) {
    const auto row = mask.row(y);
    for (int x = 0; x < mask.width().count(); ++x) {
      if (row[static_cast<std::size_t>(x)] == 0) continue;
      lit = {std::min(lit.left, x), std::max(lit.right, x), std::min(lit.top, y), std::max(lit.bottom, y)};
    }
  }
  return lit;
}

}  // namespace

TEST_CASE("A cube lies in the middle of the display, at its true size") {
  Desk desk;
  const PreparedJob job = desk.prepare(kCube);
  CHECK(job.plan.layers.count == 400);
  CHECK(job.plan.exposures.size() == 400);
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  CHECK(lit_box(mask) == Lit{760, 1159, 340, 739});
  CHECK(mask.lit_area() == 160000.0);
}

TEST_CASE("A ticket's position moves the part to the right and up") {
  Desk desk;
  const PreparedJob job = desk.prepare(kCube, R"({"position_mm": {"x": 10, "y": 5}})");
  CHECK(lit_box(job.plan.engine->mask_at(Nanometers{1'000'000})) == Lit{960, 1359, 240, 639});
}

TEST_CASE("Copies lie side by side around the plate's centre, 2 mm apart") {
  Desk desk;
  const PreparedJob job = desk.prepare(kCube, R"({"copies": 4})");
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  // Two by two: 42 mm, 840 pixels.
  CHECK(lit_box(mask) == Lit{540, 1379, 120, 959});
  CHECK(mask.lit_area() == 4 * 160000.0);
}

TEST_CASE("Eight copies fill the plate and nine are refused") {
  Desk desk;
  CHECK(desk.prepare(kCube, R"({"copies": 8})").plan.engine->mask_at(Nanometers{1'000'000}).lit_area() ==
        8 * 160000.0);
  CHECK(desk.refusal_of(kCube, R"({"copies": 9})") ==
        "9 copies of 20.00 x 20.00 mm do not fit on the plate (96.00 x 54.00 mm); there is room for 8");
}

TEST_CASE("Fit makes the part as large as the display allows, in all three directions alike") {
  Desk desk;
  const PreparedJob job = desk.prepare(kCube, R"({"fit": true})");
  // Equation 3.8: R = height - 1 pixels, for 20 mm.
  CHECK(job.summary.scale == contourd::testing::Approx(1079 * 0.05 / 20).epsilon(1e-6));
  CHECK(job.summary.size_z_mm == contourd::testing::Approx(1079 * 0.05).epsilon(1e-6));
  CHECK(job.summary.size_x_mm == contourd::testing::Approx(job.summary.size_z_mm).epsilon(1e-6));
}

TEST_CASE("Fit makes a tower no higher than the machine can print") {
  Desk desk;
  const PreparedJob job = desk.prepare(models::box({0, 0, 0}, {1, 1, 100}), R"({"fit": true})");
  // 160 mm of travel less 6 mm of lift; float coordinates.
  CHECK(job.summary.size_z_mm == contourd::testing::Approx(154.0).epsilon(1e-6));
}

TEST_CASE("A rotation stands a flat box up, and it is printed from its new lowest point") {
  Desk desk;
  const PreparedJob job =
      desk.prepare(models::box({0, 0, 0}, {10, 20, 5}), R"({"rotation_deg": {"x": 90, "y": 0, "z": 0}})");
  CHECK(job.summary.size_y_mm == 5.0);
  CHECK(job.summary.size_z_mm == 20.0);
  CHECK(job.plan.layers.count == 400);
}

TEST_CASE("What cannot be printed is refused with one sentence that has the figures") {
  Desk desk;
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {97, 10, 10})) ==
        "the model (97.00 x 10.00 mm, its centre 0.00, 0.00 mm from the plate's) reaches beyond the display "
        "(96.00 x "
        "54.00 mm)");
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {10, 10, 155})) ==
        "the model is 155.00 mm high, the machine can print 154.00 mm (its travel less the lift)");
  CHECK(desk.refusal_of({}) == "the STL file holds no facets");
  CHECK(desk.refusal_of(models::box({0, 0, 3}, {10, 10, 3})) ==
        "the model is flat: it has no height to print");
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {1e38F, 1, 1}), R"({"scale": 1000})") ==
        "the model is too large: its coordinates leave the range of numbers");
}

TEST_CASE("A model beyond the plate only by its position is refused") {
  Desk desk;
  CHECK(
      desk.refusal_of(kCube, R"({"position_mm": {"x": 38.1, "y": 0}})").find("reaches beyond the display") !=
      std::string::npos);
  CHECK(desk.refusal_of(kCube, R"({"position_mm": {"x": 38, "y": 0}})").empty());
}

TEST_CASE("A wrong ticket refuses the job with all that is wrong with it") {
  Desk desk;
  const std::string refusal = desk.refusal_of(kCube, R"({"copies": 0, "colour": "red"})");
  CHECK(refusal.find("/copies") != std::string::npos);
  CHECK(refusal.find("colour") != std::string::npos);
}

TEST_CASE("A layer height that the resin does not allow is refused") {
  Desk desk;
  CHECK(desk.refusal_of(kCube, R"({"layer_height_um": 5})").find("the layer height cannot be printed") == 0);
}

TEST_CASE("A model that is not watertight or inside out is printed, with a warning") {
  Desk desk;
  models::Facets open = kCube;
  open.pop_back();
  CHECK(desk.prepare(open).summary.warnings.size() == 1);
  models::Facets inverted = kCube;
  models::invert(inverted);
  const PreparedJob job = desk.prepare(inverted);
  CHECK(job.summary.warnings ==
        std::vector<std::string>{"the model is inside out; it is printed all the same"});
  CHECK(job.plan.engine->mask_at(Nanometers{1'000'000}).lit_area() == 160000.0);
}

TEST_CASE("A part that grows beyond the display is printed with a warning") {
  Desk desk;
  const models::Facets wide = models::box({0, 0, 0}, {96, 20, 1});
  CHECK(desk.prepare(wide).summary.warnings.empty());
  desk.printer.resin.compensation.growth = Micrometers{80};
  CHECK(desk.prepare(wide).summary.warnings ==
        std::vector<std::string>{
            "the resin's growth_um moves contours 80 um beyond the display, where they are cut off"});
  CHECK(desk.prepare(kCube).summary.warnings.empty());
  desk.printer.resin.compensation.growth = Micrometers{-80};
  CHECK(desk.prepare(wide).summary.warnings.empty());
}
