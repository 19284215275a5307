#include "daemon/jobs/job_reader.hpp"

#include <filesystem>
#include <variant>

#include "daemon/jobs/acceptances.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class ReaderFixture : public testing::PrinterFixture {
 public:
  void start() { reader = std::make_unique<JobReader>(config, spool, loop); }
  // Checks incoming/`file` and returns its refusal; nullopt if it is not refused.
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
  std::optional<JobOutlook> outlook;  // result of the last successful check
};

class StartedReaderFixture : public ReaderFixture {
 public:
  StartedReaderFixture() { start(); }
};

}  // namespace

TEST_CASE_METHOD(StartedReaderFixture,
                 "A job whose turn has come is prepared, and its files stay in printing/") {
  put(Spool::Folder::Printing, "part.stl");
  std::optional<ReadJob> read;
  reader->read(spool.files_of(Spool::Folder::Printing, "part.stl"), std::nullopt,
               [&](ReadJob job) { read = std::move(job); });
  REQUIRE(run_until([&] { return read.has_value(); }));
  REQUIRE(std::holds_alternative<PreparedJob>(*read));
  CHECK(std::get<PreparedJob>(*read).summary.layers.count > 0);
  CHECK(has("printing/part.stl"));
}

TEST_CASE_METHOD(StartedReaderFixture, "A valid waiting job is not refused") {
  put(Spool::Folder::Incoming, "part.stl");
  CHECK_FALSE(check("part.stl"));
}

