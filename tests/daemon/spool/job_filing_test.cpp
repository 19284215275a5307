#include "daemon/spool/job_filing.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class JobFilingFixture : public testing::PrinterFixture {
 public:
  JobFilingFixture() { put(Spool::Folder::Printing, "part.stl"); }

  void file() { file_job(spool, log.log, files, Spool::Folder::Failed, "no model\n"); }

  JobFiles files{"part", spool.folder(Spool::Folder::Printing) / "part.stl", std::nullopt};
};

}  // namespace

TEST_CASE("A job is filed with its reason beside it") {
  JobFilingFixture fixture;
  fixture.file();
  CHECK(fixture.has("failed/part.stl"));
  CHECK(fixture.has("failed/part.reason.txt"));
  CHECK_FALSE(fixture.log.has("error"));
}

TEST_CASE("A job whose reason cannot be written is filed, and the error is logged") {
  JobFilingFixture fixture;
  fs::create_directories(fixture.spool.folder(Spool::Folder::Failed) / "part.reason.txt" / "full");
  fixture.file();
  CHECK(fixture.has("failed/part.stl"));
  CHECK(fixture.log.has("error: part: cannot write its reason file: "));
}

TEST_CASE("A job that someone has removed is logged") {
  JobFilingFixture fixture;
  fs::remove(fixture.files.model);
  fixture.file();
  CHECK(fixture.log.has("part.stl is gone: someone removed it"));
}

TEST_CASE("A job that cannot be moved stays in printing/, and the error is logged") {
  JobFilingFixture fixture;
  fs::create_directories(fixture.spool.folder(Spool::Folder::Failed) / "part.stl" / "full");
  fixture.file();
  CHECK(fixture.has("printing/part.stl"));
  CHECK(fixture.log.has("error: part: stays in printing: "));
}
