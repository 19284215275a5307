#include "daemon/history/history_worker.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "daemon/system/sqlite.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

class HistoryWorkerFixture {
 public:
  // Ends a job and waits until its end is stored or put off.
  void end(const std::string& name) {
    EndedJob job{.name = name, .outcome = "done", .reason = ""};
    worker.end(job).wait();
  }
  [[nodiscard]] std::int64_t stored() const {
    return SqliteDatabase(file, 0ms).integer("SELECT count(*) FROM job");
  }
  // Runs the loop once, until everything that happened to the history so far has been logged, calls `step`,
  // and runs it until that is true again.
  void run(const std::function<void()>& step = [] {}) {
    worker.wear([this, step](const auto&, const std::string&) {
      step();
      worker.wear([this](const auto&, const std::string&) { loop.stop(); });
    });
    loop.run();
  }

 private:
  testing::TemporaryFolder folder_;

 public:
  const fs::path file = folder_.path() / "history.sqlite";
  EventLoop loop;
  testing::LogText log{loop};
  HistoryWorker worker{loop, log.log, file};
};

}  // namespace

TEST_CASE("Changes of a history that another program has locked are made when the lock is gone") {
  HistoryWorkerFixture fixture;
  fixture.end("one");
  {
    SqliteDatabase shell(fixture.file, 0ms);
    const SqliteTransaction transaction(shell);
    fixture.end("two");
    CHECK(fixture.stored() == 1);
  }
  fixture.end("three");
  CHECK(fixture.stored() == 3);
  fixture.run();
  CHECK(fixture.log.has("another program has locked it"));
  CHECK(fixture.log.has("the history can be used again"));
}

TEST_CASE("The latest thousand changes that cannot be made wait, and a loss of others is logged once") {
  HistoryWorkerFixture fixture;
  fs::create_directory(fixture.file);
  for (std::size_t i = 0; i < HistoryWorker::kMostWaiting + 2; ++i) {
    EndedJob job{.name = std::to_string(i), .outcome = "failed", .reason = ""};
    fixture.worker.refuse(job);
  }
  fixture.worker.begin("current");
  JobFigures figures;
  figures.lit_s = 7;
  fixture.worker.note_now(figures);
  fixture.run([&] { fs::remove(fixture.file); });
  SqliteDatabase stored(fixture.file, 0ms);
  CHECK(stored.integer("SELECT count(*) FROM job") == 1'000);
  CHECK(stored.text("SELECT name FROM job ORDER BY id LIMIT 1") == "3");
  CHECK(stored.integer("SELECT count(*) FROM job WHERE lit_s=7") == 0);
  CHECK(fixture.log.count("more than 1000 changes of the history wait to be written") == 1);
}
