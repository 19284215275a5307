#include "daemon/history/history_worker.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <thread>

#include "daemon/system/sqlite.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

class HistoryWorkerFixture {
 public:
  // Begins a job, records its end, and ends it.
  void end(const std::string& name) {
    ends.add({.key = worker.begin(name), .job = name, .outcome = "done"});
    EndedJob job{.name = name, .outcome = "done", .reason = ""};
    worker.end(job);
  }
  // Returns the names of the stored jobs.
  [[nodiscard]] std::string names() const {
    return SqliteDatabase(file, 0ms).text(
        "SELECT group_concat(name, ' ') FROM (SELECT name FROM job ORDER BY id)");
  }
  // Runs the loop once, until everything that happened to the history so far has been logged, calls `step`
  // with what a query answers then, and runs it until that is true again.
  void run(const std::function<void(const std::string& trouble)>& step = [](const std::string&) {}) {
    worker.wear([this, step](const auto&, const std::string& trouble) {
      step(trouble);
      worker.wear([this](const auto&, const std::string&) { loop.stop(); });
    });
    loop.run();
  }

 private:
  TemporaryFolder folder_;

 public:
  const fs::path file = folder_.path() / "history.sqlite";
  EventLoop loop;
  LogText log{loop};
  const StateRecords records{folder_.path()};
  JobEndRecord ends{records};
  HistoryWorker worker{loop, log.log, file, ends};
};

// Returns the recorded ends that the history has not yet taken.
std::vector<std::string> awaited(const JobEndRecord& ends) {
  std::vector<std::string> names;
  for (const JobEndRecord::Pending& each : ends.pending())
    if (each.awaits(EndConsumer::History)) names.push_back(each.end.job + " " + each.end.outcome);
  return names;
}

}  // namespace

TEST_CASE("A history that is a folder, a link or a pipe is reported and left alone, and its changes wait") {
  for (const std::string what : {"is a folder", "is a link, which is not followed", "is not a file"}) {
    CAPTURE(what);
    HistoryWorkerFixture fixture;
    const fs::path target = fixture.file.string() + ".target";
    if (what == "is a folder") {
      fs::create_directory(fixture.file);
    } else if (what == "is not a file") {
      REQUIRE(::mkfifo(fixture.file.c_str(), 0600) == 0);
    } else {
      fs::create_symlink(target, fixture.file);
    }
    fixture.end("one");
    fixture.run([&](const std::string& trouble) {
      CHECK_FALSE(fs::exists(target));
      CHECK_FALSE(fs::exists(fs::symlink_status(fixture.file.string() + ".damaged-1")));
      CHECK(trouble.find("history.sqlite " + what) != std::string::npos);
      fs::remove(fixture.file);
      fixture.end("two");
    });
    CHECK(fixture.names() == "one two");
    CHECK(fixture.log.count("history.sqlite " + what) == 1);
    CHECK(fixture.log.has("the history can be used again"));
  }
}

TEST_CASE(
    "The end of a job remains in the record while the history is locked, and the next process stores it") {
  HistoryWorkerFixture fixture;
  fixture.end("one");
  std::optional<SqliteDatabase> shell;
  std::optional<SqliteTransaction> lock;
  fixture.run([&](const std::string&) {
    shell.emplace(fixture.file, 0ms);
    lock.emplace(*shell);
    fixture.end("two");
  });
  CHECK(fixture.log.has("another program has locked it"));
  CHECK(fixture.names() == "one");
  CHECK(awaited(fixture.ends) == std::vector<std::string>{"two done"});
  lock.reset();
  shell.reset();
  EventLoop loop;
  const LogText log{loop};
  JobEndRecord ends(fixture.records);
  HistoryWorker next(loop, log.log, fixture.file, ends);
  next.adopt_recorded_ends();
  while (!awaited(ends).empty())
    std::this_thread::yield();
  CHECK(fixture.names() == "one two");
}

TEST_CASE("The latest thousand changes that cannot be made wait, and a loss of others is logged once") {
  HistoryWorkerFixture fixture;
  fs::create_directory(fixture.file);
  for (std::size_t i = 0; i < HistoryWorker::kMostWaiting + 2; ++i) {
    EndedJob job{.name = std::to_string(i), .outcome = "failed", .reason = "", .key = new_job_key()};
    fixture.worker.refuse(job);
  }
  fixture.worker.begin("current");
  JobFigures figures;
  figures.lit_s = 7;
  fixture.worker.note_now(figures);
  fixture.run([&](const std::string&) { fs::remove(fixture.file); });
  SqliteDatabase stored(fixture.file, 0ms);
  CHECK(stored.integer("SELECT count(*) FROM job") == 1'000);
  CHECK(stored.text("SELECT name FROM job ORDER BY id LIMIT 1") == "3");
  CHECK(stored.integer("SELECT count(*) FROM job WHERE lit_s=7") == 0);
  CHECK(fixture.log.count("more than 1000 changes of the history wait to be written") == 1);
}
