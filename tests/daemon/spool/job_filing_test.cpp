#include "daemon/spool/job_filing.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::PrinterFixture {
 public:
  Desk() { put(Spool::Folder::Printing, "part.stl"); }

  void file() { file_job(spool, log.log, files, Spool::Folder::Failed, "no model\n"); }

  JobFiles files{"part", spool.folder(Spool::Folder::Printing) / "part.stl", std::nullopt};
};

}  // namespace

TEST_CASE("A job is filed with its reason beside it") {
  Desk desk;
  desk.file();
  CHECK(desk.has("failed/part.stl"));
  CHECK(desk.has("failed/part.reason.txt"));
  CHECK_FALSE(desk.log.has("error"));
}

TEST_CASE("A job whose reason cannot be written is filed all the same, and that is told") {
  Desk desk;
  fs::create_directories(desk.spool.folder(Spool::Folder::Failed) / "part.reason.txt" / "full");
  desk.file();
  CHECK(desk.has("failed/part.stl"));
  CHECK(desk.log.has("error: part: no reason beside it: "));
}

TEST_CASE("A job that somebody took away is told") {
  Desk desk;
  fs::remove(desk.files.model);
  desk.file();
  CHECK(desk.log.has("part.stl is gone: somebody took it away"));
}

TEST_CASE("A job that cannot be moved stays in printing/, and that is told") {
  Desk desk;
  fs::create_directories(desk.spool.folder(Spool::Folder::Failed) / "part.stl" / "full");
  desk.file();
  CHECK(desk.has("printing/part.stl"));
  CHECK(desk.log.has("error: part: stays in printing: "));
}
