#include "daemon/spool/job_filing.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

class JobFilingFixture : public testing::PrinterFixture {
 public:
  JobFilingFixture() { put(Spool::Folder::Printing, "part.stl"); }

  std::vector<std::string> move() { return move_job(spool, files, Spool::Folder::Failed, "no model\n"); }

  JobFiles files{"part", spool.folder(Spool::Folder::Printing) / "part.stl", std::nullopt};
};

}  // namespace

TEST_CASE_METHOD(JobFilingFixture, "A job is filed with its reason beside it") {
  CHECK(move().empty());
  CHECK(has("failed/part.stl"));
  CHECK(has("failed/part.reason.txt"));
}

TEST_CASE_METHOD(JobFilingFixture,
                 "A job whose reason cannot be written is filed, and the error is returned") {
  fs::create_directories(spool.folder(Spool::Folder::Failed) / "part.reason.txt" / "full");
  const std::vector<std::string> troubles = move();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0].starts_with("part: cannot write its reason file: "));
  CHECK(has("failed/part.stl"));
}

TEST_CASE_METHOD(JobFilingFixture, "A job that someone has removed is reported") {
  fs::remove(files.model);
  const std::vector<std::string> troubles = move();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0].ends_with("part.stl is gone: someone removed it"));
}

TEST_CASE_METHOD(JobFilingFixture, "A job that cannot be moved stays in printing/") {
  fs::create_directories(spool.folder(Spool::Folder::Failed) / "part.stl" / "full");
  CHECK_THROWS_AS(move(), std::system_error);
  CHECK(has("printing/part.stl"));
}
