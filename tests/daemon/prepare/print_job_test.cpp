#include "daemon/prepare/print_job.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "core/layers/layers.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/support_counts.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using contourd::testing::TemporaryFolder;

namespace {

// A spool with one model of 96 x 54 mm room, 50 um pixels (the shipped simulated printer).
class Desk {
 public:
  Desk()
      : printer(load_printer_config(std::filesystem::path(CONTOURD_CONFIG_DIR) / "simulated.json")),
        resin(find_resin(printer, printer.resin)) {
    printer.supports = SupportPolicy::Off;
  }

  PreparedJob prepare(const models::Facets& facets, const std::string& ticket = "") {
    JobFiles files{"part", folder_.path() / "part.stl", std::nullopt};
    models::write_binary_stl(files.model, facets);
    if (!ticket.empty()) files.ticket = folder_.write("part.json", ticket);
    JobSettings settings = read_settings(files, printer);
    if (!settings.ticket.resin) settings.resin = resin;
    return prepare_job(files, settings, printer);
  }

  // With supports.
  std::optional<PreparedJob> prepare_until(const models::Facets& facets, const std::stop_token& stop) {
    const JobFiles files{"part", folder_.path() / "part.stl", std::nullopt};
    models::write_binary_stl(files.model, facets);
    JobSettings settings = read_settings(files, printer);
    settings.supports = SupportPolicy::Auto;
    return prepare_job(files, settings, printer, stop);
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
  ResinProfile resin;  // of jobs that name none

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

TEST_CASE("A model is turned so that it prints best when its ticket leaves that to contourd") {
  Desk desk;
  // On its point as it is drawn.
  models::Facets cone = models::cone(6, 20, 48);
  orient(cone, {.up = Direction{0, 0, -1}});
  const PreparedJob drawn = desk.prepare(cone);
  CHECK_FALSE(drawn.summary.models[0].orientation);
  const PreparedJob job = desk.prepare(cone, R"({"up": "auto"})");
  const ModelSummary& model = job.summary.models[0];
  REQUIRE(model.orientation);
  CHECK(model.up == Direction{0, 0, -1});
  CHECK(model.orientation->choice.chosen().contacts == 0);
  CHECK(job.plan.engine->mask_at(Nanometers{100'000}).lit_area() >
        100 * drawn.plan.engine->mask_at(Nanometers{100'000}).lit_area());
}

TEST_CASE("A model that prints well as it is drawn is not turned") {
  const PreparedJob job = Desk().prepare(kCube, R"({"up": "fast"})");
  CHECK(job.summary.models[0].up == Direction{0, 0, 1});
  CHECK(lit_box(job.plan.engine->mask_at(Nanometers{1'000'000})) == Lit{760, 1159, 340, 739});
}

TEST_CASE("A model that is too high for the machine is laid down where that is left to contourd") {
  Desk desk;
  const models::Facets column = models::box({0, 0, 0}, {10, 10, 80});
  desk.printer.travel = Nanometers{60'000'000};
  CHECK_FALSE(desk.refusal_of(column).empty());
  CHECK(desk.prepare(column, R"({"up": "auto"})").summary.height_mm < 50);
}

TEST_CASE("The resin's weights, the scale and what is to be kept clean decide what points up") {
  Desk desk;
  const models::Facets plate = models::box({0, 0, 0}, {20, 4, 20});
  CHECK(desk.prepare(plate, R"({"up": "auto"})").summary.height_mm == 20);
  desk.resin.orientation = {
      .support = 0, .contacts = 0, .peel = 0, .height = 1, .standing = 0, .keep_clean = 0};
  CHECK(std::abs(desk.prepare(plate, R"({"up": "auto"})").summary.height_mm - 4) < 1e-5);  // float's rounding
  CHECK(std::abs(desk.prepare(plate, R"({"up": "auto", "scale": 2})").summary.height_mm - 8) < 1e-5);
  desk.resin.orientation.keep_clean = 100;
  const std::string clean = R"({"up": "auto", "keep_clean": [{"y": 1}, {"y": -1}]})";
  CHECK(desk.prepare(plate, clean).summary.height_mm == 20);
}

TEST_CASE("A model without facets is refused as any, also where its way up is to be found") {
  CHECK_FALSE(Desk().refusal_of({}, R"({"up": "auto"})").empty());
}

TEST_CASE("A cube lies in the middle of the display, at its true size") {
  Desk desk;
  const PreparedJob job = desk.prepare(kCube);
  CHECK(job.summary.layers.count == 400);
  CHECK(job.plan.expected_layers == std::vector(400, Nanometers{50'000}));
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  CHECK(lit_box(mask) == Lit{760, 1159, 340, 739});
  CHECK(mask.lit_area() == 160000.0);
}

TEST_CASE("Whatever goes wrong while a job is prepared refuses that job, in a sentence") {
  // On the worker's thread nothing else would catch it, and another job's exposure may be under way.
  Desk desk;
  desk.printer.uniformity.emplace(Pixels{3}, Pixels{2});
  std::string reason;
  CHECK_NOTHROW(reason = desk.refusal_of(kCube));
  CHECK(reason == "the job cannot be prepared: the uniformity mask does not have the display's size");
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
  CHECK(job.summary.models[0].scale.x == contourd::testing::Approx(1079 * 0.05 / 20).epsilon(1e-6));
  CHECK(job.summary.models[0].size_z_mm == contourd::testing::Approx(1079 * 0.05).epsilon(1e-6));
  CHECK(job.summary.models[0].size_x_mm ==
        contourd::testing::Approx(job.summary.models[0].size_z_mm).epsilon(1e-6));
}

TEST_CASE("Fit makes a tower no higher than the machine can print") {
  Desk desk;
  const PreparedJob job = desk.prepare(models::box({0, 0, 0}, {1, 1, 100}), R"({"fit": true})");
  // 160 mm of travel less 6 mm of lift; float coordinates.
  CHECK(job.summary.models[0].size_z_mm == contourd::testing::Approx(154.0).epsilon(1e-6));
}

TEST_CASE("A rotation stands a flat box up, and it is printed from its new lowest point") {
  Desk desk;
  const PreparedJob job =
      desk.prepare(models::box({0, 0, 0}, {10, 20, 5}), R"({"rotation_deg": {"x": 90, "y": 0, "z": 0}})");
  CHECK(job.summary.models[0].size_y_mm == 5.0);
  CHECK(job.summary.models[0].size_z_mm == 20.0);
  CHECK(job.summary.layers.count == 400);
}

TEST_CASE("What cannot be printed is refused with one sentence that has the figures") {
  Desk desk;
  CHECK(
      desk.refusal_of(models::box({0, 0, 0}, {97, 10, 10})) ==
      "the model (97.00 x 10.00 mm, its centre 0.00, 0.00 mm from the plate's) reaches 0.50 mm over the left "
      "edge and 0.50 mm over the right edge of the build area (96.00 x 54.00 mm)");
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {10, 10, 155})) ==
        "the model is 155.00 mm high, the machine can print 154.00 mm (its travel less the lift)");
  CHECK(desk.refusal_of({}) == "the file holds no facets");
  CHECK(desk.refusal_of(models::box({0, 0, 3}, {10, 10, 3})) ==
        "the model is flat: it has no height to print");
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {1e38F, 1, 1}), R"({"scale": 1000})") ==
        "the model is too large: its coordinates leave the range of numbers");
}

TEST_CASE("A model of which nothing would be printed is refused with its size") {
  Desk desk;
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {0.02F, 0.03F, 0.5F})) ==
        "nothing of the model would be printed: in 10 layers, no pixel of 0.05 mm gets 64 of 255 of the "
        "light; it is "
        "0.02 x 0.03 x 0.5 mm");
  // Its one layer is cut above it.
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {5, 5, 0.01F})) ==
        "nothing of the model would be printed: in 1 layer, no pixel of 0.05 mm gets 64 of 255 of the light; "
        "it is 5 x 5 x "
        "0.01 mm");
  const std::string drill = R"({"drain": [
    {"position_mm": {"x": 1, "y": 1}, "direction": {"z": 1}, "diameter_mm": 4}]})";
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {2, 2, 2}), drill) ==
        "nothing of the model would be printed: in 40 layers, no pixel of 0.05 mm gets 64 of 255 of the "
        "light; it is 2 x "
        "2 x "
        "2 mm less its drain holes");
  // Two pixels by two, and only above what is too thin.
  models::Facets needle = models::box({-0.01F, -0.01F, 0}, {0.01F, 0.01F, 0.3F});
  const models::Facets head = models::box({-0.05F, -0.05F, 0.3F}, {0.05F, 0.05F, 0.5F});
  needle.insert(needle.end(), head.begin(), head.end());
  CHECK(desk.refusal_of(needle).empty());
  // Seven tenths of a pixel, half in each of two: 89 of 255.
  const models::Facets sheet = models::box({-5, -0.0175F, 0}, {5, 0.0175F, 5});
  CHECK(desk.refusal_of(sheet).empty());
  desk.printer.tone.threshold = 100;
  CHECK(desk.refusal_of(sheet) ==
        "nothing of the model would be printed: in 100 layers, no pixel of 0.05 mm gets 100 of 255 of the "
        "light; "
        "it is 10 x 0.035 x 5 mm");
}

