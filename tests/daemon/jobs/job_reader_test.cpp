#include "daemon/jobs/job_reader.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/jobs/acceptances.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::PrinterFixture {
 public:
  void start() { reader = std::make_unique<JobReader>(config, spool, loop); }
  // What the check of this file in incoming/ says.
  std::optional<JobRefusal> check(const std::string& file) {
    std::optional<JobRefusal> said;
    bool called = false;
    reader->check(file, JobReader::Keep::Nothing, [&](const CheckedJob& found) {
      if (const auto* const refusal = std::get_if<JobRefusal>(&found))
        said = *refusal;
      else
        outlook = std::get<JobOutlook>(found);
      called = true;
    });
    CHECK(run_until([&] { return called; }));
    return said;
  }

  std::unique_ptr<JobReader> reader;
  std::optional<JobOutlook> outlook;  // that the last check has found
};

class Started : public Desk {
 public:
  Started() { start(); }
};

}  // namespace

TEST_CASE("A job whose turn it is is prepared, and its files stay where they are") {
  Started desk;
  desk.put(Spool::Folder::Printing, "part.stl");
  std::optional<ReadJob> read;
  desk.reader->read(desk.spool.files_of(Spool::Folder::Printing, "part.stl"), std::nullopt,
                    [&](ReadJob job) { read = std::move(job); });
  REQUIRE(desk.run_until([&] { return read.has_value(); }));
  REQUIRE(std::holds_alternative<PreparedJob>(*read));
  CHECK(std::get<PreparedJob>(*read).summary.layers.count > 0);
  CHECK(desk.has("printing/part.stl"));
}

TEST_CASE("A waiting job with which nothing is wrong is not refused") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  CHECK_FALSE(desk.check("part.stl"));
}

TEST_CASE("The check of a waiting job finds what it will be") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put_text(Spool::Folder::Incoming, "part.json", R"({"layer_height_um": 50, "copies": 3})");
  REQUIRE_FALSE(desk.check("part.stl"));
  REQUIRE(desk.outlook);
  const JobOutlook& outlook = *desk.outlook;
  // The box has 12 facets of 50 bytes behind 84.
  CHECK(outlook.bytes == 684 + 36);
  CHECK(outlook.parts == 3);
  CHECK(outlook.resin == "standard");
  CHECK(outlook.layers == 4);
  CHECK(outlook.thinnest_layer == Nanometers{50'000});
  CHECK(outlook.thickest_layer == Nanometers{50'000});
  CHECK(outlook.height_mm == Approx(0.2));
  // More than four exposures, and less than four minutes.
  CHECK(outlook.print_time > std::chrono::seconds{4});
  CHECK(outlook.print_time < std::chrono::minutes{4});
}

TEST_CASE("A waiting job that is no model is refused with what it is not") {
  Started desk;
  desk.put_text(Spool::Folder::Incoming, "part.stl", "no model");
  const auto refusal = desk.check("part.stl");
  REQUIRE(refusal);
  CHECK_FALSE(refusal->reason.empty());
  CHECK_FALSE(refusal->for_now);
  CHECK(refusal->profile.empty());
}

TEST_CASE("A job for which there would be no room in a process that held nothing else is refused for good") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.config.memory_limit_bytes = 1;
  const auto refusal = desk.check("part.stl");
  REQUIRE(refusal);
  CHECK_FALSE(refusal->reason.empty());
  CHECK_FALSE(refusal->for_now);
}

TEST_CASE("A profile that cannot be used is told as the profile's matter") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.config.resin = "none-such";
  const auto refusal = desk.check("part.stl");
  REQUIRE(refusal);
  CHECK(refusal->profile.starts_with("the resin profile "));
}

TEST_CASE("A ticket that names a profile which there is none of is the job's matter") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put_text(Spool::Folder::Incoming, "part.json", R"({"resin": "none-such"})");
  const auto refusal = desk.check("part.stl");
  REQUIRE(refusal);
  CHECK(refusal->profile.empty());
}

TEST_CASE("What the last process was reading when it ended is not read") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const fs::path record = desk.state() / "reading", kept = desk.folder.path() / "kept";
  {
    ReadingRecord dying(record);
    const ReadingRecord::Reading under_way(dying, desk.spool.files_of(Spool::Folder::Incoming, "part.stl"));
    fs::copy_file(record, kept);
  }
  fs::rename(kept, record);
  desk.start();
  const auto refusal = desk.check("part.stl");
  REQUIRE(refusal);
  CHECK(refusal->reason == kEndedAProcess);
}

TEST_CASE("Jobs are read in the order in which they were given") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "a.stl");
  desk.put_text(Spool::Folder::Incoming, "b.stl", "no model");
  std::vector<std::string> order;
  for (const std::string file : {"a.stl", "b.stl"})
    desk.reader->check(file, JobReader::Keep::Nothing,
                       [&order, file](const auto&) { order.push_back(file); });
  REQUIRE(desk.run_until([&] { return order.size() == 2; }));
  CHECK(order == std::vector<std::string>{"a.stl", "b.stl"});
}

