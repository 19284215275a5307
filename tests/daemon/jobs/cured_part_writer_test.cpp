#include "daemon/jobs/cured_part_writer.hpp"

#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/report/print_report_html.hpp"
#include "daemon/report/print_report_json.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

constexpr Nanometers kCuredLayer{50'000};

// A spool with the report of a printed box of 3 x 2 x 0.5 mm in done/.
class CuredPartFixture {
 public:
  // Copies stand in one place.
  [[nodiscard]] std::shared_ptr<PrintToCure> printed(int first_layer = 0, std::size_t copies = 1) const {
    return printed(first_layer, std::vector(copies, Point{}), {});
  }
  [[nodiscard]] std::shared_ptr<PrintToCure> printed(int first_layer, const std::vector<Point>& centers,
                                                     std::vector<Exclusion> exclusions) const {
    auto print = std::make_shared<PrintToCure>();
    PrintReport& report = print->report;
    report.job = "part";
    report.outcome = PrintOutcome::Done;
    report.summary.layers.thinnest = report.summary.layers.thickest = kCuredLayer;
    report.summary.irradiance_mw_cm2 = 5;
    report.summary.models.resize(1);
    report.summary.models.front().centers = {{0, 0}};
    report.exclusions = std::move(exclusions);
    if (!report.exclusions.empty()) report.summary.models.front().centers = centers;
    report.summary.resin.cure = CureSettings{{Micrometers{150}, MillijoulesPerCm2{8}}};
    for (int layer = first_layer; layer < 10; ++layer) {
      LayerRecord record;
      record.layer = layer;
      record.thickness = kCuredLayer;
      record.plate_height = kCuredLayer * (layer + 1);
      record.mask_height = record.plate_height - kCuredLayer / 2;
      record.exposure_least = record.exposure_most = std::chrono::milliseconds(3116);
      report.layers.push_back(record);
    }
    const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {3, 2, 0.5F})), {}};
    PlateModel model{box, {}};
    for (const Point& center : centers)
      model.copies.push_back(PixelMap::true_scale(testing::kSmallDisplay, {1.5 - center.x, 1 - center.y}));
    print->engine = std::make_unique<ContourEngine>(std::vector{std::move(model)},
                                                    EngineSettings{.display = testing::kSmallDisplay});
    report.cured = part_to_come(report);
    spool.write_beside(Spool::Folder::Done, "part", "report.json", report_as_json(report));
    spool.write_beside(Spool::Folder::Done, "part", "report.html", report_as_html(report));
    return print;
  }

  [[nodiscard]] std::string text(const std::string& name) const {
    std::ifstream file(spool.folder(Spool::Folder::Done) / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] nlohmann::json cured() const {
    return nlohmann::json::parse(text("part.report.json")).at("cured_part");
  }

  // Computes the part, and waits until the print was destroyed.
  void compute(std::shared_ptr<PrintToCure> print, std::optional<std::uint64_t> memory_limit = {}) {
    const std::weak_ptr<PrintToCure> alive = print;
    CuredPartWriter writer(loop, spool, memory_limit);
    writer.begin(std::move(print));
    while (!alive.expired())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  testing::TemporaryFolder folder;
  EventLoop loop;
  testing::NoSpoolObserver observer;
  Spool spool{folder.path() / "spool", loop, observer};
};

}  // namespace

TEST_CASE_METHOD(CuredPartFixture, "The part that a print cured is written into its report and page") {
  compute(printed());
  CHECK(cured().at("tops").at("median_um").get<double>() == Approx(0).margin(0.1));
  CHECK(cured().at("model_mm3").get<double>() == Approx(3));
  CHECK(cured().at("weakest_bond").get<double>() ==
        Approx(5 * 3.116 / 8 * std::exp(-50.0 / 150)).epsilon(1e-3));
  CHECK(text("part.report.html").find("The part that was cured") != std::string::npos);
  CHECK(text("part.report.html").find("Not computed") == std::string::npos);
}

TEST_CASE_METHOD(CuredPartFixture, "An excluded copy is compared as far up as it was printed") {
  auto print = printed(0, {{-1.6, 0}, {1.6, 0}}, {{1, "part (copy 2)", 6}});
  print->engine->darken(0, 1, kCuredLayer * 6);
  compute(std::move(print));
  CHECK(cured().at("model_mm3").get<double>() == Approx(3 + 6 * 0.3));
  CHECK(cured().at("missing_mm3").get<double>() == Approx(0).margin(1e-4));
  CHECK(cured().at("too_much_mm3").get<double>() == Approx(0).margin(1e-4));
  CHECK(cured().at("tops").at("missing") == 0);
  REQUIRE(cured().at("compared_up_to").size() == 1);
  CHECK(cured().at("compared_up_to").at(0).at("number") == 2);
  CHECK(cured().at("compared_up_to").at(0).at("up_to_mm").get<double>() == Approx(0.3));
  CHECK(text("part.report.html").find("copy 2 up to 0.300 mm: compared as far as they were printed") !=
        std::string::npos);
}

TEST_CASE_METHOD(CuredPartFixture, "A report says why the cured part was not computed") {
  const auto why = [this] { return cured().at("not_computed").get<std::string>(); };
  SECTION("before it is") {
    (void)printed();
    CHECK(why().starts_with(
        "contourd computes it after the report, and has not finished; contourctl cure --report"));
  }
  SECTION("too little memory") {
    compute(printed(), 1'000'000);
    CHECK(why().starts_with("this needs more memory than there is"));
    CHECK(text("part.report.html").find("Not computed: this needs more memory") != std::string::npos);
  }
  SECTION("too little memory for the crossings of its surface") {
    compute(printed(0, 1'700), 1'000'000'000);
    CHECK(why().starts_with("this needs more memory than there is"));
  }
  SECTION("a surface that takes long to sort") {
    compute(printed(0, 100'000));
    CHECK(why().starts_with("its surface is too large: "));
  }
  SECTION("a record that begins in the middle") {
    compute(printed(3));
    CHECK(why() == "its layers do not lie one upon another from the first one on");
  }
}

TEST_CASE_METHOD(CuredPartFixture, "A report that was changed, replaced or removed stays as it is") {
  const fs::path report = spool.folder(Spool::Folder::Done) / "part.report.json";
  auto changed = printed();
  spool.write_beside(Spool::Folder::Done, "part", "report.json", "another print's");
  compute(std::move(changed));
  CHECK(text("part.report.json") == "another print's");
  auto replaced = printed();
  fs::remove(report);
  REQUIRE(::mkfifo(report.c_str(), 0600) == 0);
  compute(std::move(replaced));
  CHECK(fs::is_fifo(report));
  fs::remove(report);
  auto removed = printed();
  fs::remove(report);
  compute(std::move(removed));
  CHECK_FALSE(fs::exists(report));
}

TEST_CASE_METHOD(CuredPartFixture, "No part is computed without a working curve or light") {
  PrintReport report;
  CHECK_FALSE(part_to_come(report));
  report.summary.resin.cure = CureSettings{{Micrometers{150}, MillijoulesPerCm2{8}}};
  CHECK_FALSE(part_to_come(report));
  report.layers.resize(1);
  CHECK(part_to_come(report));
}
