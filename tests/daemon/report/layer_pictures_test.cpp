#include "daemon/report/layer_pictures.hpp"

#include <fstream>

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/report/report_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace {

// Returns the report on layers of 0.1 mm from the plate up, all of the same area.
PrintReport printed(std::int32_t layers) {
  PrintReport report;
  for (std::int32_t i = 0; i < layers; ++i) {
    LayerRecord& layer = report.layers.emplace_back();
    layer.layer = i;
    layer.thickness = Nanometers{100'000};
    layer.mask_height = Nanometers{100'000 * i + 50'000};
    layer.area_mm2 = 6;
    layer.complete = true;
  }
  return report;
}

std::set<std::size_t> records(const std::vector<ChosenLayer>& chosen) {
  std::set<std::size_t> set;
  for (const ChosenLayer& each : chosen)
    set.insert(each.record);
  return set;
}

std::string why(const std::vector<ChosenLayer>& chosen, std::size_t record) {
  const auto found = std::ranges::find(chosen, record, &ChosenLayer::record);
  return found == chosen.end() ? "not chosen" : found->why;
}

}  // namespace

TEST_CASE(
    "For a print without warnings, the first, the largest, the last and evenly spread layers are chosen") {
  PrintReport report = printed(800);
  report.layers[300].area_mm2 = 7;
  const auto chosen = choose_layers(report);
  CHECK(chosen.size() == kMaxLayerPictures);
  CHECK(records(chosen).size() == chosen.size());
  CHECK(why(chosen, 0) == "first");
  CHECK(why(chosen, 300) == "largest");
  CHECK(why(chosen, 799) == "last");
  const std::set<std::size_t> all = records(chosen);
  for (auto at = all.begin(); std::next(at) != all.end(); ++at)
    CHECK(*std::next(at) - *at <= 130);
}

TEST_CASE("All layers of a short print are chosen, and none of a print without layers") {
  CHECK(choose_layers(printed(0)).empty());
  REQUIRE(choose_layers(printed(1)).size() == 1);
  CHECK(choose_layers(printed(1)).front() == ChosenLayer{0, "first, largest, last"});
  CHECK(records(choose_layers(printed(5))) == std::set<std::size_t>{0, 1, 2, 3, 4});
}

TEST_CASE("Each warning gets one layer before any warning gets a second, and each layer has its reason") {
  PrintReport report = printed(1000);
  PrintFindings& findings = report.findings.emplace();
  findings.area_mm2.assign(1000, 6);
  for (std::int32_t i = 0; i < 3; ++i)
    findings.islands.push_back({100 + i, {1, 2}, {0, 0}, 9.0 - i});
  findings.island_count = 3;
  findings.empty_layers = {200, 300, 400, 999};
  findings.abandoned_layers = {210, 310, 410};
  findings.cracked_layers = {{220, {0, Millimeters{0.1}, 1}}, {320, {0, Millimeters{0.1}, 1}}};
  findings.cracks = {0, Millimeters{0.1}, 2};
  report.stops.interruptions = {{230, 1s, "the lid was opened"}, {231, 1s, "the lid was opened"}};
  const auto chosen = choose_layers(report);
  CHECK(chosen.size() == kMaxLayerPictures);
  CHECK(why(chosen, 100) == "island");
  CHECK(why(chosen, 200) == "empty");
  CHECK(why(chosen, 999) == "last, empty");
  CHECK(why(chosen, 210) == "no mask");
  CHECK(why(chosen, 220) == "crack");
  CHECK(why(chosen, 230) == "interrupted");
}

TEST_CASE("Layers that were not exposed are not chosen, even if a warning names them") {
  PrintReport report = printed(20);
  report.findings.emplace().area_mm2.assign(1000, 6);
  report.findings->islands = {{500, {1, 2}, {0, 0}, 3}};
  report.findings->island_count = 1;
  for (const ChosenLayer& each : choose_layers(report))
    CHECK(each.record < 20);
}

TEST_CASE("The box surrounds all copies with a margin and lies within the display") {
  const ContourEngine engine = testing::engine_of_a_box();
  // The box covers 30 x 20 pixels from (17, 14); the margin is 4 pixels and a twentieth of 30.
  CHECK(box_around(engine.models(), Pixels{64}, Pixels{48}) == PixelBox{11, 8, 53, 40});
  CHECK(box_around({}, Pixels{64}, Pixels{48}) == PixelBox{0, 0, 64, 48});
  CHECK(box_around(engine.models(), Pixels{30}, Pixels{20}) == PixelBox{11, 8, 30, 20});
}

TEST_CASE("A picture is the shown mask within the box, with marks for the layer's islands and hollows") {
  PrintReport report = printed(3);
  report.findings.emplace().area_mm2.assign(3, 6);
  report.findings->islands = {{1, {20, 30}, {0, 0}, 3}};
  report.findings->island_count = 1;
  report.findings->suction_cups = {{0, 2, 2, {20, 30}, {0, 0}, 3, 5, false}};
  report.findings->resin_traps = {{0, 2, 0, {21, 31}, {0, 0}, 3, 5, false}};
  ContourEngine engine = testing::engine_of_a_box();
  const auto pictures = draw_layer_pictures(report, {engine}, MaskBudget::Clock::now() + 1h);
  REQUIRE(pictures.size() == 3);
  const testing::TemporaryFolder folder;
  for (std::size_t i = 0; i < 3; ++i) {
    const LayerPicture& picture = pictures[i];
    CHECK(picture.layer == static_cast<std::int32_t>(i));
    const auto path = folder.path() / "picture.png";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(picture.png.data()),
               static_cast<std::streamsize>(picture.png.size()));
    const Mask small = read_png(path);
    CHECK(small ==
          make_thumbnail(engine.mask_at(report.layers[i].mask_height), {11, 8, 53, 40}, kLayerPictureSide));
    CHECK(small.lit_pixels() == 600);
    CHECK(picture.width == small.width());
  }
  REQUIRE(pictures[1].islands.size() == 1);
  CHECK(pictures[1].islands[0].middle.x == 9);
  CHECK(pictures[1].islands[0].middle.y == 22);
  CHECK(pictures[1].islands[0].radius > 10);  // of 300 pixels
  CHECK(pictures[0].islands.empty());
  CHECK(pictures[0].voids.size() == 1);
  CHECK(pictures[1].voids.empty());
  REQUIRE(pictures[2].voids.size() == 1);
  CHECK(pictures[2].voids[0].middle.x == 9);
  CHECK(pictures[2].voids[0].middle.y == 22);
}

TEST_CASE("Pictures that are not drawn by the deadline are omitted") {
  ContourEngine engine = testing::engine_of_a_box();
  CHECK(draw_layer_pictures(printed(3), {engine}, MaskBudget::Clock::now() - 1s).empty());
}