TEST_CASE("A check is given up for the job whose turn has come, and for one that is forgotten") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put(Spool::Folder::Printing, "next.stl");
  std::optional<CheckedJob> found;
  // The first keeps the reader's thread busy until the other is ordered, and given up.
  models::write_binary_stl(desk.spool.folder(Spool::Folder::Incoming) / "large.stl", models::sphere(20, 100));
  desk.reader->check("large.stl", JobReader::Keep::Nothing, [](const auto&) {});
  desk.reader->check("part.stl", JobReader::Keep::Nothing, [&](const CheckedJob& said) { found = said; });
  SECTION("a turn") {
    desk.reader->read(desk.spool.files_of(Spool::Folder::Printing, "next.stl"), std::nullopt,
                      [](const auto&) {});
  }
  SECTION("a forgotten one") {
    desk.reader->forget("part.stl");
  }
  REQUIRE(desk.run_until([&] { return found.has_value(); }));
  CHECK(std::holds_alternative<ReadingGivenUp>(*found));
}

TEST_CASE("A check of the job whose turn is next gives up the others") {
  Started desk;
  models::write_binary_stl(desk.spool.folder(Spool::Folder::Incoming) / "large.stl", models::sphere(20, 100));
  desk.put(Spool::Folder::Incoming, "next.stl");
  std::optional<CheckedJob> large, next;
  desk.reader->check("large.stl", JobReader::Keep::Nothing, [&](const CheckedJob& said) { large = said; });
  desk.reader->check("next.stl", JobReader::Keep::Prepared, [&](const CheckedJob& said) { next = said; });
  REQUIRE(desk.run_until([&] { return next.has_value(); }));
  REQUIRE(large);
  CHECK(std::holds_alternative<ReadingGivenUp>(*large));
  CHECK(std::holds_alternative<JobOutlook>(*next));
}

TEST_CASE("A job that is read for its turn is given up in its search for supports") {
  Started desk;
  desk.config.supports = SupportPolicy::Auto;
  models::write_binary_stl(desk.spool.folder(Spool::Folder::Printing) / "ball.stl", models::sphere(5, 60));
  std::optional<bool> given_up;
  desk.reader->read(desk.spool.files_of(Spool::Folder::Printing, "ball.stl"), std::nullopt,
                    [&](const ReadJob& job) { given_up = std::holds_alternative<ReadingGivenUp>(job); });
  desk.reader->give_up_reading();
  REQUIRE(desk.run_until([&] { return given_up.has_value(); }));
  CHECK(*given_up);
}

TEST_CASE("The text of a refusal is bounded and fit for a terminal, and keeps its lines") {
  CHECK(refusal_text("one\ntwo\x1b[2J") == "one\ntwo?[2J");
  CHECK(refusal_text(std::string(100'000, 'x')).size() < 10'000);
}

namespace {

// Looks through this file in incoming/, which waits for `before`.
JobAnalysisOutcome analyzed(
    Started& desk, const std::string& file, const std::function<void()>& before = [] {}) {
  std::optional<JobAnalysisOutcome> found;
  desk.reader->analyze(file, JobReader::Keep::Nothing, [&](const JobAnalysisOutcome& said) { found = said; });
  before();
  CHECK(desk.run_until([&] { return found.has_value(); }));
  return found.value_or(JobAnalysisOutcome{ReadingGivenUp{}});
}

}  // namespace

TEST_CASE("A job that is looked through is told with its resin, its files and its settings") {
  Started desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = desk.spool.files_of(Spool::Folder::Incoming, "part.stl");
  const JobAnalysisOutcome found = analyzed(desk, "part.stl");
  REQUIRE(std::holds_alternative<AnalyzedJob>(found));
  const auto& job = std::get<AnalyzedJob>(found);
  CHECK(job.analysis.findings.empty());
  // 3 x 2 x 0.2 mm.
  CHECK(job.analysis.resin_ml == Approx(0.0012).epsilon(0.01));
  CHECK(job.content == content_mark(files));
  CHECK(job.settings == read_settings(files, desk.config));
}

TEST_CASE("What is no model is refused when it is looked through, too") {
  Started desk;
  desk.put_text(Spool::Folder::Incoming, "part.stl", "no model");
  CHECK(std::holds_alternative<JobRefusal>(analyzed(desk, "part.stl")));
}

TEST_CASE("A job whose turn has come, and one that is forgotten, end a look through layers") {
  Started desk;
  // Thousands of layers, so that it is not over before.
  models::write_binary_stl(desk.spool.folder(Spool::Folder::Incoming) / "part.stl",
                           models::box({0, 0, 0}, {90, 50, 100}));
  desk.put(Spool::Folder::Printing, "next.stl");
  SECTION("a turn") {
    const JobAnalysisOutcome found = analyzed(desk, "part.stl", [&] {
      desk.reader->read(desk.spool.files_of(Spool::Folder::Printing, "next.stl"), std::nullopt,
                        [](const auto&) {});
    });
    CHECK(std::holds_alternative<ReadingGivenUp>(found));
  }
  SECTION("a forgotten one") {
    const JobAnalysisOutcome found = analyzed(desk, "part.stl", [&] { desk.reader->forget("part.stl"); });
    CHECK(std::holds_alternative<ReadingGivenUp>(found));
  }
}
