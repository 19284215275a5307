#include "daemon/prepare/print_job.hpp"
#include "daemon/system/memory_room.hpp"

#include <fstream>
#include <numeric>

#include "core/layers/layers.hpp"
#include "core/support/support_counts.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/print/layer_durations.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/prepare/print_job_fixture.hpp"
#include "tests/daemon/print/rise_fixture.hpp"
#include "tests/message_of.hpp"

TEST_CASE_METHOD(PrintJobFixture,
                 "A model is turned to its best orientation if its ticket leaves that to contourd") {
  // Drawn standing on its point.
  models::Facets cone = models::cone(6, 20, 48);
  orient(cone, {.up = Direction{0, 0, -1}});
  const PreparedJob drawn = prepare(cone);
  CHECK_FALSE(drawn.summary.models[0].orientation);
  const PreparedJob job = prepare(cone, R"({"up": "auto"})");
  const ModelSummary& model = job.summary.models[0];
  REQUIRE(model.orientation);
  CHECK(model.up == Direction{0, 0, -1});
  CHECK(model.orientation->choice.chosen().contacts == 0);
  CHECK(job.plan.engine->mask_at(Nanometers{100'000}).lit_area() >
        100 * drawn.plan.engine->mask_at(Nanometers{100'000}).lit_area());
}

TEST_CASE("A model that prints well as drawn is not turned") {
  const PreparedJob job = PrintJobFixture().prepare(kCube, R"({"up": "fast"})");
  CHECK(job.summary.models[0].up == Direction{0, 0, 1});
  CHECK(lit_box(job.plan.engine->mask_at(Nanometers{1'000'000})) == Lit{760, 1159, 340, 739});
}

TEST_CASE_METHOD(
    PrintJobFixture,
    "A model that is too high for the machine is laid down if contourd chooses the orientation") {
  const models::Facets column = models::box({0, 0, 0}, {10, 10, 80});
  printer.travel = Nanometers{60'000'000};
  CHECK_FALSE(refusal_of(column).empty());
  CHECK(prepare(column, R"({"up": "auto"})").summary.height_mm < 50);
}

TEST_CASE_METHOD(
    PrintJobFixture,
    "The orientation depends on the resin's weights, the scale and the surfaces to be kept clean") {
  const models::Facets plate = models::box({0, 0, 0}, {20, 4, 20});
  CHECK(prepare(plate, R"({"up": "auto"})").summary.height_mm == 20);
  resin.orientation = {.support = 0, .contacts = 0, .peel = 0, .height = 1, .standing = 0, .keep_clean = 0};
  CHECK(std::abs(prepare(plate, R"({"up": "auto"})").summary.height_mm - 4) < 1e-5);  // float's rounding
  CHECK(std::abs(prepare(plate, R"({"up": "auto", "scale": 2})").summary.height_mm - 8) < 1e-5);
  resin.orientation.keep_clean = 100;
  const std::string clean = R"({"up": "auto", "keep_clean": [{"y": 1}, {"y": -1}]})";
  CHECK(prepare(plate, clean).summary.height_mm == 20);
}

TEST_CASE("A model without facets is refused even if contourd chooses the orientation") {
  CHECK_FALSE(PrintJobFixture().refusal_of({}, R"({"up": "auto"})").empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A cube lies in the middle of the display, at its true size") {
  const PreparedJob job = prepare(kCube);
  CHECK(job.summary.layers.count == 400);
  CHECK(job.plan.expected_layers == std::vector(400, Nanometers{50'000}));
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  CHECK(lit_box(mask) == Lit{760, 1159, 340, 739});
  CHECK(mask.lit_area() == 160000.0);
}

TEST_CASE_METHOD(PrintJobFixture, "A continuous job rises from its first layers to its top") {
  CHECK_FALSE(prepare(kCube).plan.rises);
  make_continuous();
  const models::Facets column = models::box({0, 0, 0}, {6, 6, 10});
  const PreparedJob job = prepare(column);
  REQUIRE(job.plan.rises);
  REQUIRE(job.plan.rises->each.size() == 1);
  const PlannedRise& rise = job.plan.rises->each[0];
  CHECK(rise.plan.points.front().height == Nanometers{50'000} * rise.first_layer);
  CHECK(rise.plan.points.front().height >= Nanometers{940'000});
  CHECK(rise.plan.points.back().height == Nanometers{10'000'000});
  CHECK(job.plan.rises->mask_step == Nanometers{2'000});
  CHECK(job.summary.warnings.empty());
  // 50 um at 55.26 mm/h, instead of exposures and lifts.
  const std::vector<Duration> durations = layer_durations(job.plan, printer);
  CHECK(durations[100] > 3250ms);
  CHECK(durations[100] < 3265ms);
  CHECK(durations.front() > 30s);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A continuous job is layered where it cannot rise, even if that is everywhere") {
  make_continuous();
  resin.viscosity_mpa_s = 2000;
  const models::Facets stem = models::box({-2, -2, 0}, {2, 2, 12}),
                       flange = models::box({-20, -20, 5}, {20, 20, 7});
  const PreparedJob job = prepare(models::together(stem, flange));
  REQUIRE(job.plan.rises);
  REQUIRE(job.plan.rises->each.size() == 2);
  const RisePlan &first = job.plan.rises->each[0].plan, &second = job.plan.rises->each[1].plan;
  CHECK(first.points.back().height <= Nanometers{5'000'000});
  CHECK(first.points.back().height > Nanometers{4'700'000});
  CHECK(second.points.front().height >= Nanometers{7'000'000});
  CHECK(second.points.front().height < Nanometers{7'300'000});
  REQUIRE(job.summary.warnings.size() == 1);
  CHECK(lacking(job.summary.warnings[0], {"are printed layer by layer"}) == "");
  // The forecast has the times of the plan.
  REQUIRE(job.summary.continuous);
  const std::vector<Duration> durations = layer_durations(job.plan, printer);
  const Duration sum = std::accumulate(durations.begin(), durations.end(), Duration{});
  CHECK(std::chrono::abs(job.summary.continuous->time() - sum) < 1us);
  const models::Facets foot = models::box({-20, -20, 0}, {20, 20, 4});
  const PreparedJob layered = prepare(foot);
  CHECK_FALSE(layered.plan.rises);
  CHECK_FALSE(layered.summary.continuous);
  CHECK(layered.summary.resin.mode == PrintWay::Layered);
  REQUIRE(layered.summary.warnings.size() == 1);
  CHECK(lacking(layered.summary.warnings[0], {"is layered", "nowhere can the plate rise 1 mm"}) == "");
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A continuous job that the resin, its ticket or the panel rules out is refused") {
  make_continuous();
  CHECK(lacking(refusal_of(kCube, R"({"adaptive_layers": {"cusp_um": 10}})"), {"adaptive layers"}) == "");
  resin.undersides = Undersides::Dose;
  CHECK(lacking(refusal_of(kCube), {"undersides"}) == "");
  resin.undersides = Undersides::Plain;
  printer.grey_bits = 3;
  CHECK(lacking(refusal_of(kCube), {"grey_bits"}) == "");
  printer.grey_bits = 8;
  resin.continuous.reset();
  CHECK(lacking(refusal_of(kCube), {"lacks what continuous printing needs: continuous"}) == "");
}

TEST_CASE("Any error during preparation refuses the job with a sentence") {
  // An exception that left the worker's thread would end contourd, while another job may be exposing.
  PrintJobFixture fixture;
  fixture.printer.uniformity.emplace(Pixels{3}, Pixels{2});
  std::string reason;
  CHECK_NOTHROW(reason = fixture.refusal_of(kCube));
  CHECK(reason == "the job cannot be prepared: the uniformity mask does not have the display's size");
}

TEST_CASE_METHOD(PrintJobFixture, "A ticket's position moves the part to the right and up") {
  const PreparedJob job = prepare(kCube, R"({"position_mm": {"x": 10, "y": 5}})");
  CHECK(lit_box(job.plan.engine->mask_at(Nanometers{1'000'000})) == Lit{960, 1359, 240, 639});
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A model that is likely in another unit waits, unless its ticket has a unit") {
  const models::Facets tiny = models::box({0, 0, 0}, {1.6F, 1.2F, 0.8F});
  const auto analysis = analysis_of_preparation(prepare(tiny).summary);
  REQUIRE(analysis);
  CHECK(asked_findings(*analysis, printer) == std::vector<std::string>{"unit_in_doubt"});
  CHECK(lacking(analysis->warnings.at(0), {"in inches, the model would measure 40.64 x 30.48 x 20.32 mm"})
            .empty());
  for (const char* const answer : {R"({"unit": "mm"})", R"({"unit": "inch"})", R"({"scale": 1})"})
    CHECK_FALSE(analysis_of_preparation(prepare(tiny, answer).summary));
  CHECK_FALSE(analysis_of_preparation(prepare(kCube).summary));
}

TEST_CASE_METHOD(PrintJobFixture, "An analysis that takes too long leaves the resin unknown, and says so") {
  const PreparedJob job = prepare(kCube, R"({"confirm": true})");
  const auto whole = analyze_within(std::chrono::minutes(10), job, printer, {});
  REQUIRE(whole);
  CHECK(whole->resin_ml == testing::Approx(8));
  CHECK(whole->findings == std::vector<std::string>{"to_be_confirmed"});
  const auto cut = analyze_within(Duration(0), job, printer, {});
  REQUIRE(cut);
  CHECK_FALSE(cut->resin_ml);
  CHECK(cut->findings == std::vector<std::string>{"to_be_confirmed"});
  REQUIRE_FALSE(cut->warnings.empty());
  CHECK(lacking(cut->warnings.back(), {"amount of resin is unknown", "within 0"}).empty());
  std::stop_source stop;
  stop.request_stop();
  CHECK_FALSE(analyze_within(std::chrono::minutes(10), job, printer, stop.get_token()));
}

TEST_CASE_METHOD(PrintJobFixture, "Copies lie side by side around the plate's centre, 2 mm apart") {
  const PreparedJob job = prepare(kCube, R"({"copies": 4})");
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  // Two by two copies: 42 mm, 840 pixels.
  CHECK(lit_box(mask) == Lit{540, 1379, 120, 959});
  CHECK(mask.lit_area() == 4 * 160000.0);
}

TEST_CASE_METHOD(PrintJobFixture, "Eight copies fill the plate and nine are refused") {
  CHECK(prepare(kCube, R"({"copies": 8})").plan.engine->mask_at(Nanometers{1'000'000}).lit_area() ==
        8 * 160000.0);
  CHECK(refusal_of(kCube, R"({"copies": 9})") ==
        "9 copies of 20.00 x 20.00 mm do not fit on the plate (96.00 x 54.00 mm); there is room for 8");
}

TEST_CASE_METHOD(PrintJobFixture,
                 "Fit makes the part as large as the display allows, in all three directions alike") {
  const PreparedJob job = prepare(kCube, R"({"fit": true})");
  // Equation 3.8: R = height - 1 pixels, for 20 mm.
  CHECK(job.summary.models[0].scale.x == testing::Approx(1079 * 0.05 / 20).epsilon(1e-6));
  CHECK(job.summary.models[0].size_z_mm == testing::Approx(1079 * 0.05).epsilon(1e-6));
  CHECK(job.summary.models[0].size_x_mm == testing::Approx(job.summary.models[0].size_z_mm).epsilon(1e-6));
}

TEST_CASE_METHOD(PrintJobFixture, "Fit makes a tower no higher than the machine can print") {
  const PreparedJob job = prepare(models::box({0, 0, 0}, {1, 1, 100}), R"({"fit": true})");
  // 160 mm of travel less 3.5 mm of lift, with the rounding of float coordinates.
  CHECK(job.summary.models[0].size_z_mm == testing::Approx(156.5).epsilon(1e-6));
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A rotation stands a flat box up, and it is printed from its new lowest point") {
  const PreparedJob job =
      prepare(models::box({0, 0, 0}, {10, 20, 5}), R"({"rotation_deg": {"x": 90, "y": 0, "z": 0}})");
  CHECK(job.summary.models[0].size_y_mm == 5.0);
  CHECK(job.summary.models[0].size_z_mm == 20.0);
  CHECK(job.summary.layers.count == 400);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A model that cannot be printed is refused with a sentence that has the figures") {
  CHECK(
      refusal_of(models::box({0, 0, 0}, {97, 10, 10})) ==
      "the model (97.00 x 10.00 mm, its centre 0.00, 0.00 mm from the plate's) reaches 0.50 mm over the left "
      "edge and 0.50 mm over the right edge of the build area (96.00 x 54.00 mm)");
  CHECK(refusal_of(models::box({0, 0, 0}, {10, 10, 157})) ==
        "the model is 157.00 mm high, the machine can print 156.50 mm (its travel less the lift)");
  CHECK(refusal_of({}) == "the file holds no facets");
  CHECK(refusal_of(models::box({0, 0, 3}, {10, 10, 3})) == "the model is flat: it has no height to print");
  CHECK(refusal_of(models::box({0, 0, 0}, {1e38F, 1, 1}), R"({"scale": 1000})") ==
        "the model is too large: its coordinates leave the range of numbers");
}

TEST_CASE_METHOD(PrintJobFixture, "A model that its position moves over the plate's edge is refused") {
  CHECK(refusal_of(kCube, R"({"position_mm": {"x": 38.1, "y": 0}})")
            .find("reaches 0.10 mm over the right edge") != std::string::npos);
  CHECK(refusal_of(kCube, R"({"position_mm": {"x": 38, "y": 0}})").empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A wrong ticket refuses the job with all of its mistakes") {
  const std::string refusal = refusal_of(kCube, R"({"copies": 0, "colour": "red"})");
  CHECK(refusal.find("/copies") != std::string::npos);
  CHECK(refusal.find("colour") != std::string::npos);
}

TEST_CASE_METHOD(PrintJobFixture, "An up direction turns a flat box as the equivalent angles do") {
  const PreparedJob job = prepare(models::box({0, 0, 0}, {10, 20, 5}), R"({"up": {"y": 3}})");
  CHECK(job.summary.models[0].size_y_mm == 5.0);
  CHECK(job.summary.models[0].size_z_mm == 20.0);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "Drain holes are removed from the part, and a hole that misses it refuses the job") {
  // One hole goes up from the bottom face, the other into a side.
  const std::string holes = R"({"copies": 2, "drain": [
    {"position_mm": {"x": 10, "y": 10}, "direction": {"z": 1}, "diameter_mm": 4, "depth_mm": 5},
    {"position_mm": {"x": 0, "y": 10, "z": 10}, "direction": {"x": 1}, "diameter_mm": 2}]})";
  const PreparedJob job = prepare(kCube, holes);
  CHECK(job.summary.models[0].drain_holes == 2);
  for (ContourEngine* engine : {job.plan.engine.get(), job.analysis_engine.get()}) {
    // A circle with a radius of 40 pixels; counting pixel centres is accurate to a thousandth.
    CHECK(320000 - engine->mask_at(Nanometers{2'000'000}).lit_area() ==
          testing::Approx(2 * 5026.5).epsilon(2e-3));
    CHECK(engine->mask_at(Nanometers{6'000'000}).lit_area() == 320000);
    // 5 mm deep and 2 mm wide: 100 by 40 pixels.
    CHECK(320000 - engine->mask_at(Nanometers{10'000'000}).lit_area() ==
          testing::Approx(2 * 4000).epsilon(0.01));
  }
  const std::string refusal = refusal_of(kCube, R"({"drain": [
    {"position_mm": {"x": 10, "y": 40}, "direction": {"z": 1}, "diameter_mm": 4}]})");
  CHECK(refusal.find("drain hole 1 of the model misses it: the hole starts at 10, 40, 0 mm") == 0);
}

TEST_CASE_METHOD(PrintJobFixture, "A hollow job has its cavity, its hole and its figures in every copy") {
  const PreparedJob job =
      prepare(models::box({0, 0, 0}, {6, 6, 6}), R"({"copies": 2, "hollow": {"wall_mm": 1, "hole_mm": 1}})");
  REQUIRE(job.summary.models[0].hollow);
  const HollowSummary& hollow = *job.summary.models[0].hollow;
  CHECK(hollow.cavities == 1);
  CHECK(hollow.volume_mm3 == testing::Approx(4 * 4 * 4));
  CHECK(hollow.holes.size() == 1);
  CHECK(job.summary.warnings.empty());
  // Two copies of 6 x 6 mm, in pixels of 50 um; a cavity has 4 x 4 mm.
  constexpr double kWhole = 2 * 120 * 120, kCavities = 2 * 80 * 80;
  for (ContourEngine* engine : {job.plan.engine.get(), job.analysis_engine.get()}) {
    CHECK(engine->mask_at(Nanometers{3'000'000}).lit_area() == kWhole - kCavities);
    CHECK(engine->mask_at(Nanometers{500'000}).lit_area() == kWhole);
    CHECK(engine->mask_at(Nanometers{5'500'000}).lit_area() == kWhole);
    // At its axis, the hole removes its width, 20 pixels, from a wall of 20 in each copy; its edges may lie
    // on pixels' centres.
    CHECK(kWhole - kCavities - engine->mask_at(Nanometers{1'400'000}).lit_area() ==
          testing::Approx(2 * 20 * 20).margin(2 * 20));
  }
}

TEST_CASE_METHOD(PrintJobFixture, "A lift that the force line does not watch is a warning") {
  resin.motion.lift = Nanometers{1'000'000};
  resin.motion.second_lift = Nanometers{1'500'000};
  printer.force = ForcePolicy{.contact_from = Nanometers{2'500'000}};
  CHECK(prepare(kCube).summary.warnings ==
        std::vector<std::string>{
            "the force line does not watch the plate's way down between two layers: the plate is lifted by "
            "2.5 mm, and a force counts as resistance only from 2.5 mm above a layer on "
            "(z_axis/force/contact_from_mm); lift higher, or measure a smaller contact_from_mm"});
  printer.force->contact_from = Nanometers{2'499'999};
  CHECK(prepare(kCube).summary.warnings.empty());
  printer.force.reset();
  CHECK(prepare(kCube).summary.warnings.empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A model without room for a cavity is printed solid, with a warning") {
  const PreparedJob job = prepare(models::box({0, 0, 0}, {10, 10, 3}), R"({"hollow": {"wall_mm": 1.5}})");
  CHECK(job.summary.models[0].hollow->cavities == 0);
  CHECK(job.summary.warnings ==
        std::vector<std::string>{
            "not made hollow: with walls of 1.5 mm, there is no room for a cavity of 50 mm3"});
  const PreparedJob closed = prepare(models::box({0, 0, 0}, {8, 8, 8}), R"({"hollow": {"hole_mm": 0}})");
  CHECK(closed.summary.warnings ==
        std::vector<std::string>{
            "no hole opens 1 cavity: the ticket's hole_mm is 0, and none of its drain holes does"});
}

TEST_CASE_METHOD(PrintJobFixture, "Walls that would tear are refused with what they carry") {
  // Walls of 0.2 mm around 6 x 6 mm have 4.6 of the roof's 36 mm2.
  const models::Facets block = models::box({0, 0, 0}, {6, 6, 6});
  CHECK_NOTHROW(prepare(block, R"({"hollow": {"wall_mm": 0.2}})"));
  resin.supports.tip_holds_mm2 = 0.5;
  CHECK(refusal_of(block, R"({"hollow": {"wall_mm": 0.2}})") ==
        "the walls of the model would tear when the layers above them are peeled off: where they are "
        "weakest, they have 13 % of the area of the largest layer above, and 25 % carry it; give "
        "\"hollow\" a greater wall_mm than 0.2, or an infill");
}

TEST_CASE_METHOD(PrintJobFixture,
                 "Scale factors by axis and the resin's shrinkage apply to the printed cube") {
  resin.shrinkage_factors = {1.25, 1, 1};
  const PreparedJob job = prepare(kCube, R"({"scale": {"y": 0.5, "z": 0.25}})");
  // 25 mm by 10 mm around the middle.
  const Mask& mask = job.plan.engine->mask_at(Nanometers{1'000'000});
  CHECK(lit_box(mask) == Lit{710, 1209, 440, 639});
  CHECK(mask.lit_area() == 500.0 * 200.0);
  CHECK(job.summary.layers.count == 100);
  CHECK(job.summary.models[0].scale == Scale{1, 0.5, 0.25});
}

TEST_CASE_METHOD(PrintJobFixture, "Fit fills the display with the part as enlarged to compensate shrinkage") {
  resin.shrinkage_factors = {1, 1.25, 1};
  const PreparedJob job = prepare(kCube, R"({"fit": true})");
  CHECK(job.summary.models[0].size_y_mm == testing::Approx(1079 * 0.05).epsilon(1e-6));
  CHECK(job.summary.models[0].size_x_mm == testing::Approx(1079 * 0.05 / 1.25).epsilon(1e-6));
}

TEST_CASE_METHOD(PrintJobFixture, "A model that needs no supports is printed the same with supports on") {
  PreparedJob without = prepare(kCube), with = prepare(kCube, R"({"supports": "auto"})");
  CHECK_FALSE(without.summary.supports);
  REQUIRE(with.summary.supports);
  CHECK_FALSE(counts_of(*with.summary.supports).any());
  CHECK(with.summary.height_mm == without.summary.height_mm);
  REQUIRE(with.plan.expected_layers == without.plan.expected_layers);
  for (const Nanometers height : middles_of(without.plan.expected_layers))
    REQUIRE(with.plan.engine->mask_at(height) == without.plan.engine->mask_at(height));
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A supported ball is lifted by whole layers, and both engines expose its supports",
                 "[long]") {
  const models::Facets ball = models::sphere(5, 32);
  PreparedJob job = prepare(ball, R"({"supports": "auto", "layer_height_um": 70})");
  REQUIRE(job.summary.supports);
  const SupportCounts counts = counts_of(*job.summary.supports);
  CHECK(counts.islands >= 1);
  CHECK(counts.unheld == 0);
  CHECK(counts.feet >= 1);
  const Nanometers lift = job.plan.engine->models().front().elevation.above_plate();
  CHECK(lift >= Nanometers{5'000'000});
  CHECK(lift.count() % 70'000 == 0);
  CHECK(job.summary.height_mm == testing::Approx(to_millimeters(lift).count() +
                                                 10));  // the tolerance covers the mesh's coarseness, 5 um
  // Beneath the ball there are only supports.
  const Nanometers beneath = lift / 2;
  CHECK(job.plan.engine->mask_at(beneath).lit_area() > 0);
  CHECK(job.plan.engine->mask_at(beneath) == job.analysis_engine->mask_at(beneath));
  CHECK(job.plan.engine->intersecting_facets() == 0);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A tilted base rests on the plate up to the height of the print's bottom layers", "[long]") {
  models::Facets tilted = models::box({0, 0, 0}, {30, 20, 5});
  for (Facet& facet : tilted) {
    for (Vertex& vertex : facet.vertices)
      vertex.z += 0.007F * vertex.x;  // 0.21 mm
  }
  const auto contacts = [&](const std::string& ticket) {
    return counts_of(*prepare(tilted, ticket).summary.supports).contacts();
  };
  CHECK(contacts(R"({"supports": "auto"})") == 0);
  CHECK(contacts(R"({"supports": "auto", "layer_height_um": 25})") > 0);
  resin.bottom_layers = 1;
  CHECK(contacts(R"({"supports": "auto"})") > 0);
}

TEST_CASE_METHOD(PrintJobFixture,
                 "A model that is drawn nearly level gets a warning, with supports or without", "[long]") {
  const auto warnings = [this](double tilt_deg, const std::string& ticket) {
    models::Facets box = models::box({0, 0, 0}, {20, 15, 8});
    orient(box, {.y_deg = tilt_deg});
    return prepare(box, ticket).summary.warnings;
  };
  const std::string tilted =
      "the model is tilted: it would stand on the plate without supports under its base if it were turned by "
      "2 "
      "degrees; \"up\": \"auto\" in its ticket turns it, and \"contourctl orient\" shows how";
  for (const std::string supports : {"auto", "off"}) {
    const std::string ticket = R"({"supports": ")" + supports + "\"}";
    CHECK(warnings(2, ticket) == std::vector{tilted});
    CHECK(warnings(0, ticket).empty());
    CHECK(warnings(6, ticket).empty());
    CHECK(warnings(2, R"({"up": "auto", "supports": ")" + supports + "\"}").empty());
  }
}

TEST_CASE_METHOD(PrintJobFixture, "Parts so low that the bottom exposures join them to the plate are named") {
  const auto low = models::together(kCube, models::box({25, 0, 0.12F}, {28, 3, 4}));
  const std::vector<std::string> warnings = prepare(low, R"({"supports": "auto"})").summary.warnings;
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].starts_with(
      "1 part begins above the plate with nothing beneath it, so low that the bottom"));
}

TEST_CASE_METHOD(PrintJobFixture, "Supports hold the islands of the job's own layers and compensation") {
  const auto islands = [this](const models::Facets& facets, const char* ticket) {
    return counts_of(*prepare(facets, ticket).summary.supports).islands;
  };
  const auto plate = models::together(kCube, models::box({22, 5, 3.03F}, {24, 7, 3.07F}));
  CHECK(islands(plate, R"({"supports": "auto"})") == 0);
  CHECK(islands(plate, R"({"supports": "auto", "layer_height_um": 25})") > 0);
  const auto necked = models::together({kCube, models::box({9.92F, 9.92F, 20}, {10.08F, 10.08F, 21}),
                                        models::box({9.5F, 9.5F, 21}, {10.5F, 10.5F, 23})});
  CHECK(islands(necked, R"({"supports": "auto"})") == 0);
  resin.compensation.growth = Micrometers{-100.0};
  CHECK(islands(necked, R"({"supports": "auto"})") == 1);
}

TEST_CASE_METHOD(PlateFixture,
                 "A model that carries supports gets no others, but its neighbour on the plate does") {
  models::Facets carrier = models::box({-6, -6, 5}, {6, 6, 8});
  for (int i = 0; i < 9; ++i) {
    const std::array<Point, 5> profile{{{0, 0}, {0.5, 0}, {0.5, 4}, {0.2, 5.2}, {0, 5.2}}};
    models::Facets pillar = models::lathe(profile, 24);
    models::translate(pillar, static_cast<float>(5 * (i % 3 - 1)), static_cast<float>(5 * (i / 3 - 1)), 0);
    carrier = models::together(std::move(carrier), pillar);
  }
  add("carrier.stl", carrier);
  add("ball.stl", models::globe(4, 24, 48));
  const auto summary_of = [this](const std::string& models) {
    return prepare(R"({"supports": "auto", "models": [)" + models + "]}").summary;
  };
  const JobSummary alone = summary_of(R"({"file": "carrier.stl"})");
  CHECK_FALSE(counts_of(*alone.supports).any());
  CHECK(alone.height_mm == testing::Approx(8));
  REQUIRE(alone.warnings.size() == 1);
  CHECK(alone.warnings.front() == "carrier.stl carries supports in its file, so contourd adds none");
  const auto contacts = counts_of(*summary_of(R"({"file": "ball.stl"})").supports).contacts();
  const JobSummary both = summary_of(R"({"file": "ball.stl"}, {"file": "carrier.stl"})");
  CHECK(contacts > 0);
  CHECK(counts_of(*both.supports).contacts() == contacts);
  for (const char* asked : {R"("on")", R"({"lift_mm": 6})"}) {
    const JobSummary overruled =
        prepare(std::string(R"({"supports": )") + asked + R"(, "models": [{"file": "carrier.stl"}]})")
            .summary;
    CHECK(counts_of(*overruled.supports).any());
    REQUIRE(overruled.warnings.size() == 1);
    CHECK(
        overruled.warnings.front() ==
        "carrier.stl carries supports in its file, but contourd supports it like any other model, as asked");
  }
}

TEST_CASE_METHOD(PlateFixture, "Models that carry supports by their ticket are printed as they are drawn") {
  add("ball.stl", models::sphere(5, 32));
  // A slab that stands on its edge: an orientation that contourd chose would lay it down.
  add("slab.stl", models::box({0, 0, 0}, {2, 20, 20}));
  const JobSummary job = prepare(R"({"supports": "in the file", "models": [
    {"file": "ball.stl", "copies": 2}, {"file": "slab.stl", "up": "auto"}]})")
                             .summary;
  CHECK(job.height_mm == testing::Approx(20));
  CHECK_FALSE(counts_of(*job.supports).any());
  CHECK(counts_of(*job.supports).carriers == 2);
  CHECK(job.warnings.at(0) == "slab.stl is not turned: the supports in its file hold it as it is drawn");
  CHECK(job.warnings.at(1) == "ball.stl carries supports in its file, so contourd adds none");
  const JobSummary turned =
      prepare(R"({"supports": "in the file", "models": [{"file": "slab.stl", "up": {"x": 1}}]})").summary;
  CHECK(turned.height_mm == testing::Approx(2));
}

TEST_CASE_METHOD(PrintJobFixture, "The printer's file turns supports on, and a ticket can turn them off") {
  printer.supports = SupportPolicy::Auto;
  CHECK(prepare(models::sphere(5, 32)).summary.supports);
  CHECK_FALSE(prepare(models::sphere(5, 32), R"({"supports": "off"})").summary.supports);
}

TEST_CASE_METHOD(PrintJobFixture, "A model that is too high once lifted is refused with the figures") {
  // 156.5 mm can be printed: 160 mm less the lift of 3.5 mm.
  CHECK(refusal_of(models::sphere(20, 32), R"({"supports": "auto", "scale": {"z": 3.8}})") ==
        "the model is 152.00 mm high and stands 5.00 mm above the plate, on supports: 157.00 mm, and the "
        "machine can print 156.50 mm (its travel less the lift)");
  CHECK(refusal_of(models::sphere(20, 32), R"({"supports": "off", "scale": {"z": 3.8}})").empty());
}

TEST_CASE_METHOD(PrintJobFixture, "A model with fit leaves room for supports beneath it") {
  const PreparedJob job =
      prepare(models::box({0, 0, 0}, {2, 2, 100}), R"({"supports": "auto", "fit": true})");
  CHECK(job.summary.height_mm == testing::Approx(156.5 - 5 - 0.1));  // the thickest layer is 0.1 mm
  const PreparedJob carried =
      prepare(models::box({0, 0, 0}, {2, 2, 100}), R"({"supports": "in the file", "fit": true})");
  CHECK(carried.summary.height_mm == testing::Approx(156.5));
}

TEST_CASE_METHOD(PrintJobFixture, "Copies with supports are spaced so that a foot fits between them") {
  const auto distance = [&](const models::Facets& facets) {
    const auto centers =
        prepare(facets, R"({"supports": "auto", "copies": 2})").summary.models.front().centers;
    return std::abs(centers[1].x - centers[0].x) + std::abs(centers[1].y - centers[0].y);
  };
  CHECK(distance(kCube) == testing::Approx(20 + 2));
  CHECK(distance(models::sphere(5, 32)) ==
        testing::Approx(10 + 4 + 2 * 0.5).margin(0.01));  // mm: a mesh of 32 corners
}

TEST_CASE_METHOD(PrintJobFixture, "A stopped search for supports prepares no job") {
  std::stop_source stop;
  stop.request_stop();
  const std::string supported = R"({"supports": "auto"})";
  CHECK_FALSE(prepare_until(models::sphere(5, 32), supported, stop.get_token()));
  CHECK(prepare_until(models::sphere(5, 32), supported, {}));
}

TEST_CASE_METHOD(PlateFixture, "A plate's models are printed together, each with the settings of its entry") {
  add("cube.stl", kCube);
  add("bar.stl", models::box({100, 100, 100}, {110, 104, 102}));
  const PreparedJob job = prepare(R"({"layer_height_um": 100, "models": [
    {"file": "cube.stl", "position_mm": {"x": -20}, "scale": 0.5},
    {"file": "bar.stl", "position_mm": {"x": 10, "y": 5}, "copies": 2, "up": {"x": 1}}]})");
  CHECK(job.summary.plate);
  CHECK(job.summary.layers.count == 100);
  CHECK(job.summary.height_mm == 10);
  REQUIRE(job.summary.models.size() == 2);
  CHECK(job.summary.models[1].file == "bar.stl");
  CHECK(job.summary.models[1].size_z_mm == 10);
  CHECK(job.summary.models[1].centers.size() == 2);
  // The cube, 200 by 200 pixels, and two bars of 2 by 4 mm standing on end.
  const Mask& mask = job.plan.engine->mask_at(Nanometers{5'000'000});
  CHECK(mask.lit_area() == 200.0 * 200 + 2 * 40.0 * 80);
  CHECK(mask.lit_pixels() == 200 * 200 + 2 * 40 * 80);
  CHECK(job.plan.engine->contours_at(Nanometers{5'000'000}).loops.size() == 2);
}

TEST_CASE_METHOD(PlateFixture, "A plate is refused with a sentence that names the faulty model") {
  add("cube.stl", kCube);
  add("flat.stl", models::box({0, 0, 3}, {10, 10, 3}));
  add("none.stl", {});
  CHECK(refusal_of(R"({"models": [{"file": "cube.stl"}, {"file": "flat.stl"}]})") ==
        "flat.stl is flat: it has no height to print");
  CHECK(refusal_of(R"({"models": [{"file": "none.stl"}]})") == "none.stl: the file holds no facets");
  CHECK(refusal_of(R"({"models": [{"file": "cube.stl", "position_mm": {"y": -20}}]})") ==
        "cube.stl (20.00 x 20.00 mm, its centre 0.00, -20.00 mm from the plate's) reaches 3.00 mm over the "
        "front edge of the build area (96.00 x 54.00 mm)");
  CHECK(refusal_of(R"({"models": [{"file": "gone.stl"}]})").find("gone.stl") != std::string::npos);
  CHECK(refusal_of(R"({"models": [{"file": "cube.stl", "colour": 1}]})").find("/models/0/colour") !=
        std::string::npos);
}

TEST_CASE_METHOD(PrintJobFixture, "A part that grows beyond the display is printed with a warning") {
  const models::Facets wide = models::box({0, 0, 0}, {96, 20, 1});
  CHECK(prepare(wide).summary.warnings.empty());
  resin.compensation.growth = Micrometers{80};
  CHECK(prepare(wide).summary.warnings ==
        std::vector<std::string>{
            "the resin's growth_um moves contours 80 um beyond the display, where they are cut off"});
  CHECK(prepare(kCube).summary.warnings.empty());
  resin.compensation.growth = Micrometers{-80};
  CHECK(prepare(wide).summary.warnings.empty());
}

TEST_CASE_METHOD(
    PrintJobFixture,
    "A job whose masks exceed their time budget is refused, and an accepted job has the budget in its plan") {
  CHECK(prepare(kCube).plan.mask_budget == std::chrono::seconds{1});
  printer.mask_budget = Duration{0};
  CHECK(refusal_of(kCube).find("the mask of layer 1 of 400 takes longer than mask_budget_ms, 0 ms") !=
        std::string::npos);
}

namespace {

// Writes a binary STL file of 84 + 50 x `facets` bytes that is sparse after its header, so that it takes no
// disk space.
void write_sparse_stl(const std::filesystem::path& path, std::uint32_t facets) {
  std::string header(84, '\0');
  std::memcpy(header.data() + 80, &facets, sizeof facets);
  std::ofstream(path, std::ios::binary) << header;
  std::filesystem::resize_file(path, 84 + std::uintmax_t{50} * facets);
}

// Returns the refusal of a sparse file; empty if it is not refused as too large.
std::string refusal_of_sparse(const PrinterConfig& printer, std::uint32_t facets) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "huge.stl";
  write_sparse_stl(path, facets);
  return testing::message_of<JobTooLarge>([&] {
    (void)prepare_job({"huge", path, std::nullopt}, {JobTicket{}, find_resin(printer, printer.resin)},
                      printer);
  });
}

}  // namespace

TEST_CASE_METHOD(
    PrintJobFixture,
    "A model that needs more memory than is available is refused with both figures before it is read") {
  const std::uint64_t held_mb = memory_room(std::uint64_t{1} << 50).held / 1'000'000;
  const std::uint64_t limit_mb = held_mb + 800;
  printer.memory_limit_bytes = limit_mb * 1'000'000;
  const std::string refusal = refusal_of_sparse(printer, 85'899'344);
  CHECK(refusal.starts_with("the model holds 85899344 facets, for which "));
  // 800 MB less what this program has allocated since.
  const std::string before_room = " MB of memory are needed, and there is room for ";
  const std::size_t at = refusal.find(before_room);
  REQUIRE(at != std::string::npos);
  const int room_mb = std::stoi(refusal.substr(at + before_room.size()));
  CHECK(room_mb > 600);
  CHECK(room_mb <= 800);
  CHECK(refusal.find(" MB: memory_limit_mb is " + std::to_string(limit_mb) + ", and contourd holds ") !=
        std::string::npos);
  // More than any computer has, so that the refusal does not depend on the free memory of this one.
  printer.memory_limit_bytes.reset();
  const std::string more_than_any = refusal_of_sparse(printer, 0xFFFFFFFF);
  CHECK(more_than_any.starts_with("the model holds 4294967295 facets, for which "));
  CHECK(more_than_any.find(" MB stay free") != std::string::npos);
}

TEST_CASE_METHOD(PlateFixture,
                 "Entries of a plate with the same file, turned and scaled alike, share one model") {
  add("cube.stl", kCube);
  add("same.stl", kCube);
  const PreparedJob job = prepare(R"({"models": [
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
  // Six copies of 8 by 8 mm and one of 10 by 10 mm.
  CHECK(job.plan.engine->mask_at(Nanometers{5'000'000}).lit_area() == (6 * 160.0 * 160 + 200.0 * 200));
}