TEST_CASE("A model beyond the plate only by its position is refused") {
  Desk desk;
  CHECK(desk.refusal_of(kCube, R"({"position_mm": {"x": 38.1, "y": 0}})")
            .find("reaches 0.10 mm over the right edge") != std::string::npos);
  CHECK(desk.refusal_of(kCube, R"({"position_mm": {"x": 38, "y": 0}})").empty());
}

TEST_CASE("A wrong ticket refuses the job with all that is wrong with it") {
  Desk desk;
  const std::string refusal = desk.refusal_of(kCube, R"({"copies": 0, "colour": "red"})");
  CHECK(refusal.find("/copies") != std::string::npos);
  CHECK(refusal.find("colour") != std::string::npos);
}

TEST_CASE("More layers than can be printed are refused with their number") {
  Desk desk;
  // As no machine is, so that nothing else is wrong.
  desk.printer.travel = Nanometers{20'000'000'000'000};
  desk.resin.layer_height = desk.resin.layer_height_min = Nanometers{1'000};
  CHECK(desk.refusal_of(models::box({0, 0, 0}, {5, 5, 16'384})) ==
        "the model has 16384000 layers, at most 10000000 can be printed");
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
        std::vector<std::string>{"the model is inside out: its facets were turned outwards"});
  CHECK(job.plan.engine->mask_at(Nanometers{1'000'000}).lit_area() == 160000.0);
}

TEST_CASE("A direction that points up stands a flat box up as the angles do") {
  Desk desk;
  const PreparedJob job = desk.prepare(models::box({0, 0, 0}, {10, 20, 5}), R"({"up": {"y": 3}})");
  CHECK(job.summary.models[0].size_y_mm == 5.0);
  CHECK(job.summary.models[0].size_z_mm == 20.0);
}

TEST_CASE("A drain hole is taken out of the part as it stands and one beside it refuses the job") {
  Desk desk;
  // Up from the face that stands on the plate, and into one of its sides.
  const std::string holes = R"({"copies": 2, "drain": [
    {"position_mm": {"x": 10, "y": 10}, "direction": {"z": 1}, "diameter_mm": 4, "depth_mm": 5},
    {"position_mm": {"x": 0, "y": 10, "z": 10}, "direction": {"x": 1}, "diameter_mm": 2}]})";
  const PreparedJob job = desk.prepare(kCube, holes);
  CHECK(job.summary.models[0].drain_holes == 2);
  for (ContourEngine* engine : {job.plan.engine.get(), job.analysis_engine.get()}) {
    // By pixel centres: a circle of 40 pixels' radius within a thousandth.
    CHECK(320000 - engine->mask_at(Nanometers{2'000'000}).lit_area() ==
          contourd::testing::Approx(2 * 5026.5).epsilon(2e-3));
    CHECK(engine->mask_at(Nanometers{6'000'000}).lit_area() == 320000);
    // 5 mm deep and 2 mm wide: 100 by 40 pixels.
    CHECK(320000 - engine->mask_at(Nanometers{10'000'000}).lit_area() ==
          contourd::testing::Approx(2 * 4000).epsilon(0.01));
  }
  const std::string refusal = desk.refusal_of(kCube, R"({"drain": [
    {"position_mm": {"x": 10, "y": 40}, "direction": {"z": 1}, "diameter_mm": 4}]})");
  CHECK(refusal.find("drain hole 1 of the model is beside the model: from 10, 40, 0 mm on") == 0);
}

