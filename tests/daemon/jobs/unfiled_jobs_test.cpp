#include "daemon/jobs/unfiled_jobs.hpp"

#include <filesystem>
#include <fstream>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class UnfiledJobsFixture : public testing::PrinterFixture {
 public:
  void leave(JobEnd end) {
    put(Spool::Folder::Printing, end.job + ".stl");
    end.key = new_job_key();
    jobs.add_left(spool.files_of(Spool::Folder::Printing, end.job + ".stl"), end);
  }

  // Files all jobs on this thread. Throws std::system_error.
  void file_all() {
    JobFilingRun run = jobs.begin_filing();
    std::exception_ptr trouble;
    try {
      run.run(spool);
    } catch (const std::system_error&) {
      trouble = std::current_exception();
    }
    jobs.end_filing(run);
    if (trouble) std::rethrow_exception(trouble);
  }

  testing::FakePrinter printer;
  std::vector<EndedJob>& reported = printer.left;
  UnfiledJobs jobs{log.log, printer};
};

}  // namespace

TEST_CASE("Each job that was left is filed by its own end, and an interrupted one with what to do") {
  UnfiledJobsFixture fixture;
  fixture.leave({.job = "good", .outcome = "done"});
  fixture.leave({.job = "bad", .outcome = "failed", .reason = "the sky fell"});
  fixture.leave(
      {.job = "cut", .outcome = "failed", .reason = "The print was cut", .kind = JobEnd::Kind::Interrupted});
  fixture.file_all();
  CHECK(fixture.jobs.empty());
  CHECK(fixture.has("done/good.stl"));
  CHECK_FALSE(fixture.has("done/good.reason.txt"));
  CHECK(fixture.has("failed/bad.reason.txt"));
  std::ifstream reason(fixture.spool.folder(Spool::Folder::Failed) / "cut.reason.txt");
  std::string line;
  CHECK(std::getline(reason, line));
  CHECK(line == "The print was cut. Put the model into incoming again to print it from the start.");
  CHECK(fixture.log.has("info: cut: moved to failed"));
}

TEST_CASE(
    "The end of each job that another process left is reported, but a known end is not reported again") {
  UnfiledJobsFixture fixture;
  fixture.leave(
      {.job = "cut", .outcome = "failed", .reason = "The print was cut", .kind = JobEnd::Kind::Interrupted});
  fixture.leave({.job = "good", .outcome = "done"});
  fixture.put_text(Spool::Folder::Done, "good.report.json", "{}");
  fixture.put(Spool::Folder::Printing, "known.stl");
  fixture.jobs.add_known(fixture.spool.files_of(Spool::Folder::Printing, "known.stl"),
                         {.key = 1, .job = "known", .outcome = "done"});
  fixture.file_all();
  CHECK(fixture.has("done/known.stl"));
  REQUIRE(fixture.reported.size() == 2);
  CHECK(fixture.reported[0].name == "good");
  CHECK(fixture.reported[0].outcome == "done");
  CHECK(fixture.reported[0].reports.json == fixture.spool.folder(Spool::Folder::Done) / "good.report.json");
  CHECK(fixture.reported[0].reports.html.empty());
  CHECK(fixture.reported[1].name == "cut");
  CHECK(fixture.reported[1].outcome == "failed");
  CHECK(fixture.reported[1].reason == "The print was cut");
}

TEST_CASE("A job that cannot be filed stays in printing/, with the jobs after it") {
  UnfiledJobsFixture fixture;
  fixture.leave({.job = "one", .outcome = "done"});
  fixture.leave({.job = "two", .outcome = "done"});
  const fs::path obstacle = fixture.spool.folder(Spool::Folder::Done) / "two.stl";
  fs::create_directories(obstacle / "full");
  CHECK_THROWS_AS(fixture.file_all(), std::system_error);
  CHECK(fixture.jobs.last() == "two");
  CHECK(fixture.has("printing/one.stl"));
  CHECK(fixture.has("printing/two.stl"));
  fs::remove_all(obstacle);
  fixture.file_all();
  CHECK(fixture.has("done/one.stl"));
  CHECK(fixture.has("done/two.stl"));
}

TEST_CASE("Jobs that are being filed are not filed a second time") {
  UnfiledJobsFixture fixture;
  fixture.leave({.job = "one", .outcome = "done"});
  JobFilingRun first = fixture.jobs.begin_filing(), second = fixture.jobs.begin_filing();
  second.run(fixture.spool);
  fixture.jobs.end_filing(second);
  CHECK(fixture.has("printing/one.stl"));
  first.run(fixture.spool);
  fixture.jobs.end_filing(first);
  CHECK(fixture.has("done/one.stl"));
  CHECK(fixture.jobs.empty());
  CHECK_FALSE(fixture.log.has("is gone"));
}
