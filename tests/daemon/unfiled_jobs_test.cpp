#include "daemon/unfiled_jobs.hpp"

#include <filesystem>
#include <system_error>

#include "tests/catch.hpp"
#include "tests/daemon/printer_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::PrinterFixture {
 public:
  void leave(const std::string& name, const std::optional<PrintEnd>& end) {
    put(Spool::Folder::Printing, name + ".stl");
    jobs.add(spool.files_of(Spool::Folder::Printing, name + ".stl"), end);
  }

  UnfiledJobs jobs{spool, log.log};
};

}  // namespace

TEST_CASE("Each job that was left is filed by its own end, and one without an end has failed") {
  Desk desk;
  desk.leave("good", PrintEnd{PrintOutcome::Done, ""});
  desk.leave("bad", PrintEnd{PrintOutcome::Failed, "the sky fell"});
  desk.leave("cut", std::nullopt);
  desk.jobs.file_all();
  CHECK(desk.jobs.empty());
  CHECK(desk.has("done/good.stl"));
  CHECK_FALSE(desk.has("done/good.reason.txt"));
  CHECK(desk.has("failed/bad.reason.txt"));
  CHECK(desk.has("failed/cut.reason.txt"));
  CHECK(desk.log.has("info: cut: moved to failed"));
}

TEST_CASE("What cannot be filed stays, with those that come behind it") {
  Desk desk;
  desk.leave("one", PrintEnd{PrintOutcome::Done, ""});
  desk.leave("two", PrintEnd{PrintOutcome::Done, ""});
  const fs::path obstacle = desk.spool.folder(Spool::Folder::Done) / "two.stl";
  fs::create_directories(obstacle / "full");
  CHECK_THROWS_AS(desk.jobs.file_all(), std::system_error);
  CHECK(desk.jobs.last() == "two");
  CHECK(desk.has("printing/one.stl"));
  CHECK(desk.has("printing/two.stl"));
  fs::remove_all(obstacle);
  desk.jobs.file_all();
  CHECK(desk.has("done/one.stl"));
  CHECK(desk.has("done/two.stl"));
}