TEST_CASE("Factors by axis and the resin's shrinkage change a cube by whole pixels") {
  Desk desk;
  desk.resin.shrinkage_factors = {1.25, 1, 1};
  const PreparedJob job = desk.prepare(kCube, R"({"scale": {"y": 0.5, "z": 0.25}})");
  // 25 mm by 10 mm around the middle.
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  CHECK(lit_box(mask) == Lit{710, 1209, 440, 639});
  CHECK(mask.lit_area() == 500.0 * 200.0);
  CHECK(job.summary.layers.count == 100);
  CHECK(job.summary.models[0].scale == Scale{1, 0.5, 0.25});
}

TEST_CASE("Fit fills the display with a part that is made larger against shrinkage") {
  Desk desk;
  desk.resin.shrinkage_factors = {1, 1.25, 1};
  const PreparedJob job = desk.prepare(kCube, R"({"fit": true})");
  CHECK(job.summary.models[0].size_y_mm == contourd::testing::Approx(1079 * 0.05).epsilon(1e-6));
  CHECK(job.summary.models[0].size_x_mm == contourd::testing::Approx(1079 * 0.05 / 1.25).epsilon(1e-6));
}

TEST_CASE("Adaptive layers are thin on slopes and thick on walls, within what the resin prints") {
  Desk desk;
  desk.resin.exposure = WorkingCurve{Micrometers{150}, 9, Micrometers{60}, Micrometers{200}};
  const PreparedJob job = desk.prepare(models::cone(8, 8, 96), R"({"adaptive_layers": {"cusp_um": 40}})");
  CHECK(job.summary.layers.adaptive);
  // 40 um on a slope of nearly 45 degrees: its facets are a little less steep than the round cone.
  CHECK(job.summary.layers.thickest == Nanometers{56'000});
  CHECK(job.summary.layers.count == 143);
  CHECK(job.plan.exposure(20, Nanometers{50'000}) < job.plan.exposure(20, Nanometers{100'000}));
  CHECK(desk.prepare(kCube, R"({"adaptive_layers": {"cusp_um": 40}})").summary.layers.count == 200);
  CHECK(desk.refusal_of(kCube, R"({"adaptive_layers": {"cusp_um": 40, "min_um": 10}})")
            .find("the layer height cannot be printed") == 0);
}

TEST_CASE("With supports a model that stands by itself is printed as without") {
  Desk desk;
  PreparedJob without = desk.prepare(kCube), with = desk.prepare(kCube, R"({"supports": "auto"})");
  CHECK_FALSE(without.summary.supports);
  REQUIRE(with.summary.supports);
  CHECK_FALSE(counts_of(*with.summary.supports).any());
  CHECK(with.summary.height_mm == without.summary.height_mm);
  REQUIRE(with.plan.expected_layers == without.plan.expected_layers);
  for (const Nanometers height : middles_of(without.plan.expected_layers))
    REQUIRE(with.plan.engine->mask_at(height) == without.plan.engine->mask_at(height));
}

TEST_CASE("With supports a ball is lifted by whole layers and both engines expose what holds it") {
  Desk desk;
  const models::Facets ball = models::sphere(5, 32);
  PreparedJob job = desk.prepare(ball, R"({"supports": "auto", "layer_height_um": 70})");
  REQUIRE(job.summary.supports);
  const SupportCounts counts = counts_of(*job.summary.supports);
  CHECK(counts.islands >= 1);
  CHECK(counts.unheld == 0);
  CHECK(counts.feet >= 1);
  const Nanometers lift = job.plan.engine->models().front().elevation.above_plate();
  CHECK(lift >= Nanometers{5'000'000});
  CHECK(lift.count() % 70'000 == 0);
  CHECK(job.summary.height_mm == Approx(to_millimeters(lift).count() + 10));  // 5 um: the mesh's coarseness
  // Beneath the ball there are supports alone.
  const Nanometers beneath = lift / 2;
  CHECK(job.plan.engine->mask_at(beneath).lit_area() > 0);
  CHECK(job.plan.engine->mask_at(beneath) == job.analysis_engine->mask_at(beneath));
  CHECK(job.plan.engine->intersecting_facets() == 0);
}

TEST_CASE("The printer's file says whether there are supports, and a ticket otherwise") {
  Desk desk;
  desk.printer.supports = SupportPolicy::Auto;
  CHECK(desk.prepare(models::sphere(5, 32)).summary.supports);
  CHECK_FALSE(desk.prepare(models::sphere(5, 32), R"({"supports": "off"})").summary.supports);
}

TEST_CASE("A model that is too high once it is lifted is refused with the figures") {
  Desk desk;
  // 154 mm can be printed: 160 mm less the lift of 6 mm.
  CHECK(desk.refusal_of(models::sphere(20, 32), R"({"supports": "auto", "scale": {"z": 3.8}})") ==
        "the model is 152.00 mm high and stands 5.00 mm above the plate, on supports: 157.00 mm, and the "
        "machine can print 154.00 mm (its travel less the lift)");
  CHECK(desk.refusal_of(models::sphere(20, 32), R"({"supports": "off", "scale": {"z": 3.8}})").empty());
}

TEST_CASE("A model that is to fill the machine leaves room for the supports beneath it") {
  Desk desk;
  const PreparedJob job =
      desk.prepare(models::box({0, 0, 0}, {2, 2, 100}), R"({"supports": "auto", "fit": true})");
  CHECK(job.summary.height_mm == Approx(154 - 5 - 0.1));  // 0.1 mm is the thickest layer
}

TEST_CASE("Copies that are held stand so far apart that a foot has room between them") {
  Desk desk;
  const auto distance = [&](const models::Facets& facets) {
    const auto centers =
        desk.prepare(facets, R"({"supports": "auto", "copies": 2})").summary.models.front().centers;
    return std::abs(centers[1].x - centers[0].x) + std::abs(centers[1].y - centers[0].y);
  };
  CHECK(distance(kCube) == Approx(20 + 2));
  CHECK(distance(models::sphere(5, 32)) == Approx(10 + 4 + 2 * 0.5).margin(0.01));  // of a mesh of 32 corners
}

TEST_CASE("A search for supports that is given up prepares no job") {
  Desk desk;
  std::stop_source stop;
  stop.request_stop();
  CHECK_FALSE(desk.prepare_until(models::sphere(5, 32), stop.get_token()));
  CHECK(desk.prepare_until(models::sphere(5, 32), {}));
}

TEST_CASE("Adaptive layers without a working curve are refused") {
  Desk desk;
  CHECK(desk.refusal_of(kCube, R"({"adaptive_layers": {"cusp_um": 10}})") ==
        "adaptive layers need a resin with a working curve: the exposure times of \"standard\" hold for its "
        "layer height of 50 um only");
}

namespace {

// A plate's folder.
class PlateDesk : public Desk {
 public:
  PlateDesk() { std::filesystem::create_directory(plate_); }

  void add(const std::string& file, const models::Facets& facets) {
    models::write_binary_stl(plate_ / file, facets);
  }
  PreparedJob prepare(const std::string& ticket) {
    folder_.write("plate/plate.json", ticket);
    const JobFiles files{"plate", plate_, std::nullopt, true};
    return prepare_job(files, read_settings(files, printer), printer);
  }
  std::string refusal_of(const std::string& ticket) {
    try {
      (void)prepare(ticket);
    } catch (const JobRefused& refusal) {
      return refusal.what();
    }
    return "";
  }

 private:
  TemporaryFolder folder_;
  std::filesystem::path plate_ = folder_.path() / "plate";
};

}  // namespace

TEST_CASE("A plate's models are printed together, each as its entry says") {
  PlateDesk desk;
  desk.add("cube.stl", kCube);
  desk.add("bar.stl", models::box({100, 100, 100}, {110, 104, 102}));
  const PreparedJob job = desk.prepare(R"({"layer_height_um": 100, "models": [
    {"file": "cube.stl", "position_mm": {"x": -20}, "scale": 0.5},
    {"file": "bar.stl", "position_mm": {"x": 10, "y": 5}, "copies": 2, "up": {"x": 1}}]})");
  CHECK(job.summary.plate);
  CHECK(job.summary.layers.count == 100);
  CHECK(job.summary.height_mm == 10);
  REQUIRE(job.summary.models.size() == 2);
  CHECK(job.summary.models[1].file == "bar.stl");
  CHECK(job.summary.models[1].size_z_mm == 10);
  CHECK(job.summary.models[1].centers.size() == 2);
  // The cube 200 by 200, two bars of 2 by 4 mm on end.
  const Mask& mask = job.plan.engine->mask_at(Nanometers{5'000'000});
  CHECK(mask.lit_area() == 200.0 * 200 + 2 * 40.0 * 80);
  CHECK(mask.lit_pixels() == 200 * 200 + 2 * 40 * 80);
  CHECK(job.plan.engine->contours_at(Nanometers{5'000'000}).loops.size() == 2);
}

TEST_CASE("A plate's warnings name the model") {
  PlateDesk desk;
  models::Facets open = kCube;
  open.pop_back();
  desk.add("open.stl", open);
  const PreparedJob job = desk.prepare(R"({"models": [{"file": "open.stl"}]})");
  REQUIRE(job.summary.warnings.size() == 1);
  CHECK(job.summary.warnings[0].find("open.stl: the model is not watertight") == 0);
}

TEST_CASE("A plate is refused with a sentence that names the model that is wrong") {
  PlateDesk desk;
  desk.add("cube.stl", kCube);
  desk.add("flat.stl", models::box({0, 0, 3}, {10, 10, 3}));
  desk.add("none.stl", {});
  CHECK(desk.refusal_of(R"({"models": [{"file": "cube.stl"}, {"file": "flat.stl"}]})") ==
        "flat.stl is flat: it has no height to print");
  CHECK(desk.refusal_of(R"({"models": [{"file": "none.stl"}]})") == "none.stl: the file holds no facets");
  CHECK(desk.refusal_of(R"({"models": [{"file": "cube.stl", "position_mm": {"y": -20}}]})") ==
        "cube.stl (20.00 x 20.00 mm, its centre 0.00, -20.00 mm from the plate's) reaches 3.00 mm over the "
        "front "
        "edge of the build area (96.00 x 54.00 mm)");
  CHECK(desk.refusal_of(R"({"models": [{"file": "gone.stl"}]})").find("gone.stl") != std::string::npos);
  CHECK(desk.refusal_of(R"({"models": [{"file": "cube.stl", "colour": 1}]})").find("/models/0/colour") !=
        std::string::npos);
}

TEST_CASE("A cracked model is refused when its ticket says so and named by its first open layer") {
  Desk desk;
  models::Facets cracked = models::box({0, 0, 0}, {20, 20, 10});
  models::Facets upper = models::box({5, 5, 10}, {15, 15, 20});
  // Without the facets of its front.
  std::erase_if(upper, [](const Facet& facet) {
    return std::ranges::all_of(facet.vertices, [](const Vertex& v) { return v.y == 5; });
  });
  cracked.insert(cracked.end(), upper.begin(), upper.end());
  const std::string refuse = R"({"layer_height_um": 100, "cracks": "refuse"})";
  CHECK(desk.refusal_of(cracked, refuse) ==
        "the model is cracked: contours do not close in 100 of 200 layers, first in layer 101 at 10.050 "
        "mm, and "
        "the widest gap is 10.000 mm; mend the model, or print it with \"cracks\": \"repair\" in its ticket");
  CHECK(desk.refusal_of(cracked, R"({"layer_height_um": 100, "cracks": "repair"})").empty());
  CHECK(desk.refusal_of(cracked).empty());
  CHECK(desk.refusal_of(kCube, refuse).empty());
}

TEST_CASE("What is mended in a mesh is told, and refused when the ticket says so") {
  Desk desk;
  const std::string refuse = R"({"layer_height_um": 100, "cracks": "refuse"})";
  const auto refusal = [](const std::string& what) {
    return "the model is cracked: its facets disagree with each other (to print it: " + what +
           "); mend the model, or print it with \"cracks\": \"repair\" in its ticket";
  };
  models::Facets turned = kCube, reversed = kCube, wall = kCube, doubled = kCube;
  std::swap(turned[4].vertices[0], turned[4].vertices[1]);
  CHECK(desk.refusal_of(turned, refuse) == refusal("1 facet turned round"));
  reversed.insert(reversed.end(),
                  {turned[4], {{kCube[5].vertices[0], kCube[5].vertices[2], kCube[5].vertices[1]}}});
  CHECK(desk.refusal_of(reversed, refuse) ==
        refusal("2 facets left out for being there once more, reversed"));
  const Bounds bounds = bounds_of(kCube);
  const auto x = static_cast<float>(bounds.center().x), y = static_cast<float>(bounds.center().y);
  wall.push_back({{Vertex{x, y, 2}, Vertex{x + 3, y, 2}, Vertex{x, y, 8}}});
  CHECK(desk.refusal_of(wall, refuse) == refusal("1 facet of walls inside left out"));
  for (const models::Facets& dirty : {turned, reversed, wall})
    CHECK(desk.refusal_of(dirty).empty());
  // No guess, but told.
  doubled.push_back(kCube[3]);
  CHECK(desk.refusal_of(doubled, refuse).empty());
}

TEST_CASE("Gaps within a pixel are no reason to refuse a model") {
  Desk desk;
  models::Facets cracked = kCube;
  for (Vertex& v : cracked[4].vertices)
    v.y -= 0.02F;
  CHECK(desk.refusal_of(cracked, R"({"cracks": "refuse"})").empty());
}

TEST_CASE("A part that grows beyond the display is printed with a warning") {
  Desk desk;
  const models::Facets wide = models::box({0, 0, 0}, {96, 20, 1});
  CHECK(desk.prepare(wide).summary.warnings.empty());
  desk.resin.compensation.growth = Micrometers{80};
  CHECK(desk.prepare(wide).summary.warnings ==
        std::vector<std::string>{
            "the resin's growth_um moves contours 80 um beyond the display, where they are cut off"});
  CHECK(desk.prepare(kCube).summary.warnings.empty());
  desk.resin.compensation.growth = Micrometers{-80};
  CHECK(desk.prepare(wide).summary.warnings.empty());
}

TEST_CASE("A job whose masks do not keep their budget is refused, one that does carries the budget") {
  Desk desk;
  CHECK(desk.prepare(kCube).plan.mask_budget == std::chrono::seconds{1});
  desk.printer.mask_budget = Duration{0};
  CHECK(desk.refusal_of(kCube).find("the mask of layer 1 of 400 takes longer than mask_budget_ms, 0 ms") !=
        std::string::npos);
}

namespace {

// Of 84 + 50 facets bytes, all but the header a hole: no disk has to hold it.
void write_sparse_stl(const std::filesystem::path& path, std::uint32_t facets) {
  std::string header(84, '\0');
  std::memcpy(header.data() + 80, &facets, sizeof facets);
  std::ofstream(path, std::ios::binary) << header;
  std::filesystem::resize_file(path, 84 + std::uintmax_t{50} * facets);
}

// What a sparse file is refused with.
std::string refusal_of_sparse(const PrinterConfig& printer, std::uint32_t facets) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "huge.stl";
  write_sparse_stl(path, facets);
  try {
    (void)prepare_job({"huge", path, std::nullopt}, {JobTicket{}, find_resin(printer, printer.resin)},
                      printer);
  } catch (const JobTooLarge& refusal) {
    return refusal.what();
  }
  return "";
}

}  // namespace

