#include "daemon/jobs/unfiled_jobs.hpp"

#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

class Desk : public testing::PrinterFixture {
 public:
  void leave(const std::string& name, const std::optional<PrintEnd>& end) {
    put(Spool::Folder::Printing, name + ".stl");
    jobs.add_left(spool.files_of(Spool::Folder::Printing, name + ".stl"), end);
  }

  std::vector<EndedJob> told;
  UnfiledJobs jobs{spool, log.log, [this](const EndedJob& job) { told.push_back(job); }};
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

TEST_CASE("Of each job that another process left its end is told, and of this one's it is not told twice") {
  Desk desk;
  desk.leave("cut", std::nullopt);
  desk.leave("good", PrintEnd{PrintOutcome::Done, ""});
  desk.put_text(Spool::Folder::Done, "good.report.json", "{}");
  desk.put(Spool::Folder::Printing, "known.stl");
  desk.jobs.add_known(desk.spool.files_of(Spool::Folder::Printing, "known.stl"), {PrintOutcome::Done, ""});
  desk.jobs.file_all();
  CHECK(desk.has("done/known.stl"));
  REQUIRE(desk.told.size() == 2);
  CHECK(desk.told[0].name == "good");
  CHECK(desk.told[0].outcome == "done");
  CHECK(desk.told[0].reports.json == desk.spool.folder(Spool::Folder::Done) / "good.report.json");
  CHECK(desk.told[0].reports.html.empty());
  CHECK(desk.told[1].name == "cut");
  CHECK(desk.told[1].outcome == "failed");
  CHECK(desk.told[1].reason ==
        "The print was interrupted: the power was cut, or contourd was killed or crashed");
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