TEST_CASE_METHOD(StartedReaderFixture, "The check of a waiting job returns its outlook") {
  put(Spool::Folder::Incoming, "part.stl");
  put_text(Spool::Folder::Incoming, "part.json", R"({"layer_height_um": 50, "copies": 3})");
  REQUIRE_FALSE(check("part.stl"));
  REQUIRE(outlook);
  // The file of the box has 84 bytes and 12 facets of 50 bytes; its ticket has 36 bytes.
  CHECK(outlook->bytes == 684 + 36);
  CHECK(outlook->parts == 3);
  CHECK(outlook->resin == "standard");
  CHECK(outlook->layers == 4);
  CHECK(outlook->thinnest_layer == Nanometers{50'000});
  CHECK(outlook->thickest_layer == Nanometers{50'000});
  CHECK(outlook->height_mm == testing::Approx(0.2));
  // More than four exposures and the first layer's wait, and less than five minutes.
  CHECK(outlook->forecast.time.total() > std::chrono::seconds{64});
  CHECK(outlook->forecast.time.total() < std::chrono::minutes{5});
}

TEST_CASE_METHOD(StartedReaderFixture,
                 "A waiting job is refused for good, with a reason, and only a missing default profile is no "
                 "fault of it") {
  put(Spool::Folder::Incoming, "part.stl");
  bool is_the_profiles_fault = false;
  SECTION("no model") {
    put_text(Spool::Folder::Incoming, "part.stl", "no model");
  }
  SECTION("too much memory, even in an otherwise empty process") {
    config.memory_limit_bytes = 1;
  }
  SECTION("a ticket that names a missing profile") {
    put_text(Spool::Folder::Incoming, "part.json", R"({"resin": "none-such"})");
  }
  SECTION("a missing default profile") {
    config.resin = "none-such";
    is_the_profiles_fault = true;
  }
  const auto refusal = check("part.stl");
  REQUIRE(refusal);
  CHECK_FALSE(refusal->reason.empty());
  CHECK_FALSE(refusal->for_now);
  CHECK(refusal->profile.starts_with("the resin profile ") == is_the_profiles_fault);
  CHECK(refusal->profile.empty() == !is_the_profiles_fault);
}

TEST_CASE_METHOD(ReaderFixture, "A job that the last process was reading when it ended is not read") {
  put(Spool::Folder::Incoming, "part.stl");
  const fs::path record = state() / "reading", kept = folder.path() / "kept";
  {
    ReadingRecord dying(record);
    const ReadingRecord::Reading under_way(dying, spool.files_of(Spool::Folder::Incoming, "part.stl"));
    fs::copy_file(record, kept);
  }
  fs::rename(kept, record);
  start();
  const auto refusal = check("part.stl");
  REQUIRE(refusal);
  CHECK(refusal->reason == kEndedAProcess);
}

TEST_CASE_METHOD(StartedReaderFixture, "Jobs are read in the order of the requests") {
  put(Spool::Folder::Incoming, "a.stl");
  put_text(Spool::Folder::Incoming, "b.stl", "no model");
  std::vector<std::string> order;
  for (const std::string file : {"a.stl", "b.stl"})
    reader->check(file, JobReader::Keep::Nothing, [&order, file](const auto&) { order.push_back(file); });
  REQUIRE(run_until([&] { return order.size() == 2; }));
  CHECK(order == std::vector<std::string>{"a.stl", "b.stl"});
}

TEST_CASE_METHOD(StartedReaderFixture,
                 "A check is given up when a job's turn comes, or when its own job is forgotten") {
  put(Spool::Folder::Incoming, "part.stl");
  put(Spool::Folder::Printing, "next.stl");
  std::optional<CheckedJob> found;
  // The first check keeps the reader's thread busy until the second is requested and given up.
  models::write_binary_stl(spool.folder(Spool::Folder::Incoming) / "large.stl", models::sphere(20, 100));
  reader->check("large.stl", JobReader::Keep::Nothing, [](const auto&) {});
  reader->check("part.stl", JobReader::Keep::Nothing, [&](const CheckedJob& said) { found = said; });
  SECTION("a turn comes") {
    reader->read(spool.files_of(Spool::Folder::Printing, "next.stl"), std::nullopt, [](const auto&) {});
  }
  SECTION("the job is forgotten") {
    reader->forget("part.stl");
  }
  REQUIRE(run_until([&] { return found.has_value(); }));
  CHECK(std::holds_alternative<ReadingGivenUp>(*found));
}

TEST_CASE_METHOD(StartedReaderFixture, "The check of the next job gives up the other checks") {
  models::write_binary_stl(spool.folder(Spool::Folder::Incoming) / "large.stl", models::sphere(20, 100));
  put(Spool::Folder::Incoming, "next.stl");
  std::optional<CheckedJob> large, next;
  reader->check("large.stl", JobReader::Keep::Nothing, [&](const CheckedJob& said) { large = said; });
  reader->check("next.stl", JobReader::Keep::Prepared, [&](const CheckedJob& said) { next = said; });
  REQUIRE(run_until([&] { return next.has_value(); }));
  REQUIRE(large);
  CHECK(std::holds_alternative<ReadingGivenUp>(*large));
  CHECK(std::holds_alternative<JobOutlook>(*next));
}

TEST_CASE_METHOD(StartedReaderFixture,
                 "The reading of a job whose turn has come can be given up in its search for supports") {
  config.supports = SupportPolicy::Auto;
  models::write_binary_stl(spool.folder(Spool::Folder::Printing) / "ball.stl", models::sphere(5, 60));
  std::optional<bool> given_up;
  reader->read(spool.files_of(Spool::Folder::Printing, "ball.stl"), std::nullopt,
               [&](const ReadJob& job) { given_up = std::holds_alternative<ReadingGivenUp>(job); });
  reader->give_up_reading();
  REQUIRE(run_until([&] { return given_up.has_value(); }));
  CHECK(*given_up);
}

TEST_CASE("The text of a refusal is shortened, safe for a terminal, and keeps its lines") {
  CHECK(refusal_text("one\ntwo\x1b[2J") == "one\ntwo?[2J");
  CHECK(refusal_text(std::string(100'000, 'x')).size() < 10'000);
}

namespace {

// Requests the analysis of incoming/`file`, calls `before`, and returns the result of the analysis.
JobAnalysisOutcome analyzed(
    StartedReaderFixture& fixture, const std::string& file, const std::function<void()>& before = [] {}) {
  std::optional<JobAnalysisOutcome> found;
  fixture.reader->analyze(file, JobReader::Keep::Nothing,
                          [&](const JobAnalysisOutcome& said) { found = said; });
  before();
  CHECK(fixture.run_until([&] { return found.has_value(); }));
  return found.value_or(JobAnalysisOutcome{ReadingGivenUp{}});
}

}  // namespace

TEST_CASE_METHOD(StartedReaderFixture,
                 "The analysis of a job returns its resin volume, content and settings") {
  put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = spool.files_of(Spool::Folder::Incoming, "part.stl");
  const JobAnalysisOutcome found = analyzed(*this, "part.stl");
  REQUIRE(std::holds_alternative<AnalyzedJob>(found));
  const auto& job = std::get<AnalyzedJob>(found);
  CHECK(job.analysis.findings.empty());
  // 3 x 2 x 0.2 mm.
  CHECK(job.analysis.resin_ml == testing::Approx(0.0012).epsilon(0.01));
  CHECK(job.content == content_mark(files));
  CHECK(job.settings == read_settings(files, config));
}

TEST_CASE_METHOD(StartedReaderFixture, "An analysis refuses an invalid model, too") {
  put_text(Spool::Folder::Incoming, "part.stl", "no model");
  CHECK(std::holds_alternative<JobRefusal>(analyzed(*this, "part.stl")));
}

TEST_CASE_METHOD(StartedReaderFixture,
                 "An analysis is given up when a job's turn comes, or when its own job is forgotten") {
  // Thousands of layers, so that the analysis is not over too early.
  models::write_binary_stl(spool.folder(Spool::Folder::Incoming) / "part.stl",
                           models::box({0, 0, 0}, {90, 50, 100}));
  put(Spool::Folder::Printing, "next.stl");
  SECTION("a turn comes") {
    const JobAnalysisOutcome found = analyzed(*this, "part.stl", [&] {
      reader->read(spool.files_of(Spool::Folder::Printing, "next.stl"), std::nullopt, [](const auto&) {});
    });
    CHECK(std::holds_alternative<ReadingGivenUp>(found));
  }
  SECTION("the job is forgotten") {
    const JobAnalysisOutcome found = analyzed(*this, "part.stl", [&] { reader->forget("part.stl"); });
    CHECK(std::holds_alternative<ReadingGivenUp>(found));
  }
}