TEST_CASE("A model that needs more memory than there is is refused with both figures before it is read") {
  Desk desk;
  desk.printer.memory_limit_bytes = 800'000'000;
  const std::string refusal = refusal_of_sparse(desk.printer, 85'899'344);
  CHECK(refusal.starts_with("the model holds 85899344 facets, for which "));
  // Of 800 MB, less what this program holds: some tens, or more than a hundred with sanitizers.
  const std::string before_room = " MB of memory are needed, and there is room for ";
  const std::size_t at = refusal.find(before_room);
  REQUIRE(at != std::string::npos);
  const int room_mb = std::stoi(refusal.substr(at + before_room.size()));
  CHECK(room_mb > 400);
  CHECK(room_mb < 800);
  CHECK(refusal.find(" MB: memory_limit_mb is 800, and contourd holds ") != std::string::npos);
  // Whatever this computer has, and however little of it is there.
  desk.printer.memory_limit_bytes.reset();
  const std::string more_than_any = refusal_of_sparse(desk.printer, 0xFFFFFFFF);
  CHECK(more_than_any.starts_with("the model holds 4294967295 facets, for which "));
  CHECK(more_than_any.find(" MB stay free") != std::string::npos);
}

TEST_CASE("A plate that names a file many times has one model of all that are turned and scaled alike") {
  PlateDesk desk;
  desk.add("cube.stl", kCube);
  desk.add("same.stl", kCube);
  const PreparedJob job = desk.prepare(R"({"models": [
    {"file": "cube.stl", "scale": 0.4}, {"file": "cube.stl", "scale": 0.4, "copies": 2},
    {"file": "cube.stl", "scale": 0.5}, {"file": "cube.stl", "scale": 0.4, "position_mm": {"x": 30}},
    {"file": "same.stl", "scale": 0.4}, {"file": "cube.stl", "scale": 0.4, "up": {"x": 1}}]})");
  const std::span<const PlateModel> models = job.plan.engine->models();
  REQUIRE(models.size() == 6);
  CHECK(models[1].model == models[0].model);
  CHECK(models[3].model == models[0].model);
  for (const std::size_t other : {2U, 4U, 5U})
    CHECK(models[other].model != models[0].model);
  REQUIRE(job.summary.models.size() == 6);
  for (const ModelSummary& model : job.summary.models) {
    CHECK(model.mesh.facets == 12);
    CHECK(model.mesh.watertight);
  }
  CHECK(job.summary.models[2].size_x_mm == 10);
  CHECK(job.summary.models[3].size_x_mm == 8);
  CHECK(job.summary.models[1].centers.size() == 2);
  // Six of 8 by 8 mm and one of 10 by 10.
  CHECK(job.plan.engine->mask_at(Nanometers{5'000'000}).lit_area() == (6 * 160.0 * 160 + 200.0 * 200));
}

TEST_CASE("What is odd about a file or a model that a plate names many times is told once") {
  PlateDesk desk;
  models::Facets open = models::box({0, 0, 0}, {5, 5, 5});
  open.pop_back();
  desk.add("open.stl", open);
  const PreparedJob job = desk.prepare(
      R"({"models": [{"file": "open.stl"}, {"file": "open.stl"}, {"file": "open.stl", "copies": 3}]})");
  CHECK(job.summary.warnings.size() == 1);
  CHECK_FALSE(job.summary.models[2].mesh.watertight);
}
