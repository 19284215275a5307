#include "daemon/jobs/print_archivist.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <string>
#include <thread>

#include "hw/png_file.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

// A spool with the job "part" in printing/, whose print has ended.
class ArchivistFixture {
 public:
  ArchivistFixture() { std::ofstream(spool.folder(Spool::Folder::Printing) / "part.stl") << "a model"; }

  [[nodiscard]] EndedPrint ended(PrintOutcome outcome, const std::string& reason = "",
                                 Elevation elevation = {}) const {
    EndedPrint print;
    print.files = spool.files_of(Spool::Folder::Printing, "part.stl");
    print.report.job = "part";
    print.report.outcome = outcome;
    print.report.reason = reason;
    print.end = {.key = 1, .job = "part", .outcome = std::string(name_of(outcome)), .reason = reason};
    print.report.summary.layers.thinnest = print.report.summary.layers.thickest = Nanometers{50'000};
    print.report.summary.irradiance_mw_cm2 = 5;
    print.report.summary.models.resize(1);
    print.report.summary.models.front().centers = {{0, 0}};
    const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {3, 2, 1})),
                            elevation};
    print.engine = std::make_unique<ContourEngine>(
        std::vector{PlateModel{box, {PixelMap::true_scale(testing::kSmallDisplay, {1.5, 1})}}},
        EngineSettings{.display = testing::kSmallDisplay});
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

  [[nodiscard]] std::string text(const std::string& name) const {
    std::ifstream file(folder.path() / "spool" / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(folder.path() / "spool" / name); }

  testing::TemporaryFolder folder;
  EventLoop loop;
  testing::NoSpoolObserver observer;
  Spool spool{folder.path() / "spool", loop, observer};
};

}  // namespace

TEST_CASE_METHOD(ArchivistFixture, "A finished print is in done/ with its report, page and picture") {
  const FiledPrint filed = file(ended(PrintOutcome::Done));
  CHECK(filed.troubles.empty());
  for (const char* name : {"part.stl", "part.report.json", "part.report.html", "part.preview.png"})
    CHECK(has(std::string("done/") + name));
  CHECK_FALSE(has("printing/part.stl"));
}

