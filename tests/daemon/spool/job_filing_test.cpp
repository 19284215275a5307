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

TEST_CASE("A job is filed with its reason beside it") {
  JobFilingFixture fixture;
  CHECK(fixture.move().empty());
  CHECK(fixture.has("failed/part.stl"));
  CHECK(fixture.has("failed/part.reason.txt"));
}

TEST_CASE("A job whose reason cannot be written is filed, and the error is returned") {
  JobFilingFixture fixture;
  fs::create_directories(fixture.spool.folder(Spool::Folder::Failed) / "part.reason.txt" / "full");
  const std::vector<std::string> troubles = fixture.move();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0].starts_with("part: cannot write its reason file: "));
  CHECK(fixture.has("failed/part.stl"));
}

TEST_CASE("A job that someone has removed is reported") {
  JobFilingFixture fixture;
  fs::remove(fixture.files.model);
  const std::vector<std::string> troubles = fixture.move();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0].ends_with("part.stl is gone: someone removed it"));
}

TEST_CASE("A job that cannot be moved stays in printing/") {
  JobFilingFixture fixture;
  fs::create_directories(fixture.spool.folder(Spool::Folder::Failed) / "part.stl" / "full");
  CHECK_THROWS_AS(fixture.move(), std::system_error);
  CHECK(fixture.has("printing/part.stl"));
}
