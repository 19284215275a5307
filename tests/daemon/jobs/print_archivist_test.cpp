#include "daemon/jobs/print_archivist.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "hw/png_file.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

constexpr DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};

class NoObserver final : public SpoolObserver {
  void model_arrived(const std::string&) override {}
  void model_withdrawn(const std::string&) override {}
  void plate_waits(const std::string&, const std::vector<std::string>&) override {}
  void ignored(const std::string&, WhyIgnored) override {}
  void more_ignored(std::size_t) override {}
  void incoming_lost(const std::string&) override {}
  void incoming_replaced() override {}
};

// A spool with the job "part" in printing/, whose print has ended.
class Bench {
 public:
  Bench() { std::ofstream(spool.folder(Spool::Folder::Printing) / "part.stl") << "a model"; }

  [[nodiscard]] EndedPrint ended(PrintOutcome outcome, const std::string& reason = "",
                                 Elevation elevation = {}) const {
    EndedPrint print;
    print.files = spool.files_of(Spool::Folder::Printing, "part.stl");
    print.report.job = "part";
    print.report.outcome = outcome;
    print.report.reason = reason;
    print.report.summary.layers.thinnest = print.report.summary.layers.thickest = Nanometers{50'000};
    print.report.summary.irradiance_mw_cm2 = 5;
    print.report.summary.models.resize(1);
    print.report.summary.models.front().centers = {{0, 0}};
    const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {3, 2, 1})),
                            elevation};
    print.engine = std::make_unique<ContourEngine>(
        std::vector{PlateModel{box, {PixelMap::true_scale(kDisplay, {1.5, 1})}}},
        EngineSettings{.display = kDisplay});
    return print;
  }

  FiledPrint file(EndedPrint print) {
    FiledPrint result;
    PrintArchivist archivist(loop, spool);
    archivist.file(std::move(print), [&](const FiledPrint& filed) {
      result = filed;
      loop.stop();
    });
    CHECK(archivist.busy());
    loop.run();
    CHECK_FALSE(archivist.busy());
    return result;
  }

  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(folder.path() / "spool" / name); }

  testing::TemporaryFolder folder;
  EventLoop loop;
  NoObserver observer;
  Spool spool{folder.path() / "spool", loop, observer};
};

}  // namespace

TEST_CASE("A print that is done lies in done/ with its report, page and picture") {
  Bench bench;
  const FiledPrint filed = bench.file(bench.ended(PrintOutcome::Done));
  CHECK(filed.troubles.empty());
  for (const char* name : {"part.stl", "part.report.json", "part.report.html", "part.preview.png"})
    CHECK(bench.has(std::string("done/") + name));
  CHECK_FALSE(bench.has("printing/part.stl"));
}