TEST_CASE("The picture shows the printed part of a model at the model's height above the plate") {
  // Ten layers, up to 1 mm above the plate: the whole model if it stands on the plate.
  const auto brightest_in_picture = [](Elevation elevation) {
    ArchivistFixture fixture;
    EndedPrint print = fixture.ended(PrintOutcome::Canceled, "", elevation);
    for (int i = 0; i < 10; ++i) {
      LayerRecord& layer = print.report.layers.emplace_back();
      layer.layer = i;
      layer.bottom = Nanometers{100'000 * i};
      layer.thickness = Nanometers{100'000};
      layer.mask_height = Nanometers{100'000 * i + 50'000};
      layer.complete = true;
    }
    CHECK(fixture.file(std::move(print)).troubles.empty());
    const Mask picture = read_png(fixture.folder.path() / "spool/failed/part.preview.png");
    return int{*std::ranges::max_element(picture.pixels())};
  };
  CHECK(brightest_in_picture({}) > 150);
  CHECK(brightest_in_picture(Elevation(Nanometers{500'000})) > 150);
  CHECK(brightest_in_picture(Elevation(Nanometers{1'100'000})) < 100);  // all of it is faint
}

TEST_CASE_METHOD(ArchivistFixture,
                 "A failure to write the report is reported, and the job is filed without it") {
  // A folder cannot be replaced by a file.
  fs::create_directory(spool.folder(Spool::Folder::Failed) / "part.report.json");
  const FiledPrint filed = file(ended(PrintOutcome::Failed, "the sky fell"));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front().starts_with("no report: cannot write "));
  CHECK(has("failed/part.stl"));
  CHECK(has("failed/part.reason.txt"));
}

TEST_CASE_METHOD(ArchivistFixture, "The masks of a rise go beside the report, which names them") {
  const fs::path written = folder.path() / "print-frames";
  std::ofstream(written) << "frames";
  EndedPrint print = ended(PrintOutcome::Canceled);
  print.report.layers.resize(1);
  print.report.layers.front().rises = true;
  print.report.layers.front().frames.shown = 15;
  std::promise<EndedFrameLog> log;
  print.frames = log.get_future().share();
  log.set_value({written, 12, 3, "the disk was slower than the print"});
  const FiledPrint filed = file(std::move(print));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front() ==
        "3 masks that it showed while the plate rose are not on record: the disk was slower than the print");
  CHECK(text("failed/part.frames.bin") == "frames");
  CHECK_FALSE(fs::exists(written));
  CHECK(text("failed/part.report.json").find(R"("file": "part.frames.bin")") != std::string::npos);
  CHECK(text("failed/part.report.html").find("part.frames.bin lists 12 of them, 3 could not be written") !=
        std::string::npos);
}

TEST_CASE_METHOD(ArchivistFixture, "A disk that never ends the record of masks leaves it out of the report") {
  std::promise<EndedFrameLog> log;
  EndedPrint print = ended(PrintOutcome::Done);
  print.frames = log.get_future().share();
  print.report.layers.resize(1);
  print.report.layers.front().rises = true;
  const FiledPrint filed = file(std::move(print));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front() ==
        "no record of the masks that it showed while the plate rose: the disk does not answer");
  CHECK(has("done/part.report.json"));
}

TEST_CASE_METHOD(ArchivistFixture, "A print that did not rise is filed without a record of masks") {
  std::promise<EndedFrameLog> log;
  EndedPrint print = ended(PrintOutcome::Done);
  print.frames = log.get_future().share();
  CHECK(file(std::move(print)).troubles.empty());
}

TEST_CASE_METHOD(ArchivistFixture, "A failure to write the page is reported, and everything else is there") {
  fs::create_directory(spool.folder(Spool::Folder::Done) / "part.report.html");
  const FiledPrint filed = file(ended(PrintOutcome::Done));
  REQUIRE(filed.troubles.size() == 1);
  CHECK(filed.troubles.front().starts_with("no report.html: "));
  CHECK(has("done/part.report.json"));
  CHECK(has("done/part.preview.png"));
  CHECK(has("done/part.stl"));
}

TEST_CASE("A job that cannot be moved is reported, and the end of its print can be read afterwards") {
  for (const auto& [outcome, reason] : {std::pair{PrintOutcome::Done, ""},
                                        {PrintOutcome::Failed, "the sky fell"},
                                        {PrintOutcome::Canceled, ""}}) {
    CAPTURE(name_of(outcome));
    ArchivistFixture fixture;
    EndedPrint print = fixture.ended(outcome, reason);
    // An obstacle in the place of the model only.
    const fs::path there = fixture.spool.folder(folder_for(print.end)) / "part.stl";
    fs::create_directories(there / "full");
    const FiledPrint filed = fixture.file(std::move(print));
    REQUIRE(filed.troubles.size() == 1);
    CHECK(filed.troubles.front().starts_with("stays in printing: "));
    const std::optional<JobEnd> end = fixture.spool.ends().end_of("part");
    REQUIRE(end);
    CHECK(end->outcome == name_of(outcome));
    CHECK(end->reason == reason);
  }
}

TEST_CASE_METHOD(ArchivistFixture, "The end of a print is recorded before the print is filed") {
  PrintArchivist archivist(loop, spool);
  const EndedPrint print = ended(PrintOutcome::Failed, "the sky fell");
  archivist.record(print.end);
  archivist.file(ended(PrintOutcome::Failed, "the sky fell"), [&](const FiledPrint&) { loop.stop(); });
  loop.run();
  CHECK_FALSE(spool.ends().end_of("part"));
  CHECK(spool.ends().pending()[0].awaits(EndConsumer::History));
  CHECK(has("failed/part.stl"));
  archivist.record({.key = 2, .job = "next", .outcome = "failed", .reason = "the sky fell"});
  while (!spool.ends().end_of("next"))
    std::this_thread::yield();
  CHECK(spool.ends().end_of("next")->reason == "the sky fell");
}

TEST_CASE_METHOD(ArchivistFixture, "A running job has no outcome, even if an earlier job had its name") {
  spool.ends().add({.key = 1, .job = "new", .outcome = "done"});
  std::ofstream(spool.folder(Spool::Folder::Incoming) / "new.stl") << "a model";
  CHECK(spool.begin("new.stl").name == "new");
  const JobEndRecord next(spool.records());
  CHECK_FALSE(next.end_of("new"));
  CHECK(next.pending()[0].awaits(EndConsumer::History));
}

TEST_CASE("A print is filed in a folder that was removed meanwhile") {
  for (const PrintOutcome outcome : {PrintOutcome::Done, PrintOutcome::Failed}) {
    ArchivistFixture fixture;
    EndedPrint print = fixture.ended(outcome, "the sky fell");
    const fs::path folder = fixture.spool.folder(folder_for(print.end));
    fs::remove_all(folder);
    const FiledPrint filed = fixture.file(std::move(print));
    CHECK(filed.troubles.empty());
    CHECK(filed.moved);
    CHECK(fs::exists(folder / "part.stl"));
    CHECK(fs::exists(folder / "part.report.json"));
  }
}

TEST_CASE_METHOD(ArchivistFixture, "An archivist files one print at a time") {
  PrintArchivist archivist(loop, spool);
  // In the child process only: it files one print, and must not file a second one.
  CHECK(testing::contract_broken_by([&] {
          for (int print = 0; print < 2; ++print)
            archivist.file(ended(PrintOutcome::Done), [](const FiledPrint&) {});
        }) == "no other print is being filed");
}