TEST_CASE("The picture shows what was printed of a model at the height where it stands") {
  // Layers up to 1 mm above the plate, which are all of a model that stands on it.
  const auto lit_in_picture = [](Elevation elevation) {
    Bench bench;
    EndedPrint print = bench.ended(PrintOutcome::Done, "", elevation);
    for (int i = 0; i < 10; ++i) {
      LayerRecord& layer = print.report.layers.emplace_back();
      layer.layer = i;
      layer.bottom = Nanometers{100'000 * i};
      layer.thickness = Nanometers{100'000};
      layer.mask_height = Nanometers{100'000 * i + 50'000};
      layer.complete = true;
    }
    CHECK(bench.file(std::move(print)).troubles.empty());
    return read_png(bench.folder.path() / "spool/done/part.preview.png").lit_pixels();
  };
  CHECK(lit_in_picture({}) > 0);
  CHECK(lit_in_picture(Elevation(Nanometers{500'000})) > 0);
  CHECK(lit_in_picture(Elevation(Nanometers{1'100'000})) == 0);
}

TEST_CASE("A report that cannot be written is told, and the job is filed all the same") {
  Bench bench;
  // A folder cannot be replaced by a file.
  fs::create_directory(bench.spool.folder(Spool::Folder::Failed) / "part.report.json");
  const FiledPrint filed = bench.file(bench.ended(PrintOutcome::Failed, "the sky fell"));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front().starts_with("no report: cannot write "));
  CHECK(bench.has("failed/part.stl"));
  CHECK(bench.has("failed/part.reason.txt"));
}

TEST_CASE("A page that cannot be written is told, and everything else is there") {
  Bench bench;
  fs::create_directory(bench.spool.folder(Spool::Folder::Done) / "part.report.html");
  const FiledPrint filed = bench.file(bench.ended(PrintOutcome::Done));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front().starts_with("no report.html: "));
  CHECK(bench.has("done/part.report.json"));
  CHECK(bench.has("done/part.preview.png"));
  CHECK(bench.has("done/part.stl"));
}

TEST_CASE("A job that cannot be moved is told, and how its print ended can be read afterwards") {
  for (const auto& [outcome, reason] : {std::pair{PrintOutcome::Done, ""},
                                        {PrintOutcome::Failed, "the sky fell"},
                                        {PrintOutcome::Canceled, ""}}) {
    CAPTURE(name_of(outcome));
    Bench bench;
    EndedPrint print = bench.ended(outcome, reason);
    // In the model's place, beside which nothing is wrong.
    const fs::path there = bench.spool.folder(folder_for(outcome)) / "part.stl";
    fs::create_directories(there / "full");
    const FiledPrint filed = bench.file(std::move(print));
    REQUIRE(filed.troubles.size() == 1);
    CHECK(filed.troubles.front().starts_with("stays in printing: "));
    const std::optional<PrintEnd> end = recorded_end(bench.spool, "part");
    REQUIRE(end);
    CHECK(end->outcome == outcome);
    CHECK(end->reason == reason);
  }
}

TEST_CASE("Without a record, or with what is none or another job's, nobody knows how a print ended") {
  Bench bench;
  CHECK_FALSE(recorded_end(bench.spool, "part"));
  for (const char* text :
       {"", "{", "[]", R"({"job": "part", "outcome": 3})", R"({"job": "part", "outcome": "splendid"})",
        R"({"outcome": "done"})", R"({"job": "other", "outcome": "done"})"}) {
    CAPTURE(text);
    bench.spool.records().keep_end_of_print(text);
    CHECK_FALSE(recorded_end(bench.spool, "part"));
  }
}

TEST_CASE("How a print ended is on the disk before it is filed, and gone once it is") {
  Bench bench;
  PrintArchivist archivist(bench.loop, bench.spool);
  archivist.record("part", {PrintOutcome::Failed, "the sky fell"});
  archivist.file(bench.ended(PrintOutcome::Failed, "the sky fell"),
                 [&](const FiledPrint&) { bench.loop.stop(); });
  bench.loop.run();
  CHECK_FALSE(recorded_end(bench.spool, "part"));
  CHECK(bench.has("failed/part.stl"));
  archivist.record("next", {PrintOutcome::Failed, "the sky fell"});
  while (!recorded_end(bench.spool, "next"))
    std::this_thread::yield();
  CHECK(recorded_end(bench.spool, "next")->reason == "the sky fell");
  CHECK_FALSE(recorded_end(bench.spool, "part"));
}

TEST_CASE("A job that is begun has no end yet, whatever one of its name came to") {
  Bench bench;
  bench.spool.records().keep_end_of_print(R"({"job": "new", "outcome": "done", "reason": ""})");
  REQUIRE(recorded_end(bench.spool, "new"));
  std::ofstream(bench.spool.folder(Spool::Folder::Incoming) / "new.stl") << "a model";
  CHECK(bench.spool.begin("new.stl").name == "new");
  CHECK_FALSE(recorded_end(bench.spool, "new"));
}

TEST_CASE("A print is filed in a folder that was removed meanwhile") {
  for (const PrintOutcome outcome : {PrintOutcome::Done, PrintOutcome::Failed}) {
    Bench bench;
    EndedPrint print = bench.ended(outcome, "the sky fell");
    const fs::path folder = bench.spool.folder(folder_for(outcome));
    fs::remove_all(folder);
    const FiledPrint filed = bench.file(std::move(print));
    CHECK(filed.troubles.empty());
    CHECK(filed.moved);
    CHECK(fs::exists(folder / "part.stl"));
    CHECK(fs::exists(folder / "part.report.json"));
  }
}

TEST_CASE("An archivist files one print at a time") {
  Bench bench;
  PrintArchivist archivist(bench.loop, bench.spool);
  // In the child alone: a print is filed there, and a second one is not.
  CHECK(testing::contract_broken_by([&] {
          for (int print = 0; print < 2; ++print)
            archivist.file(bench.ended(PrintOutcome::Done), [](const FiledPrint&) {});
        }) == "no other print is being filed");
}
